"""Builds stitches.usda: an ellipse of 30 x 5 mm in a flat patch of 80 x 60 x 4 mm, sewn in three layers.

Buried deep dermal stitches bring the edges together, vertical mattress stitches hold them, and a running suture closes
the skin.

Usage: python build.py [stitches.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from lappet.designs import fusiform, oval
from lappet.procedure import Event, Excision, Incision, Landmark, Point, Procedure, Undermine
from lappet.procedure.stitches import Station, Stitch, deep_dermal, running, vertical_mattress
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.usd.stage import write_procedure

LENGTH, WIDTH, THICKNESS = 30.0, 5.0, 4.0  # mm
SPACING = 1.0  # mm, of the lattice
KERF = 0.05
BEYOND = 8.0  # mm that the skin is undermined beyond the wound
INCISE, EXCISE, UNDERMINE, BURY, HOLD, RUN, END = 2, 4, 6, 8, 14, 18, 24  # time codes
DRAW = 4  # frames in which a stitch is drawn
DERMAL = np.linspace(-10.5, 10.5, 7)  # x of the buried stitches, mm
MATTRESS = (-5.25, 5.25)  # of the vertical mattress stitches
RUNNING = np.linspace(-12.0, 12.0, 9)  # of the passes of the running suture
# Shares of the length at which the edges just meet to which each is drawn: the skin gives way at the bites.
DERMAL_DRAWN, MATTRESS_DRAWN, RUNNING_DRAWN = 0.92, 1.0, 0.95
EDGE = 0.12  # mm from the cut to a point on the skin
MEASURED = 17  # points of each edge to follow


def point(xyz: np.ndarray) -> Point:
    """A tuple of floats, rounded so that every machine writes the same file."""
    return (round(float(xyz[0]), 6), round(float(xyz[1]), 6), round(float(xyz[2]), 6))


def half_width(x: float) -> float:
    """Half the width of the wound at x, mm: two arcs from tip to tip."""
    radius = (LENGTH**2 + WIDTH**2) / (4.0 * WIDTH)
    return float(np.sqrt(radius**2 - x**2) - (radius - WIDTH / 2))


def station(x: float) -> Station:
    """The place at x on the wound."""
    return Station((round(float(x), 6), 0.0, THICKNESS), (0.0, 1.0, 0.0), gap=round(2.0 * half_width(x) + KERF, 6))


def rounded(stitch: Stitch) -> Stitch:
    """The stitch with bites as every machine writes them."""
    return Stitch(tuple(point(np.array(bite)) for bite in stitch.bites), round(stitch.length, 6))


def sutures() -> list[Event]:
    """The three layers; of the buried one the middle is drawn together first."""
    events: list[Event] = []
    for k, x in enumerate(DERMAL):
        late = round(2 * abs(2 * k / (len(DERMAL) - 1) - 1))  # frames after the middle
        stitch = rounded(deep_dermal(station(x), depth=3.0, shallow=1.5, bite=2.5))
        thread = stitch.suture(f"dermal_{k + 1}", BURY + late, DERMAL_DRAWN, duration=DRAW, thread="polydioxanone 4-0")
        events.append(thread)
    for k, x in enumerate(MATTRESS):
        stitch = rounded(vertical_mattress(station(x), depth=2.5, far=5.0, near=1.5))
        events.append(stitch.suture(f"mattress_{k + 1}", HOLD, MATTRESS_DRAWN, duration=DRAW, thread="nylon 4-0"))
    stitch = rounded(running([station(x) for x in RUNNING], bite=2.5, depth=1.5))
    events.append(stitch.suture("running", RUN, RUNNING_DRAWN, duration=DRAW, thread="nylon 5-0"))
    return events


def landmarks() -> list[Event]:
    """The two edges as chains of points on the skin, to measure how they meet and stand up."""
    places = np.linspace(-12.0, 12.0, MEASURED)
    chains = (
        tuple(point(np.array([x, side * (half_width(x) + EDGE), THICKNESS])) for x in places) for side in (1.0, -1.0)
    )
    return [
        Landmark(f"{name}_edge", chain, f"{name} edge") for name, chain in zip(("far", "near"), chains, strict=True)
    ]


def build(spacing: float = SPACING) -> Procedure:
    """The whole procedure; spacing: of the lattice, mm."""
    whole = fusiform((0.0, 0.0, THICKNESS), LENGTH, WIDTH, (1.0, 0.0, 0.0))
    area = oval((0.0, 0.0, THICKNESS), LENGTH + 2 * BEYOND, WIDTH + 2 * BEYOND, (1.0, 0.0, 0.0))
    events: list[Event] = [
        Incision("incision", INCISE, whole.curve, kerf=KERF, closed=True),
        Excision("excision", EXCISE, (whole.seed,)),
        Undermine("undermining", UNDERMINE, tuple(point(np.array(p)) for p in area)),
        *sutures(),
        *landmarks(),
    ]
    return Procedure(
        tissue=flat_patch((80.0, 60.0, THICKNESS), resolution=2.0, spacing=spacing),
        materials=(SKIN.material,),
        events=tuple(events),
        start_time=1,
        end_time=END,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("stitches.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
