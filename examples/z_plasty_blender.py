"""The Z-plasty of the README made in Blender, through Lappet's operators only: what a classroom would script.

Usage: blender --python z_plasty_blender.py -- [--spacing MM] [--solve] [--save FILE.blend] [--export FILE.usda]
       python z_plasty_blender.py [the same options]           (with Blender as a Python module: pip install bpy)

Two 60° flaps with limbs of 20 mm on a sheet of skin of 100 x 80 x 4 mm: cut, undermined, carried over by two hooks and
sutured in three rows. `z_plasty/build.py` builds the same procedure without Blender.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]

LIMB, ANGLE, THICKNESS, KERF = 20.0, 60.0, 4.0, 0.05  # mm, degrees, mm, mm
INCISE, UNDERMINE, LIFT, TRANSPOSED, CLOSED, RELEASE, END = 3, 6, 8, 26, 36, 38, 40  # frames
# Rows of sutures: name, height of the anchors above the underside (mm), stitches along a limb.
ROWS = (("deep", 0.8, 10), ("dermal", 3.4, 14), ("skin", THICKNESS, 10))
# The ways of the hooks: frame, degrees by which the flap is turned up about its base, share of the way over. The first
# flap is turned back out of the way of the second, which passes below it and is laid down first.
INSIDE, LAID_SHORT = 1.5, 4.0  # mm from a flap's tip to its hook, and from the wound's corner to where that is laid
Way = tuple[tuple[float, float, float], ...]
TURNED_BACK: Way = ((13, 105.0, 0.0), (19, 105.0, 0.0), (23, 45.0, 0.6), (26, 0.0, 1.0))
PASSES_BELOW: Way = ((12, 45.0, 0.0), (17, 38.0, 0.7), (20, 0.0, 1.0))
BESIDE = KERF / 2 + 0.01  # mm from the middle of the cut to an anchor
EAST, NORTH, UP = np.eye(3)


def points(places: Iterable[Any]) -> list[dict[str, Any]]:
    """Places in mm as operators take a list of them; Blender wants a name for each, which may be empty."""
    return [{"name": "", "co": tuple(float(v) for v in place)} for place in places]


def keys(path: Iterable[tuple[float, Vector]]) -> list[dict[str, Any]]:
    """(frame, place in mm) as the operators take keyframes."""
    return [{"name": "", "frame": time, "co": tuple(place), "rotation": (0.0, 0.0, 0.0)} for time, place in path]


def build(spacing: float = 1.0) -> None:
    """Makes the procedure in the scene that is open."""
    from lappet.designs import z_plasty

    scene = bpy.context.scene
    scene.unit_settings.scale_length = 0.001  # one unit is a millimetre
    scene.unit_settings.length_unit = "MILLIMETERS"
    scene.frame_start, scene.frame_end, scene.render.fps = 1, END, 12

    # The bare mesh, a grid of 2 mm; its thickness is given to the tissue, which holds its rim and beds its underside.
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=50, y_subdivisions=40, size=1.0, location=(0.0, 0.0, THICKNESS))
    bpy.context.object.name = "Skin"
    bpy.context.object.scale = (100.0, 80.0, 1.0)
    bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    lappet = bpy.ops.lappet
    lappet.tissue_set(object="Skin", thickness=THICKNESS, spacing=spacing, preset="TAUT_SKIN")

    design = z_plasty((0.0, 0.0, THICKNESS), (1.0, 0.0, 0.0), LIMB, ANGLE)
    a, b, c, d = (np.array(corner) for corner in design.curve)
    lappet.incision_add(name="incision", points=points(design.curve), time=INCISE, kerf=KERF)
    turn = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)
    around = [(15 * np.cos(t), 24 * np.sin(t), THICKNESS) for t in turn]
    lappet.undermine_add(name="undermining", points=points(around), time=UNDERMINE)
    hook("hook_1", b, (a + c) / 2, d, c, TURNED_BACK)
    hook("hook_2", c, (b + d) / 2, a, b, PASSES_BELOW)
    sew(a, b, c, d)
    # Beside the wound, and on the two flaps: what to measure.
    for name, label, marks in (
        ("scar_ends", "scar end", (b + 2.5 * EAST, c - 2.5 * EAST)),
        ("scar_sides", "scar side", (a + 2.5 * NORTH, d - 2.5 * NORTH)),
        ("flap_tips", "flap tip", (b + 0.05 * (a + c - 2 * b), c + 0.05 * (b + d - 2 * c))),
        ("flap_middles", "flap middle", ((a + b + c) / 3, (b + c + d) / 3)),
    ):
        lappet.landmark_add(name=name, label=label, points=points(marks))


def hook(name: str, tip: Vector, base: Vector, to: Vector, edge: Vector, way: Way) -> None:
    """Turns a flap up about its base by its tip, carries it over and lays it down near `to`, on the side of `edge`."""
    length = float(np.linalg.norm(base - tip)) - INSIDE
    inward = (base - tip) / np.linalg.norm(base - tip)
    anchor = tip + INSIDE * inward
    lay = to + LAID_SHORT * (edge - to) / np.linalg.norm(edge - to)
    path = [(float(LIFT), anchor)]
    for time, turned, over in way:
        angle = np.radians(turned)
        raised = base - np.cos(angle) * length * inward
        path.append((float(time), raised + over * (lay - raised) + np.sin(angle) * length * UP))
    bpy.ops.lappet.hook_add(name=name, anchor=anchor, keys=keys(path), start=LIFT, end=RELEASE, stiffness=300.0)


def sew(a: Vector, b: Vector, c: Vector, d: Vector) -> None:
    """Three rows of sutures along each of the three limbs of the closed Z."""
    flap_1, flap_2 = (a + b + c) / 3, (b + c + d) / 3
    # The edges that meet: from, to, which way their tissue lies; shares of them to the first and the last suture. The
    # outer limbs begin at the tip of a flap, which their first suture holds, and end at its base, where the skin was
    # never cut; the new central limb ends at two tips.
    seams = (
        ("left", (b, c, across(c - b, flap_1 - b)), (d, c, -across(c - d, flap_2 - d)), 0.03, 0.9),
        ("right", (c, b, across(b - c, flap_2 - c)), (a, b, -across(b - a, flap_1 - a)), 0.03, 0.9),
        ("middle", (b, a, across(a - b, flap_1 - b)), (d, c, across(d - c, flap_2 - d)), 0.05, 0.95),
    )
    for row, height, count in ROWS:
        for name, one, other, first, last in seams:
            edges = [[at_height(p + BESIDE * side, height) for p in (p0, p1)] for p0, p1, side in (one, other)]
            bpy.ops.lappet.suture_run(
                name=f"{row}_{name}",
                first_edge=points(edges[0]),
                second_edge=points(edges[1]),
                count=count,
                single=True,
                inset_start=first,
                inset_end=1.0 - last,
                start=TRANSPOSED,
                duration=CLOSED - TRANSPOSED,
            )


def at_height(place: Vector, height: float) -> Vector:
    """The place so far above the underside."""
    return np.array([place[0], place[1], height])


def across(edge: Vector, inside: Vector) -> Vector:
    """The unit vector across an edge (its direction) towards a point beside it, from the edge's start at the origin."""
    along = edge / np.linalg.norm(edge)
    normal = inside - np.dot(inside, along) * along
    return np.asarray(normal / np.linalg.norm(normal))


