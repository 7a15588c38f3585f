"""Make an object the tissue of a scene and choose what it needs: spacing, material, texture, frames."""

from __future__ import annotations

import bpy
import numpy as np

from lappet.checks.suspicious_tissue import size_problems
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import refuse_unreadable
from lappet.geometry.surface_check import signed_volume
from lappet.geometry.triangles import areas
from lappet.geometry.triangulation import triangulate
from lappet.tissue.chosen_spacing import chosen_spacing
from lappet.tissue.presets import PRESETS

from ..interface.problem_sentence import problem_sentence
from ..model.material_values import set_material
from ..model.mesh_values import MeshValues, mesh_values
from ..model.procedure_properties import VERSION
from ..model.surface_border import open_edge_count

_UNTOUCHED = (1, 250)  # the frame range of a new scene
_FRAMES = (1, 40)


def set_tissue(
    scene: bpy.types.Scene, obj: bpy.types.Object, thickness: float, spacing: float, preset: str
) -> str | None:
    """Make the object the scene's tissue.

    thickness: mm of the sheet below an open surface, 0 for a closed one. spacing: mm, 0 = about 40 000 cells.
    preset: name in `lappet.tissue.presets.PRESETS` of the material. Raises RefusedError before anything has
    changed; returns what is worth saying.
    """
    if obj.type != "MESH":
        raise refused(ProblemCode.OBJECT_NOT_A_MESH, obj.name, obj.type.lower(), role="object")
    if any(bone.object == obj for bone in scene.lappet.bones):
        raise refused(ProblemCode.BONE_IS_TISSUE, obj.name)
    for name, value in {"thickness": thickness, "spacing": spacing}.items():
        if not (np.isfinite(value) and value >= 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, obj.name, f"{value:g}", name=name)
    mesh = mesh_values(scene, obj)
    refuse_unreadable(obj.name, mesh.points, mesh.counts, mesh.indices)
    border = open_edge_count(mesh)
    if thickness > 0.0 and not border:
        raise refused(ProblemCode.SHEET_OF_CLOSED_SURFACE, obj.name, f"{thickness:g}")
    procedure, settings = scene.lappet, scene.lappet.tissue
    settings.object = obj
    settings.thicken = thickness > 0.0
    if thickness > 0.0:
        settings.thickness = thickness
    settings.spacing = spacing or _spacing(mesh, thickness)
    use_preset(scene, preset)
    if procedure.version == 0 and (scene.frame_start, scene.frame_end) == _UNTOUCHED:
        scene.frame_start, scene.frame_end = _FRAMES
    procedure.version = VERSION
    odd = [problem_sentence(found) for found in size_problems(mesh.points)]
    if border and thickness == 0.0:
        odd.append(_holes(obj, border))
    return " ".join(odd) or None


def _holes(obj: bpy.types.Object, border: int) -> str:
    return f"The surface of {obj.name!r} is open ({border} border edges): give a thickness, or fill its holes."


def use_preset(scene: bpy.types.Scene, preset: str) -> None:
    """Make the tissue of the preset's material, which is added where no material has its name."""
    material = PRESETS[preset].material
    if material.name not in scene.lappet.materials:
        set_material(scene, scene.lappet.materials.add(), material)
    scene.lappet.tissue.material = material.name


def _triangles(mesh: MeshValues) -> np.ndarray:
    return triangulate(mesh.points, mesh.counts.astype(np.int64), mesh.indices.astype(np.int64))[0]


def _spacing(mesh: MeshValues, thickness: float) -> float:
    triangles = _triangles(mesh)
    if thickness > 0.0:
        volume = thickness * float(areas(mesh.points[triangles]).sum())
    else:
        volume = abs(signed_volume(mesh.points, triangles))
    return chosen_spacing(volume, thickness) or 1.0
