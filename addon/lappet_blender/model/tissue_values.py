"""The tissue and the bones of a scene as values of a procedure."""

from __future__ import annotations

import hashlib
import re
import threading
from collections import OrderedDict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import bpy
import numpy as np

from lappet.core.digest import digest
from lappet.core.problem import Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import mesh_faults
from lappet.procedure import POSITIONS, Bone, Region, Tissue
from lappet.tissue.sheet_tissue import sheet_tissue

from .decimals import decimal, decimals
from .material_values import region_values
from .mesh_values import MeshValues, mesh_values
from .object_problems import object_problems
from .surface_border import open_edge_count
from .tissue_size import tissue_size


@dataclass(frozen=True, eq=False)
class _Kept:
    """A tissue and what it was made of."""

    mesh: MeshValues
    thickness: float
    tissue: Tissue | None
    problems: tuple[Problem, ...]


class _Making:
    """A tissue that is made on a thread of its own; what is asked of it first is found there too."""

    def __init__(self, mesh: MeshValues, thickness: float, name: str, finish: Callable[[Tissue], Tissue]) -> None:
        self._of = (mesh, thickness, name)
        self._finish = finish
        self._made: _Kept | None = None
        self._thread = threading.Thread(target=self._make, name="lappet sheet", daemon=True)
        self._thread.start()

    def is_of(self, mesh: MeshValues, thickness: float, name: str) -> bool:
        """Whether it is made of these values."""
        return self._of[0] is mesh and self._of[1:] == (thickness, name)

    @property
    def done(self) -> bool:
        """Whether it is made."""
        return not self._thread.is_alive()

    def take(self) -> _Kept:
        """What was made, waited for."""
        self._thread.join()
        return self._made if self._made is not None else _made(*self._of)

    def _make(self) -> None:
        made = _made(*self._of)
        if made.tissue is not None:
            tissue = self._finish(made.tissue)
            digest(tissue, remember=(Tissue,))  # the manifest's key asks for it
            tissue_size(tissue)  # and the panels for this
            made = replace(made, tissue=tissue)
        self._made = made


_LARGE = 1500  # vertices from which on making tissue of a mesh is to be waited for
_MOST_SHEETS = 6
_kept: dict[int, _Kept] = {}
_making: dict[int, _Making] = {}
_sheets: OrderedDict[bytes, Tissue] = OrderedDict()
_bones: dict[int, tuple[MeshValues, str, Bone]] = {}


def tissue_value(scene: bpy.types.Scene) -> tuple[Tissue | None, list[Problem]]:
    """The scene's tissue, or None and why. The same object as long as nothing about it has changed."""
    settings = scene.lappet.tissue
    obj = settings.object
    if obj is None:
        return None, [problem(ProblemCode.TISSUE_NONE)]
    problems = object_problems(scene, obj, "tissue")
    if problems:
        return None, problems
    mesh = mesh_values(scene, obj)
    thickness = decimal(settings.thickness) if settings.thicken else 0.0
    key = scene.session_uid
    kept = _kept.get(key)
    if kept is None or kept.mesh is not mesh or kept.thickness != thickness:
        making = _making.pop(key, None)
        known = making is not None and making.is_of(mesh, thickness, obj.name)
        kept = making.take() if making is not None and known else _made(mesh, thickness, obj.name)
    if kept.tissue is not None:
        tissue = _with_values(kept.tissue, _settings_values(settings), region_values(scene))
        if tissue is not kept.tissue:
            kept = replace(kept, tissue=tissue)
    _kept[key] = kept
    return kept.tissue, list(kept.problems)


