"""Builds ellipse.usda: a 3 : 1 fusiform of 36 x 12 mm excised from a flat patch of 100 x 80 x 4 mm and closed.

Usage: python build.py [ellipse.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from lappet.designs import Fusiform, fusiform, oval
from lappet.procedure import Event, Excision, Hook, Incision, Landmark, Point, Procedure, Suture, Undermine
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.usd.stage import write_procedure

LENGTH, WIDTH, THICKNESS = 36.0, 12.0, 4.0  # mm
SPACING = 1.25  # mm, of the lattice
KERF = 0.05
BEYOND = 18.0  # mm that the skin is undermined beyond the wound
INCISE, EXCISE, UNDERMINE, LIFT, PULL, END = 2, 4, 6, 7, 9, 26  # time codes
RELEASE = 15  # of the hooks
STITCHES, BURIED = 2.0, 1.5  # mm between the stitches on the skin and between the sutures of each buried row, or so
TIED, SPREAD = 22, 4  # when the middle is tied; the tips so many frames later
MEASURED = 23  # points of each edge to follow, besides the tips
EDGE = 0.12  # mm from the cut to a point on the skin
SUBCUTIS, DERMIS = 1.2, 2.9  # mm above the underside: the buried rows of sutures, on the wound wall


def point(xyz: np.ndarray) -> Point:
    """A tuple of floats, rounded so that every machine writes the same file."""
    return (round(float(xyz[0]), 6), round(float(xyz[1]), 6), round(float(xyz[2]), 6))


def design(pairs: int) -> Fusiform:
    """The fusiform with so many pairs of facing points."""
    return fusiform((0.0, 0.0, THICKNESS), LENGTH, WIDTH, (1.0, 0.0, 0.0), sutures=pairs)


def beside(on_arc: Point, distance: float, height: float) -> Point:
    """The point so far from the wound's edge, away from the wound (along the arc's radius), at a height."""
    radius = (LENGTH**2 + WIDTH**2) / (4.0 * WIDTH)
    x, y, _ = on_arc
    away = np.array([x, y + np.sign(y) * (radius - WIDTH / 2)])
    x, y = np.array([x, y]) + distance * away / np.linalg.norm(away)
    return point(np.array([x, y, height]))


def sutures(spacing: float) -> list[Event]:
    """Two buried rows on the wound wall and stitches on the skin; the middle is drawn together first, the tips last.

    They keep apart by 1.2 cells at least: sutures that share a cell's edge contradict each other.
    """
    events: list[Event] = []
    rows = [("subcutis", BURIED, KERF / 2, SUBCUTIS), ("dermis", BURIED, KERF / 2, DERMIS)]
    rows.append(("skin", STITCHES, EDGE, THICKNESS))
    for row, apart, distance, height in rows:
        count = round(LENGTH / max(apart, 1.2 * spacing)) - 1
        for i, (far, near) in enumerate(design(count).pairs):
            late = round(SPREAD * abs(2 * i / (count - 1) - 1))  # frames after the middle
            start, tied = PULL + late, TIED + late
            anchors = (beside(far, distance, height), beside(near, distance, height))
            events.append(Suture(f"{row}_{i + 1}", anchors, start=start, duration=tied - start))
    return events


def hooks() -> list[Event]:
    """Two skin hooks that lift the edges to undermine them, and let go when the sutures have begun to pull."""
    events: list[Event] = []
    for name, side in (("far", 1.0), ("near", -1.0)):
        anchor = np.array([0.0, side * (WIDTH / 2 + 1.5), THICKNESS])
        lifted = anchor + np.array([0.0, -1.5 * side, 6.0])
        low = anchor + np.array([0.0, -3.0 * side, 1.0])
        half = 0.3 * anchor + 0.7 * lifted
        path = [(LIFT, anchor), (LIFT + 1, half), (LIFT + 3, lifted), (LIFT + 5, lifted), (RELEASE, low)]
        targets = tuple((time, point(target)) for time, target in path)
        events.append(Hook(f"hook_{name}", point(anchor), targets, start=LIFT, release=RELEASE, stiffness=200.0))
    return events


def landmarks() -> list[Event]:
    """The two edges as chains of points on the skin from tip to tip, to measure the scar and what still gapes."""
    tips = [point(np.array(tip) + np.array([np.sign(tip[0]) * EDGE, 0.0, 0.0])) for tip in design(0).tips]
    chains = []
    for side in (0, 1):
        chains.append((tips[0], *(beside(pair[side], EDGE, THICKNESS) for pair in design(MEASURED).pairs), tips[1]))
    return [Landmark("far_edge", chains[0], "far edge"), Landmark("near_edge", chains[1], "near edge")]


def build(spacing: float = SPACING) -> Procedure:
    """The whole procedure; spacing: of the lattice, mm."""
    whole = design(0)
    area = oval((0.0, 0.0, THICKNESS), LENGTH + 2 * BEYOND, WIDTH + 2 * BEYOND, (1.0, 0.0, 0.0))
    events: list[Event] = [
        Incision("incision", INCISE, whole.curve, kerf=KERF, closed=True),
        Excision("excision", EXCISE, (whole.seed,)),
        Undermine("undermining", UNDERMINE, tuple(point(np.array(p)) for p in area)),
        *hooks(),
        *sutures(spacing),
        *landmarks(),
    ]
    return Procedure(
        tissue=flat_patch((100.0, 80.0, THICKNESS), resolution=2.0, spacing=spacing),
        materials=(SKIN.material,),
        events=tuple(events),
        start_time=1,
        end_time=END,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("ellipse.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
