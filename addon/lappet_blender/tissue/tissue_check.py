"""What the last check of a scene's tissue found; dropped as soon as the tissue changes."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from lappet.checks.validation import check
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure.prim_paths import TISSUE

from ..model.decimals import decimal
from ..model.mesh_values import MeshValues, mesh_values
from ..model.object_problems import object_problems
from ..model.scene_procedure import read_scene
from .problem_places import ProblemPlace, mesh_places, place_of, thin_places
from .tissue_objects import tissue_object


@dataclass(frozen=True, eq=False)
class TissueCheck:
    """What was checked, and what was found there."""

    mesh: MeshValues
    settings: tuple[bool, float, float]
    places: tuple[ProblemPlace, ...]

    def problems(self) -> tuple[Problem, ...]:
        """The problems, errors first."""
        found = [each.problem for each in self.places]
        return tuple(sorted(found, key=lambda each: each.severity != "error"))


_found: dict[int, TissueCheck] = {}


def check_tissue(scene: bpy.types.Scene) -> TissueCheck:
    """Look for everything that is wrong with the scene's tissue and procedure, about a second at 20 000 vertices.

    Raises RefusedError where there is no tissue.
    """
    obj = tissue_object(scene)
    settings = _settings(scene)
    mesh = mesh_values(scene, obj)
    places = [ProblemPlace(each) for each in object_problems(scene, obj, "tissue")]
    shape = mesh_places(mesh, obj.name, settings[0])
    places += shape
    reading = read_scene(scene)
    broken = any(each.problem.severity == "error" for each in shape)
    known = {each.problem.code for each in places}
    for each in reading.problems:
        follows = broken and each.prim == obj.name  # no tissue can be made of a mesh that is broken
        if each.code not in known and not follows:
            places.append(ProblemPlace(each))
    if reading.procedure is not None and not broken:
        tissue = reading.procedure.tissue
        thin = thin_places(tissue, obj.name, settings[2])
        places += thin
        known = {each.problem.code for each in places if each.problem.prim == obj.name}
        if ProblemCode.TISSUE_THIN in known:
            known.add(ProblemCode.LATTICE_TOO_COARSE)  # says the same without the places
        of_check = check(reading.procedure)
        places += [place_of(each) for each in of_check if each.prim != TISSUE or each.code not in known]
    found = TissueCheck(mesh, settings, tuple(places))
    _found[scene.session_uid] = found
    return found


def last_check(scene: bpy.types.Scene) -> TissueCheck | None:
    """What the last check found, or None where there was none or the tissue has changed since."""
    found = _found.get(scene.session_uid)
    obj = scene.lappet.tissue.object
    if found is None or obj is None or obj.type != "MESH" or obj.mode == "EDIT":
        return None
    if found.settings != _settings(scene) or mesh_values(scene, obj) is not found.mesh:
        del _found[scene.session_uid]
        return None
    return found


def clear_cache() -> None:
    """Drop everything."""
    _found.clear()


def _settings(scene: bpy.types.Scene) -> tuple[bool, float, float]:
    settings = scene.lappet.tissue
    return bool(settings.thicken), decimal(settings.thickness), decimal(settings.spacing)
