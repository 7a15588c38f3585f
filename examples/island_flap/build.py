"""Builds island_flap.usda: a V–Y island flap of the cheek on its subcutaneous pedicle, with the perforator in it.

A lesion is excised with a square of 8 mm through skin and fat; a V of 20 mm beside it is cut through the skin alone, so
that the island stays on the fat below it. It is advanced into the defect by 7 mm, and the V is closed behind it as a Y.

Usage: python build.py [island_flap.usda]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from lappet.procedure import Event, Excision, Hook, Incision, Landmark, Point, Procedure, Suture, Vessel
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets.layers import skin_over_fat
from lappet.usd.stage import write_procedure

SIZE = (60.0, 44.0, 8.0)  # mm
TOP, SKIN = SIZE[2], 2.0
HALF, BASE, LENGTH = 4.0, 3.6, 20.0  # half of the defect, half of the island's base, length of the V, mm
DEPTH, KERF = 3.2, 0.05  # of the V: through the skin and a little fat
ADVANCE = 7.0  # mm
BESIDE = KERF / 2 + 0.01  # mm from the middle of the cut to an anchor
HEIGHTS = (("deep", TOP - 1.5), ("skin", TOP))
EXCISE, INCISE, LIFT, LAID, CLOSED, RELEASE, END = 3, 5, 6, 12, 18, 19, 20  # time codes

CORNER = np.array([HALF, BASE])  # of the island's base, upper side
APEX = np.array([HALF + LENGTH, 0.0])
LIMB = float(np.linalg.norm(APEX - CORNER))
ALONG = (APEX - CORNER) / LIMB
ASIDE = np.array([-ALONG[1], ALONG[0]])  # out of the island


def on_limb(along: float, side: float, off: float) -> np.ndarray:
    """A place so far along a limb of the V from the base in mm, upper (1) or lower (-1), so far out of the island."""
    x, y = CORNER + along * ALONG + off * ASIDE
    return np.array([x, side * y])


def pairs() -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """What is sewn to what: a name, a place in the plane on the island or the upper edge, and its partner."""
    for k, y in enumerate(np.linspace(-0.85, 0.85, 5)):
        yield f"front_{k + 1}", np.array([HALF + BESIDE, y * BASE]), np.array([-HALF - BESIDE, y * HALF])
    for name, side in (("upper", 1.0), ("lower", -1.0)):
        for k, along in enumerate((1.0, 3.0, 5.0)):
            island = on_limb(along, side, -BESIDE)
            yield f"{name}_{k + 1}", island, np.array([island[0] - ADVANCE, side * (HALF + BESIDE)])
        for k, along in enumerate(np.linspace(ADVANCE + 1.0, LIMB - 1.0, 5), start=4):
            yield f"{name}_{k}", on_limb(along, side, -BESIDE), on_limb(along - ADVANCE, side, BESIDE)
    for k, along in enumerate(np.linspace(LIMB - ADVANCE + 1.5, LIMB - 1.5, 3)):
        yield f"tail_{k + 1}", on_limb(along, 1.0, BESIDE), on_limb(along, -1.0, BESIDE)


def sutures() -> list[Event]:
    """Two rows: one in the dermis, one on the skin."""
    events: list[Event] = []
    for row, height in HEIGHTS:
        for name, one, two in pairs():
            ends: list[Point] = [(float(x), float(y), height) for x, y in (one, two)]
            events.append(Suture(f"{row}_{name}", (ends[0], ends[1]), start=LAID, duration=CLOSED - LAID))
    return events


def vessels() -> tuple[Vessel, ...]:
    """The artery below, the perforator that rises through the pedicle into the island, its vein."""
    rise = ((17.0, 0.0, 0.8), (16.0, 0.0, 2.0), (13.5, 0.0, 4.2), (10.5, 0.0, 5.6), (7.0, 0.0, 6.2), (5.0, 0.0, 6.3))
    beside = tuple((x - 0.4, -1.1, z) for x, _, z in rise)
    trunk = tuple((17.0 + 1.5 * np.sin(y / 8.0), y, 0.8) for y in np.linspace(-20.0, 20.0, 9))
    return (
        Vessel("trunk", trunk, "artery", 0.7, "facial artery", typical_course=True, basis="linear"),
        Vessel("perforator", rise, "artery", 0.45, "perforator"),
        Vessel("comitans", beside, "vein", 0.45, "comitant vein"),
    )


def build(spacing: float = 1.0) -> Procedure:
    """The whole procedure."""
    square = ((-HALF, -HALF, TOP), (HALF, -HALF, TOP), (HALF, HALF, TOP), (-HALF, HALF, TOP))
    ends = [on_limb(-0.5, side, 0.0) for side in (1.0, -1.0)]
    v = tuple((float(x), float(y), TOP) for x, y in (ends[0], APEX, ends[1]))
    anchor = (HALF + 2.5, 0.0, TOP)
    raised = (HALF + 2.5 - 0.4 * ADVANCE, 0.0, TOP + 1.5)
    laid = (HALF + 2.5 - ADVANCE, 0.0, TOP)
    events = (
        Incision("around", EXCISE, square, kerf=KERF, closed=True),
        Excision("lesion", EXCISE, ((0.0, 0.0, TOP),)),
        Incision("v", INCISE, v, DEPTH, KERF),
        Hook("advance", anchor, ((LIFT, anchor), (LIFT + 3, raised), (LAID, laid)), LIFT, RELEASE, 300.0),
        *sutures(),
        Landmark("base", ((HALF + 1.0, 0.0, TOP),), "middle of the base"),
        Landmark("below", ((HALF + 8.0, 0.0, 1.0),), "fat below the island"),
    )
    procedure = Procedure(flat_patch(SIZE, resolution=2.0, spacing=spacing), events=events, end_time=END)
    layered = skin_over_fat(procedure, SKIN)
    return Procedure(layered.tissue, layered.materials, events, end_time=END, vessels=vessels())


if __name__ == "__main__":
    write_procedure(build(), Path(sys.argv[1] if len(sys.argv) > 1 else "island_flap.usda"))
