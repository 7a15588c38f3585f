"""The designs of the flap library as an asset library: plans that can be dragged from the asset browser onto skin.

An asset is the plan of a design at its defaults, as lines. Dragging it places these lines, as an object, and no more:
`lappet.flap_from_plan` then lays the flap there, along the object's x axis, with lengths by its size.
"""

from __future__ import annotations

import uuid
from collections.abc import Mapping
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.designs.flap_plan import FlapPlan, flap_plan
from lappet.designs.library import DESIGNS
from lappet.designs.library_design import LibraryDesign

from ..model.units import mm_per_unit
from .flap_thumbnails import SIZE, drawn

LIBRARY = "Lappet Flaps"
FILE, CATALOGS = "flaps.blend", "blender_assets.cats.txt"
DESIGN, UNIT = "lappet_design", "lappet_mm_per_unit"  # custom properties of a plan
_CATALOG = "Lappet/Flaps"
_NAMESPACE = uuid.UUID("6f3c1a2e-0d57-4b3c-9a55-3f0c1d0f8b11")  # of the catalog's identifier, the same everywhere


def plan_pictures() -> dict[str, NDArray[np.float32]]:
    """A picture of each design's plan, by the design's name; touches nothing of Blender's."""
    return {design.name: _picture(flap_plan(design)) for design in DESIGNS.values()}


def write_library(folder: Path, mm: float, pictures: Mapping[str, NDArray[np.float32]] | None = None) -> Path:
    """Write the asset library, a .blend and its catalog, and return the .blend.

    mm: millimeters per unit of the scenes that it is for. Blender drags an object as large as its numbers say.
    pictures: as of `plan_pictures`, None to draw them here.
    """
    drawn_plans = plan_pictures() if pictures is None else pictures
    folder.mkdir(parents=True, exist_ok=True)
    catalog = str(uuid.uuid5(_NAMESPACE, _CATALOG))
    lines = ["VERSION 1", "", f"{catalog}:{_CATALOG}:{_CATALOG.replace('/', '-')}", ""]
    (folder / CATALOGS).write_text("\n".join(lines), encoding="utf-8")
    made = [_asset(design, catalog, mm, drawn_plans[design.name]) for design in DESIGNS.values()]
    file = folder / FILE
    try:
        bpy.data.libraries.write(str(file), set(made), fake_user=True, compress=True)
    finally:
        for obj in made:
            bpy.data.curves.remove(obj.data)
    return file


def register_library(preferences: bpy.types.Preferences, folder: Path) -> None:
    """Let Blender's asset browser show a folder as the library of flaps; one of that name is moved there."""
    libraries = preferences.filepaths.asset_libraries
    known = libraries.get(LIBRARY)
    if known is None:
        known = libraries.new(name=LIBRARY, directory=str(folder))
    known.path = str(folder)


def size_of(scene: bpy.types.Scene, obj: bpy.types.Object) -> float:
    """How large a plan is, as a share of the design at its defaults: by the object's scale and the scene's unit."""
    scale = float(np.mean([abs(each) for each in obj.matrix_world.to_scale()]))
    return round(scale * mm_per_unit(scene) / float(obj.get(UNIT, 1.0)), 4)


def suit_unit(scene: bpy.types.Scene, obj: bpy.types.Object) -> bool:
    """Scale a plan that was just dropped to the scene's unit: true to size, whatever the library was written for."""
    factor = float(obj.get(UNIT, 1.0)) / mm_per_unit(scene)
    if abs(factor - 1.0) < 1e-6:
        return False
    obj.scale = [each * factor for each in obj.scale]
    return True


def _asset(design: LibraryDesign, catalog: str, mm: float, pixels: NDArray[np.float32]) -> bpy.types.Object:
    curve = bpy.data.curves.new(design.title, "CURVE")
    curve.dimensions = "3D"
    plan = flap_plan(design)
    for points, closed in [*((each, True) for each in plan.outlines), *((each, False) for each in plan.incisions)]:
        spline = curve.splines.new("POLY")
        spline.points.add(len(points) - 1)
        flat = np.column_stack([points / mm, np.zeros(len(points)), np.ones(len(points))])
        spline.points.foreach_set("co", flat.astype(np.float32).ravel())
        spline.use_cyclic_u = closed
    obj = bpy.data.objects.new(design.title, curve)
    obj[DESIGN], obj[UNIT] = design.name, mm
    obj.asset_mark()
    obj.asset_data.description, obj.asset_data.author = design.indication, "Lappet"
    obj.asset_data.catalog_id = catalog
    obj.asset_data.tags.new("flap")
    preview = obj.preview_ensure()
    preview.image_size = (SIZE, SIZE)
    preview.image_pixels_float[:] = pixels.ravel().tolist()
    return obj


def _picture(plan: FlapPlan) -> NDArray[np.float32]:
    """The plan's thumbnail on a light ground, which the asset browser's own is too dark for."""
    pixels = drawn(plan)
    share = pixels[..., 3:]
    ground = np.array([0.93, 0.90, 0.86], np.float32)
    return np.concatenate([share * pixels[..., :3] + (1.0 - share) * ground, np.ones_like(share)], axis=-1)