def have_lappet() -> None:
    """The extension switched on; outside of Blender's program the add-on itself, registered."""
    if hasattr(bpy.types.Scene, "lappet"):
        return
    try:
        import lappet_blender
    except ModuleNotFoundError:
        sys.exit("Lappet is not there; install its extension in Edit > Preferences > Get Extensions first.")
    lappet_blender.register()


def main() -> None:
    """Builds the procedure, and does what the options say."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spacing", type=float, default=1.0, help="of the lattice, mm")
    parser.add_argument("--solve", action="store_true", help="solve all frames before going on")
    parser.add_argument("--save", metavar="FILE.blend", help="save the file")
    parser.add_argument("--export", metavar="FILE.usda", help="write the procedure for lappet solve")
    inside = "--python" in sys.argv or "-P" in sys.argv
    own = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [] if inside else sys.argv[1:]
    options = parser.parse_args(own)
    have_lappet()
    if not bpy.data.filepath:  # the cube, the light and the camera of a new file
        for each in list(bpy.context.scene.objects):
            bpy.data.objects.remove(each)
    build(options.spacing)
    if options.solve:
        bpy.ops.lappet.solve(wait=True)
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=options.save)
    if options.export:
        bpy.ops.lappet.export_procedure(filepath=options.export)


if __name__ == "__main__":
    main()
