"""Materials and regions: between the scene's property groups and the procedure's values."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy

from lappet.procedure import Material, Region

from .decimals import decimal, decimals
from .exact_numbers import keep_exact, with_exact
from .keyframes import curves_of, samples

_NUMBERS = (
    "youngs_modulus",
    "poissons_ratio",
    "mooney_ratio",
    "fiber_k1",
    "fiber_k2",
    "fiber_dispersion",
    "fiber_slack",
    "fiber_angle",
    "density",
    "muscle_stress",
)


def material_values(scene: bpy.types.Scene) -> tuple[Material, ...]:
    """The scene's materials in their order."""
    curves = {curve.data_path: curve for curve in curves_of(scene) if curve.data_path.endswith(".activation")}
    found = []
    for each in scene.lappet.materials:
        numbers = {name: _third(name, decimal(getattr(each, name))) for name in _NUMBERS}
        shown = Material(
            name=each.name,
            model=each.model,
            fiber_direction=decimals(each.fiber_direction),  # type: ignore[arg-type]
            prestretch=decimals(each.prestretch),  # type: ignore[arg-type]
            muscle_activation=_activation(scene, each, curves.get(each.path_from_id("activation"))),
            **numbers,
        )
        found.append(with_exact(each, shown))
    return tuple(found)


def find_material(scene: bpy.types.Scene, wanted: Material) -> str | None:
    """The name of a material of the scene that has the values of one, whatever that is called; None for none."""
    there, shown = material_values(scene), _shown(wanted)
    return next((each.name for each in there if _shown(replace(each, name=wanted.name)) == shown), None)


def _shown(material: Material) -> Material:
    """A material as the scene's properties show it."""
    numbers = {name: decimal(getattr(material, name)) for name in _NUMBERS}
    vectors = {name: decimals(getattr(material, name)) for name in ("fiber_direction", "prestretch")}
    return replace(material, **numbers, **vectors)  # type: ignore[arg-type]


def _third(name: str, value: float) -> float:
    """The greatest dispersion is a third, which has no decimal."""
    return 1.0 / 3.0 if name == "fiber_dispersion" and value == decimal(1.0 / 3.0) else value


def _activation(
    scene: bpy.types.Scene, each: bpy.types.PropertyGroup, curve: object
) -> tuple[tuple[float, float], ...]:
    if curve is not None:
        return tuple((decimal(t), decimal(v)) for t, v in samples(curve, scene.frame_start, scene.frame_end))
    value = decimal(each.activation)
    return ((float(scene.frame_start), value),) if value > 0.0 else ()


def set_material(scene: bpy.types.Scene, each: bpy.types.PropertyGroup, material: Material) -> None:
    """Give an entry of `scene.lappet.materials` the values of a material; muscle activation becomes keyframes."""
    each.name, each.model = material.name, material.model
    for name in _NUMBERS:
        setattr(each, name, getattr(material, name))
    each.fiber_direction, each.prestretch = material.fiber_direction, material.prestretch
    keep_exact(each, material)
    path = each.path_from_id("activation")
    for curve in [c for c in curves_of(scene) if c.data_path == path]:
        for point in reversed(list(curve.keyframe_points)):
            each.keyframe_delete("activation", frame=point.co[0])
    each.activation = 0.0
    for time, value in material.muscle_activation:
        each.activation = value
        each.keyframe_insert("activation", frame=time)
    for curve in [c for c in curves_of(scene) if c.data_path == path]:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def region_values(scene: bpy.types.Scene) -> tuple[Region, ...]:
    """The scene's regions."""
    return tuple(
        Region(
            faces=each.name,
            material=each.material,
            depth_from=decimal(each.depth_from),
            depth_to=math.inf if each.to_bottom else decimal(each.depth_to),
        )
        for each in scene.lappet.regions
    )


def set_region(each: bpy.types.PropertyGroup, region: Region) -> None:
    """Give an entry of `scene.lappet.regions` the values of a region."""
    each.name, each.material, each.depth_from = region.faces, region.material, region.depth_from
    each.to_bottom = math.isinf(region.depth_to)
    if not each.to_bottom:
        each.depth_to = region.depth_to
