"""Builds prestretched_incision.usda: two equal cuts in taut skin, one along its tension lines and one across.

Usage: python build.py [prestretched_incision.usda]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from lappet.procedure import Event, Incision, Landmark, Point, Procedure
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN, skin_over_fat
from lappet.usd.stage import write_procedure

SIZE = (100.0, 60.0, 4.0)  # mm
SKIN_THICKNESS = 2.0  # mm; fat below
SPACING = 1.0  # mm, of the lattice
LENGTH = 24.0  # mm, of each cut
KERF = 0.05
LEFT, RIGHT = -18.0, 30.0  # x of the middles of the cuts, mm
EDGE = 0.12  # mm from the cut to a point on its lip
ALONG, ACROSS, END = 3, 5, 6  # time codes
# The relaxed skin tension lines run along x: there the fibers run, and there the skin is tauter.
TAUT = replace(
    SKIN.material,
    poissons_ratio=0.49,
    fiber_k1=15.0,
    fiber_k2=1.0,
    fiber_dispersion=0.2,
    fiber_slack=1.0,
    fiber_direction=(1.0, 0.0, 0.0),
    prestretch=(1.2, 1.08),
)


def cut(name: str, time: float, middle: float, direction: tuple[float, float], label: str) -> list[Event]:
    """A straight cut through the patch and two facing points of its lips to measure how far it gapes."""
    dx, dy = direction
    half, top = LENGTH / 2, SIZE[2]

    def at(along: float, aside: float) -> Point:
        return (middle + along * dx - aside * dy, along * dy + aside * dx, top)

    return [
        Incision(f"cut_{name}", time, (at(-half, 0.0), at(half, 0.0)), kerf=KERF),
        Landmark(f"{name}_lips", (at(0.0, EDGE), at(0.0, -EDGE)), label),
    ]


def build(spacing: float = SPACING, prestretch: tuple[float, float] = TAUT.prestretch) -> Procedure:
    """The whole procedure; spacing: of the lattice, mm; prestretch: of the skin, along and across its tension lines."""
    plain = Procedure(
        tissue=flat_patch(SIZE, resolution=2.0, spacing=spacing),
        events=(
            *cut("along", ALONG, LEFT, (1.0, 0.0), "along the lines"),
            *cut("across", ACROSS, RIGHT, (0.0, 1.0), "across the lines"),
        ),
        start_time=1,
        end_time=END,
        fps=4,
    )
    return skin_over_fat(plain, SKIN_THICKNESS, replace(TAUT, prestretch=prestretch))


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("prestretched_incision.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
