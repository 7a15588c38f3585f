"""The tissue and the bones of a scene as values of a procedure."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import bpy

from lappet.problem import Problem
from lappet.procedure import Bone, Region, Tissue
from lappet.refused import RefusedError
from lappet.sheet_tissue import sheet_tissue

from .decimals import decimal
from .material_values import region_values
from .mesh_values import MeshValues, mesh_values
from .object_problems import object_problems
from .scene_problem import problem
from .surface_border import open_edge_count

_SLOT = "Tissue"


@dataclass(frozen=True, eq=False)
class _Kept:
    """A tissue and what it was made of."""

    mesh: MeshValues
    thickness: float
    tissue: Tissue | None
    problems: tuple[Problem, ...]


_kept: dict[int, _Kept] = {}
_bones: dict[int, tuple[MeshValues, str, Bone]] = {}


def tissue_value(scene: bpy.types.Scene) -> tuple[Tissue | None, list[Problem]]:
    """The scene's tissue, or None and why. The same object as long as nothing about it has changed."""
    settings = scene.lappet.tissue
    obj = settings.object
    if obj is None:
        mend = "Select a mesh and press Make Tissue."
        return None, [problem(_SLOT, "none", "The scene has no tissue.", mend, "lappet.tissue_set")]
    problems: list[Problem] = list(object_problems(scene, obj, "tissue"))
    if problems:
        return None, problems
    mesh = mesh_values(scene, obj)
    thickness = decimal(settings.thickness) if settings.thicken else 0.0
    key = scene.session_uid
    kept = _kept.get(key)
    if kept is None or kept.mesh is not mesh or kept.thickness != thickness:
        kept = _made(mesh, thickness, obj.name)
    if kept.tissue is not None:
        tissue = _with_settings(kept.tissue, settings, region_values(scene))
        if tissue is not kept.tissue:
            kept = replace(kept, tissue=tissue)
    _kept[key] = kept
    return kept.tissue, list(kept.problems)


def bone_values(scene: bpy.types.Scene) -> tuple[tuple[Bone, ...], list[Problem]]:
    """The scene's bones and what is wrong with them; entries without an object are left out."""
    bones: list[Bone] = []
    problems: list[Problem] = []
    names: set[str] = set()
    seen: set[bpy.types.Object] = set()
    for entry in scene.lappet.bones:
        obj = entry.object
        if obj is None:
            continue
        remove = {"operator": "lappet.bone_remove", "object": obj.name}
        if obj == scene.lappet.tissue.object:
            sentence = f"The mesh {obj.name!r} is the tissue and a bone at once."
            problems.append(problem(obj.name, "bone", sentence, "Remove it from the bones.", **remove))
            continue
        if obj in seen:
            sentence = f"The bone {obj.name!r} is listed twice."
            problems.append(problem(obj.name, "twice", sentence, "Remove one of them.", **remove))
            continue
        seen.add(obj)
        found = object_problems(scene, obj, "bone")
        problems += found
        if not found:
            name = identifier(entry.name or obj.name, names)
            names.add(name)
            bones.append(_bone(obj, mesh_values(scene, obj), name))
    return tuple(bones), problems


def identifier(name: str, taken: set[str]) -> str:
    """The name as one that a prim may have, with a number where another one has it already."""
    clean = re.sub(r"[^A-Za-z0-9_]", "_", name) or "_"
    clean = f"_{clean}" if clean[0].isdigit() else clean
    number, unique = 1, clean
    while unique in taken:
        unique, number = f"{clean}_{number}", number + 1
    return unique


def _bone(obj: bpy.types.Object, mesh: MeshValues, name: str) -> Bone:
    kept = _bones.get(obj.session_uid)
    if kept is None or kept[0] is not mesh or kept[1] != name:
        kept = (mesh, name, Bone(name, mesh.points, mesh.counts, mesh.indices))
        _bones[obj.session_uid] = kept
    return kept[2]


def _made(mesh: MeshValues, thickness: float, name: str) -> _Kept:
    if len(mesh.counts) == 0:
        sentence = f"The tissue {name!r} has {len(mesh.points)} vertices and no face."
        return _Kept(mesh, thickness, None, (problem(name, 0, sentence, "Give it faces, or choose another mesh."),))
    border = open_edge_count(mesh)
    if thickness == 0.0 and border:
        sentence = f"The surface of the tissue {name!r} is open: {border} edges belong to one face only."
        mend = "Turn Thicken on and give a thickness, or fill the holes."
        found = problem(name, border, sentence, mend, "lappet.tissue_mend", kind="HOLES")
        return _Kept(mesh, thickness, None, (found,))
    if thickness > 0.0 and not border:
        sentence = f"The surface of the tissue {name!r} is closed; a thickness of {thickness:g} mm says nothing."
        found = problem(name, f"{thickness:g} mm", sentence, "Turn Thicken off.", "lappet.tissue_mend", kind="THICKEN")
        return _Kept(mesh, thickness, None, (found,))
    try:
        tissue = _sheet(mesh, thickness, name) if thickness > 0.0 else _closed_tissue(mesh)
    except RefusedError as refused:
        sentence = str(refused).removeprefix(f"{name}: ")
        what, _, mend = sentence.partition("; ")
        found = problem(name, f"{thickness:g} mm", f"{_capital(what)}.", f"{_capital(mend or 'Check the mesh')}.")
        return _Kept(mesh, thickness, None, (found,))
    return _Kept(mesh, thickness, tissue, ())


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _sheet(mesh: MeshValues, thickness: float, name: str) -> Tissue:
    return sheet_tissue(mesh.points, mesh.counts, mesh.indices, thickness, mesh.uv, mesh.groups, name)


def _closed_tissue(mesh: MeshValues) -> Tissue:
    return Tissue(mesh.points, mesh.counts, mesh.indices, mesh.uv, dict(mesh.groups))


def _with_settings(tissue: Tissue, settings: bpy.types.PropertyGroup, regions: Sequence[Region]) -> Tissue:
    values = {
        "material": settings.material,
        "spacing": decimal(settings.spacing),
        "gravity": decimal(settings.gravity) if settings.use_gravity else None,
        "bed_stiffness": decimal(settings.bed_stiffness),
    }
    same = all(getattr(tissue, name) == value for name, value in values.items())
    made = replace(tissue, **values, regions=tuple(regions)) if not same or tissue.regions or regions else tissue
    return tissue if same and made.regions == tissue.regions else made


def forget() -> None:
    """Lets go of everything that is kept (a new file was loaded)."""
    _kept.clear()
    _bones.clear()
