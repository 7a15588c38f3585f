"""Whether an event may be added to a scene: what `lappet check` would say of it, before anything is changed."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import bpy

from lappet.checks.event_conflicts import event_conflicts
from lappet.checks.event_problems import EventCheck
from lappet.core.problem import RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import mesh_faults
from lappet.procedure import Event, Procedure, Tissue
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.rest_space import RestSpace

from ..model.event_values import event_value
from ..model.made_soon import MadeSoon
from ..model.tissue_values import tissue_value
from ..solving.controller import find_controller

_rest: list[tuple[tuple[object, ...], MadeSoon[RestSpace | None]]] = []  # of the mesh that was asked for last


def check_events(scene: bpy.types.Scene, values: Sequence[Event], without: Collection[str] = ()) -> None:
    """Raise RefusedError for what is wrong with new or changed events, alone or beside the scene's others.

    Events of the scene that have the name of one of `values` are left out, and those named in `without`, which they
    replace. Raises RefusedError where there is no tissue to place them on.
    """
    tissue = tissue_of(scene)
    names = {value.name for value in values}
    others = []
    for event in scene.lappet.events:
        if event.enabled and event.name not in names and event.name not in without:
            try:
                others.append(event_value(scene, event))
            except RefusedError:
                continue  # a broken event is its own affair
    procedure = Procedure(
        tissue, events=(*others, *values), start_time=float(scene.frame_start), end_time=float(scene.frame_end)
    )
    checked = EventCheck(procedure, rest_space(tissue))
    for value in values:
        checked.check(value, f"{TIMELINE}/{value.name}")
    paths = {f"{TIMELINE}/{name}" for name in names}
    problems = [*checked.problems, *(each for each in event_conflicts(procedure) if each.prim in paths)]
    errors = [each for each in problems if each.severity == "error"]
    if errors:
        raise RefusedError(errors)


def tissue_of(scene: bpy.types.Scene) -> Tissue:
    """The scene's tissue; raises RefusedError with the reason where it has none that can be used."""
    tissue, problems = tissue_value(scene)
    if tissue is None:
        raise RefusedError(problems or [problem(ProblemCode.TISSUE_NONE)])
    return tissue


def rest_space(tissue: Tissue) -> RestSpace | None:
    """Distances from the tissue, or None where its mesh is in disorder; kept until the mesh changes."""
    return _begun(tissue).take()


def begin_rest_space(scene: bpy.types.Scene) -> None:
    """Begin to find the distances from the scene's tissue on a thread: somebody will place events on it.

    At 100 000 vertices they take 0.7 s.
    """
    controller = find_controller(scene)
    if not bpy.app.background and controller is not None and controller.procedure is not None:
        _begun(controller.procedure.tissue)


def _begun(tissue: Tissue) -> MadeSoon[RestSpace | None]:
    mesh = tissue.points, tissue.face_vertex_counts, tissue.face_vertex_indices
    if not _rest or not all(a is b for a, b in zip(_rest[0][0], mesh, strict=True)):
        _rest[:] = [(mesh, MadeSoon(lambda: _made(tissue)))]
    return _rest[0][1]


def _made(tissue: Tissue) -> RestSpace | None:
    # No kind of fault is asked for but that numbers are unusable: to search for crossings takes seconds.
    usable = not mesh_faults(tissue.points, tissue.face_vertex_counts, tissue.face_vertex_indices, ())
    return RestSpace(tissue.points, fan_triangles(tissue)[0]) if usable else None
