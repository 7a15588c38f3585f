"""Builds z_plasty.usda: two 60° flaps with limbs of 20 mm on taut skin of 100 x 80 x 4 mm, transposed and sutured.

Usage: python build.py [z_plasty.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from lappet.designs import ZPlasty, oval, z_plasty
from lappet.procedure import Event, Hook, Incision, Landmark, Point, Procedure, Suture, Undermine
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import TAUT_SKIN
from lappet.usd.stage import write_procedure

LIMB, ANGLE, THICKNESS = 20.0, 60.0, 4.0  # mm, degrees, mm
KERF = 0.05
INCISE, UNDERMINE, LIFT, TRANSPOSED, CLOSED, RELEASE, END = 3, 6, 8, 26, 36, 38, 40  # time codes
# Rows of sutures: name, height of the anchors above the underside (mm), stitches along a limb, first frame.
# The buried rows hold the walls of the wound together, so that the stitches on the skin only have to meet its edges.
ROWS = (("deep", 0.8, 10, TRANSPOSED), ("dermal", 3.4, 14, TRANSPOSED), ("skin", THICKNESS, 10, TRANSPOSED))
# The ways of the hooks: time code, degrees by which the flap is turned up about its base, share of the way over. The
# first flap is turned back out of the way of the second, which passes below it and is laid down first.
INSIDE = 1.5  # mm from a flap's tip to its hook
LAID_SHORT = 4.0  # mm from the corner of the wound to where the hook is laid, along the edge that the flap meets
Way = tuple[tuple[float, float, float], ...]
TURNED_BACK: Way = ((13, 105.0, 0.0), (19, 105.0, 0.0), (23, 45.0, 0.6), (26, 0.0, 1.0))
PASSES_BELOW: Way = ((12, 45.0, 0.0), (17, 38.0, 0.7), (20, 0.0, 1.0))
BESIDE = KERF / 2 + 0.01  # mm from the middle of the cut to an anchor


def point(xyz: np.ndarray) -> Point:
    """A tuple of floats."""
    return (float(xyz[0]), float(xyz[1]), float(xyz[2]))


def across(edge: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """The unit vector across an edge (its direction) towards a point beside it, from the edge's start at the origin."""
    along = edge / np.linalg.norm(edge)
    normal = inside - np.dot(inside, along) * along
    return normal / np.linalg.norm(normal)


def sutures(design: ZPlasty) -> list[Event]:
    """Three rows of sutures along each of the three limbs of the closed Z."""
    a, b, c, d = (np.array(p) for p in design.curve)
    flap_1, flap_2 = (a + b + c) / 3, (b + c + d) / 3
    # The edges that meet: from, to, which way their tissue lies; shares of them to the first and the last suture. The
    # outer limbs begin at the tip of a flap, which their first suture holds, and end at its base, where the skin was
    # never cut; the new central limb ends at two tips.
    seams = (
        ("left", (b, c, across(c - b, flap_1 - b)), (d, c, -across(c - d, flap_2 - d)), 0.03, 0.9),
        ("right", (c, b, across(b - c, flap_2 - c)), (a, b, -across(b - a, flap_1 - a)), 0.03, 0.9),
        ("middle", (b, a, across(a - b, flap_1 - b)), (d, c, across(d - c, flap_2 - d)), 0.05, 0.95),
    )
    events: list[Event] = []
    for row, height, count, start in ROWS:
        for name, (p0, p1, p_side), (q0, q1, q_side), first, last in seams:
            for k, share in enumerate(np.linspace(first, last, count)):
                ends = [p0 + share * (p1 - p0) + BESIDE * p_side, q0 + share * (q1 - q0) + BESIDE * q_side]
                anchors = tuple((float(e[0]), float(e[1]), height) for e in ends)
                events.append(
                    Suture(f"{row}_{name}_{k + 1}", (anchors[0], anchors[1]), start=start, duration=CLOSED - start)
                )
    return events


def hook(name: str, tip: np.ndarray, base: np.ndarray, to: np.ndarray, edge: np.ndarray, way: Way) -> Hook:
    """Turns a flap up about its base by its tip, carries it over and lays it down near `to`, on the side of `edge`."""
    inward = base - tip
    length = float(np.linalg.norm(inward)) - INSIDE
    inward = inward / np.linalg.norm(inward)
    anchor = tip + INSIDE * inward
    lay = to + LAID_SHORT * (edge - to) / np.linalg.norm(edge - to)
    targets = [(float(LIFT), point(anchor))]
    for time, turned, over in way:
        angle = np.radians(turned)
        raised = base - np.cos(angle) * length * inward
        level = raised + over * (lay - raised)
        targets.append((float(time), point(level + np.sin(angle) * length * np.array([0.0, 0.0, 1.0]))))
    return Hook(name=name, anchor=point(anchor), targets=tuple(targets), start=LIFT, release=RELEASE, stiffness=300.0)


def build() -> Procedure:
    """The whole procedure."""
    design = z_plasty((0.0, 0.0, THICKNESS), (1.0, 0.0, 0.0), LIMB, ANGLE)
    a, b, c, d = (np.array(p) for p in design.curve)
    events: list[Event] = [
        Incision("incision", INCISE, design.curve, kerf=KERF),
        Undermine("undermining", UNDERMINE, oval((0.0, 0.0, THICKNESS), 30.0, 48.0, (1.0, 0.0, 0.0))),
        hook("hook_1", b, (a + c) / 2, d, c, TURNED_BACK),
        hook("hook_2", c, (b + d) / 2, a, b, PASSES_BELOW),
        *sutures(design),
        # Beside the wound, and on the two flaps: what to measure.
        Landmark("scar_ends", (point(b + np.array([2.5, 0, 0])), point(c - np.array([2.5, 0, 0]))), "scar end"),
        Landmark("scar_sides", (point(a + np.array([0, 2.5, 0])), point(d - np.array([0, 2.5, 0]))), "scar side"),
        Landmark("flap_tips", (point(b + 0.05 * (a + c - 2 * b)), point(c + 0.05 * (b + d - 2 * c))), "flap tip"),
        Landmark("flap_middles", (point((a + b + c) / 3), point((b + c + d) / 3)), "flap middle"),
    ]
    return Procedure(
        tissue=flat_patch((100.0, 80.0, THICKNESS), resolution=2.0, material="taut_skin", spacing=1.0),
        materials=(TAUT_SKIN.material,),
        events=tuple(events),
        start_time=1,
        end_time=END,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("z_plasty.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
