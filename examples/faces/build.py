"""Builds a flap on a face: a model of the body (`lappet models`) and a design of the flap library (`lappet flap`).

The meshes are those of a package that `lappet models fetch` fetches; so the procedures are not kept here but written.

Usage: python build.py cheek_limberg [cheek_limberg.usda]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs.library_operation import add_flap, skin_line_direction
from lappet.models.body_shape import BodyShape
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import new_model
from lappet.procedure import Landmark, Point, Procedure, Region
from lappet.tissue.presets import PRESETS
from lappet.tissue.presets.layers import FAT_FACES
from lappet.tissue.skin_sheet import SkinSheet
from lappet.tissue.uniaxial import prestretch_for
from lappet.usd.stage import write_procedure


class Operation(NamedTuple):
    """A model, a design on it, where it lies (mm), its direction (or how to the skin lines), and its measures."""

    model: str
    design: str
    at: Point
    direction: Point | Literal["along", "across"]
    measures: dict[str, float]
    mirrored: bool = False
    targets: tuple[tuple[str, float], ...] = ()  # of the body's shape
    scar: tuple[float, float] | None = None  # length and width in mm of a contracted scar along the direction


CONTRACTED = (10.0, 40.0)  # kPa in a scar across the skin lines: of the preset, and along the band; chosen
# An upper lid that hangs over its crease, on both eyes.
HOODED = tuple((f"eyes/{side}-eye-eyefold-{what}", 1.0) for side in "lr" for what in ("convex", "down"))
OPERATIONS = {
    "cheek_limberg": Operation("cheek", "limberg", (-50.0, 112.0, 692.0), "across", {"side": 11.0}),
    "nose_bilobed": Operation("nose", "bilobed", (-3.0, 156.0, 705.0), (1.0, 0.0, 0.0), {"diameter": 7.0}, True),
    "temple_o_z": Operation("temple", "o-z", (-70.0, 75.0, 755.0), "along", {"diameter": 10.0}),
    "upper_eyelid": Operation(
        "eyelids", "upper-lid", (-32.0, 139.0, 742.3), (-1.0, 0.0, 0.0), {"length": 28.0, "width": 4.5}, targets=HOODED
    ),
    "ala_nasolabial": Operation("midface", "nasolabial", (-15.5, 146.0, 700.0), (0.3, 0.3, -0.9), {"diameter": 7.0}),
    "nose_dorsal": Operation(
        "midface",
        "dorsal-nasal",
        (0.0, 157.5, 705.0),
        (0.04, 0.0, 1.0),
        {"diameter": 9.0, "length": 52.0, "half_width": 11.0, "back_cut": 20.0, "slide": 0.6},
    ),
    "nose_forehead": Operation(
        "face",
        "paramedian-forehead",
        (18.5, 139.0, 749.0),  # on the supratrochlear artery
        (0.66, 0.0, 0.75),
        {"diameter": 14.0, "distance": 38.0, "width": 9.0, "spare": 5.0, "turn": 140.0},
        True,
    ),
    "lip_a_t": Operation(
        "lips",
        "a-t",
        (-13.5, 147.0, 678.7),
        (-1.0, 0.0, -0.22),
        {"width": 7.0, "height": 1.1, "limb": 0.85, "burow": 0.0},
    ),
    "lip_karapandzic": Operation(
        "lips",
        "karapandzic",
        (0.0, 147.0, 661.0),
        (-1.0, 0.0, 0.0),
        {"width": 14.0, "height": 14.0, "mouth": 48.0, "alar": 13.0},
    ),
    "limb_keystone": Operation(
        "limb", "keystone", (-132.1, 122.8, -130.5), (-0.1, 0.0, 1.0), {"length": 42.0, "width": 14.0}
    ),
    "web_z_plasty": Operation("web-space", "z-plasty", (-447.0, 259.5, 167.0), (-1.0, 0.1, 0.1), {"limb": 8.0}),
    "neck_z_plasty": Operation(
        "neck", "z-plasty", (0.0, 75.0, 592.0), (0.0, 0.0, 1.0), {"limb": 15.0}, scar=(44.0, 6.0)
    ),
}


def build(name: str, spacing: float | None = None) -> Procedure:
    """A whole procedure; spacing: of the lattice in mm, None for the model's."""
    operation = OPERATIONS[name]
    choice = ModelChoice(shape=BodyShape(targets=operation.targets)) if operation.targets else ModelChoice()
    start = new_model(operation.model, choice)
    if spacing is not None:
        start = replace(start, tissue=replace(start.tissue, spacing=spacing))
    direction: ArrayLike = operation.direction
    if isinstance(operation.direction, str):
        direction = skin_line_direction(start, operation.at, across=operation.direction == "across")
    if operation.scar is not None:
        start = scarred(start, operation.at, direction, *operation.scar)
    return add_flap(start, operation.design, operation.at, direction, operation.measures, mirrored=operation.mirrored)


def scarred(procedure: Procedure, at: Point, direction: ArrayLike, length: float, width: float) -> Procedure:
    """A procedure with a band of the preset scar in its skin, contracted along itself, across the skin lines."""
    tissue, way = procedure.tissue, np.asarray(direction, np.float64)
    skin = SkinSheet.of(tissue)
    middle, normal = (value[0] for value in skin.at(at))
    way = way - (way @ normal) * normal
    way /= np.linalg.norm(way)
    faces = tissue.subsets[FAT_FACES]  # the skin's
    starts = np.concatenate([[0], np.cumsum(tissue.face_vertex_counts)[:-1]])
    offset = tissue.points[tissue.face_vertex_indices[starts[faces][:, None] + np.arange(3)]].mean(axis=1) - middle
    across = np.abs(offset @ np.cross(normal, way))
    band = faces[(np.abs(offset @ way) < 0.5 * length) & (across < 0.5 * width)]
    (below,) = (region for region in tissue.regions if region.faces == FAT_FACES)
    unstretched = PRESETS["scar"].unstretched
    stretch = prestretch_for(unstretched, *CONTRACTED)
    scar = replace(unstretched, prestretch=(round(stretch[0], 4), round(stretch[1], 4)))
    region = Region("scar_band", scar.name, depth_to=below.depth_from)
    tissue = replace(tissue, subsets={**tissue.subsets, "scar_band": band}, regions=(*tissue.regions, region))
    ends = [skin.below(middle + side * 0.5 * length * way, 0.0) for side in (1.0, -1.0)]
    marks = [Landmark(f"scar_end_{k}", (end,), f"scar end {k}") for k, end in enumerate(ends, start=1)]
    return replace(procedure, tissue=tissue, materials=(*procedure.materials, scar)).with_events(*marks)


if __name__ == "__main__":
    chosen = sys.argv[1] if len(sys.argv) > 1 else "cheek_limberg"
    if chosen not in OPERATIONS:
        sys.exit(f"There is no {chosen!r}; there are {', '.join(OPERATIONS)}.")
    path = Path(sys.argv[2]) if len(sys.argv) > 2 else Path(f"{chosen}.usda")
    write_procedure(build(chosen), path)
    print(f"wrote {path}")