def tissue_is_ready(scene: bpy.types.Scene) -> bool:
    """Whether `tissue_value` answers at once; where it would not, what it waits for is begun on a thread."""
    settings = scene.lappet.tissue
    obj = settings.object
    if obj is None or obj.type != "MESH" or len(obj.data.vertices) < _LARGE:
        return True
    if object_problems(scene, obj, "tissue"):
        return True
    key = scene.session_uid
    if key in _making and not _making[key].done:
        return False  # whether the mesh has changed meanwhile is asked once it is made
    mesh = mesh_values(scene, obj)
    thickness = decimal(settings.thickness) if settings.thicken else 0.0
    kept = _kept.get(key)
    if kept is not None and kept.mesh is mesh and kept.thickness == thickness:
        return True
    making = _making.get(key)
    if making is None or not making.is_of(mesh, thickness, obj.name):
        finish = partial(_with_values, values=_settings_values(settings), regions=tuple(region_values(scene)))
        _making[key] = making = _Making(mesh, thickness, obj.name, finish)
    return making.done


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
        if obj == scene.lappet.tissue.object:
            problems.append(problem(ProblemCode.BONE_IS_TISSUE, obj.name))
            continue
        if obj in seen:
            problems.append(problem(ProblemCode.BONE_TWICE, obj.name))
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
    border = open_edge_count(mesh)
    if thickness == 0.0 and (border or len(mesh.counts) == 0 or not np.isfinite(mesh.points).all()):
        faults = mesh_faults(mesh.points, mesh.counts, mesh.indices, {ProblemCode.MESH_OPEN})
        return _Kept(mesh, thickness, None, tuple(fault.problem(name) for fault in faults))
    if thickness > 0.0 and not border and len(mesh.counts):
        found = problem(ProblemCode.SHEET_OF_CLOSED_SURFACE, name, f"{thickness:g}")
        return _Kept(mesh, thickness, None, (found,))
    try:
        tissue = _sheet(mesh, thickness, name) if thickness > 0.0 else _closed_tissue(mesh)
    except RefusedError as refused:
        return _Kept(mesh, thickness, None, refused.problems)
    return _Kept(mesh, thickness, tissue, ())


def _sheet(mesh: MeshValues, thickness: float, name: str) -> Tissue:
    """Those made last are kept by what they were made of: an undo finds its sheet again."""
    hasher = hashlib.blake2b(f"{name} {thickness!r} {sorted(mesh.groups)}".encode())
    for array in (
        mesh.points,
        mesh.counts,
        mesh.indices,
        mesh.uv,
        *(mesh.groups[each] for each in sorted(mesh.groups)),
    ):
        hasher.update(b"-" if array is None else f"{array.shape}".encode() + array.tobytes())
    key = hasher.digest()
    tissue = _sheets.get(key)
    if tissue is None:
        tissue = sheet_tissue(mesh.points, mesh.counts, mesh.indices, thickness, mesh.uv, mesh.groups, name)
        _sheets[key] = tissue
        while len(_sheets) > _MOST_SHEETS:
            _sheets.pop(next(iter(_sheets)), None)
    return tissue


def _closed_tissue(mesh: MeshValues) -> Tissue:
    return Tissue(mesh.points, mesh.counts, mesh.indices, mesh.uv, dict(mesh.groups))


def _settings_values(settings: bpy.types.PropertyGroup) -> dict[str, Any]:
    return {
        "material": settings.material,
        "spacing": decimal(settings.spacing),
        "gravity": decimal(settings.gravity) if settings.use_gravity else 0.0,
        "gravity_direction": POSITIONS.get(settings.position.lower()) or decimals(settings.gravity_direction),
        "bed_stiffness": decimal(settings.bed_stiffness),
        "bed_shear": decimal(settings.bed_shear),
        "self_contact": settings.id_data.lappet.solving.self_contact,
    }


def _with_values(tissue: Tissue, values: dict[str, Any], regions: Sequence[Region]) -> Tissue:
    """The tissue with these settings; the same one where it has them."""
    same = all(getattr(tissue, name) == value for name, value in values.items())
    made = replace(tissue, **values, regions=tuple(regions)) if not same or tissue.regions or regions else tissue
    return tissue if same and made.regions == tissue.regions else made


def clear_cache() -> None:
    """Drop everything that is kept (a new file was loaded)."""
    _kept.clear()
    _making.clear()
    _sheets.clear()
    _bones.clear()
