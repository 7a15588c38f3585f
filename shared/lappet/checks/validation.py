"""Validate a procedure before it is solved: every problem at once, each with its prim, value and remedy."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from lappet.checks.bone_motion_problems import bone_motion_problems
from lappet.checks.bone_overlap import overlap_problems
from lappet.checks.event_conflicts import event_conflicts
from lappet.checks.event_problems import EventCheck
from lappet.checks.lattice_size import TissueMeasure
from lappet.checks.material_problems import material_problems, region_problems
from lappet.checks.mesh_problems import MeshReport, mesh_problems
from lappet.checks.muscle_problems import muscle_problems
from lappet.checks.roller_problems import roller_problems
from lappet.checks.skin_line_problems import skin_line_problems
from lappet.checks.suspicious_events import suspicious_events
from lappet.checks.suspicious_tissue import separate_parts, size_problems
from lappet.checks.vessel_problems import vessel_problems
from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Procedure, Retractor, SutureRun
from lappet.procedure.prim_names import name_problems
from lappet.procedure.prim_paths import BONE, MATERIALS, ROOT, TIMELINE, TISSUE
from lappet.suturing.single_sutures import with_single_sutures
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.rest_space import RestSpace
from lappet.usd.stage_procedure import StageProcedure

MEMORY_BUDGET = 8 << 30  # bytes, as `SolverSettings.memory_budget`
MOST_FRAMES = 1_000_000


def check(procedure: Procedure, memory_budget: float = MEMORY_BUDGET, spacing: float | None = None) -> list[Problem]:
    """Find every problem of a procedure.

    Nothing is cut, so what only shows in the cut surface (an anchor whose tissue is excised) is found when the
    procedure is compiled.

    Parameters
    ----------
    procedure
        The procedure.
    memory_budget
        Memory in bytes that the solver may take.
    spacing
        Lattice spacing in mm, where it is not the tissue's own.

    Returns
    -------
    list[Problem]
        The problems; errors are refused before solving, warnings are not.

    Examples
    --------
    >>> from lappet import Incision, Procedure, check
    >>> from lappet.tissue import flat_patch
    >>> hovering = Incision("cut", 2, [(-10, 0, 40), (10, 0, 40)])
    >>> [problem] = check(Procedure(flat_patch(spacing=2.0), events=(hovering,), end_time=3))
    >>> str(problem.code), problem.prim
    ('curve-off-tissue', '/Procedure/Timeline/cut')
    """
    problems = [*name_problems(procedure), *_timeline(procedure)]
    report = mesh_problems(procedure.tissue, TISSUE)
    problems += report.problems
    rest = None
    size = procedure.tissue.spacing if spacing is None else spacing
    problems += _tissue(procedure, size)
    if report.readable:
        triangles, _ = fan_triangles(procedure.tissue)
        rest = RestSpace(procedure.tissue.points, triangles)
        measure = TissueMeasure(procedure.tissue.points, triangles)
        problems += [*_lattice(measure, size, memory_budget), *size_problems(procedure.tissue.points)]
    if _is_solid(report):
        problems += separate_parts(procedure.tissue)
    for material in procedure.materials:
        problems += material_problems(material, f"{MATERIALS}/{material.name}")
    problems += [*region_problems(procedure), *roller_problems(procedure)]
    problems += skin_line_problems(procedure)
    problems += vessel_problems(procedure, rest)
    problems += muscle_problems(procedure, rest)
    for bone in procedure.bones:
        path = f"{BONE}/{bone.name}"
        problems += bone_motion_problems(bone, path, procedure.start_time)
        found = mesh_problems(bone, path)
        problems += found.problems
        if _is_solid(report) and _is_solid(found) and math.isfinite(size) and size > 0.0:
            problems += overlap_problems(bone, found.triangles, procedure.tissue.points, report.triangles, size)
    events = EventCheck(procedure, rest, size)
    for event in procedure.events:
        events.check(event, f"{TIMELINE}/{event.name}")
    problems = [*problems, *events.problems]
    single = _with_single_sutures(procedure, size, problems)
    problems += event_conflicts(single)
    wrong = {each.prim for each in problems if each.severity == "error"}
    if rest is not None and not {TISSUE, ROOT} & wrong and math.isfinite(size) and size > 0.0:
        problems += suspicious_events(single, rest, measure.thickness, size, wrong)
    return problems


def _with_single_sutures(procedure: Procedure, spacing: float, problems: list[Problem]) -> Procedure:
    """The procedure with the stitches of its suture runs, but for runs that are wrong or whose tissue is."""
    wrong = {each.prim for each in problems if each.severity == "error"}
    blind = any(prim == TISSUE or prim.startswith(f"{TISSUE}/") for prim in wrong)
    kept = [
        event
        for event in procedure.events
        if not (isinstance(event, SutureRun) and (blind or f"{TIMELINE}/{event.name}" in wrong))
    ]
    return with_single_sutures(replace(procedure, events=tuple(kept)), spacing)


def check_read(read: StageProcedure) -> list[Problem]:
    """Find every problem of a procedure that was read: those of reading it and those of `check`.

    A prim that could not be read is not judged a second time.

    Parameters
    ----------
    read
        What was read.

    Returns
    -------
    list[Problem]
        The problems.
    """
    unread = list(read.problems)
    if read.procedure is None:
        return unread
    known = {each.prim for each in unread}
    return unread + [each for each in check(read.procedure) if each.prim not in known]


def _is_solid(report: MeshReport) -> bool:
    return report.readable and not any(each.severity == "error" for each in report.problems)


def _timeline(procedure: Procedure) -> list[Problem]:
    start, end, fps = procedure.start_time, procedure.end_time, procedure.fps
    problems = []

    def add(code: ProblemCode, **fields: Any) -> None:
        problems.append(problem(code, ROOT, f"{start:g} to {end:g}", start=start, end=end, **fields))

    if not (math.isfinite(start) and math.isfinite(end)):
        add(ProblemCode.TIMELINE_NOT_FINITE)
    elif math.floor(end) < math.ceil(start):
        add(ProblemCode.TIMELINE_NO_FRAME)
    elif end - start >= MOST_FRAMES:
        add(ProblemCode.TIMELINE_TOO_LONG, frames=end - start + 1, most=MOST_FRAMES)
    if not (math.isfinite(fps) and fps > 0.0):
        problems.append(problem(ProblemCode.TIMELINE_FPS, ROOT, f"{fps:g}"))
    return problems


def _tissue(procedure: Procedure, spacing: float) -> list[Problem]:
    tissue = procedure.tissue
    problems = []

    def add(code: ProblemCode, value: object, **fields: Any) -> None:
        problems.append(problem(code, TISSUE, f"{value:g}" if isinstance(value, float) else value, **fields))

    if tissue.material not in {material.name for material in procedure.materials}:
        known = ", ".join(material.name for material in procedure.materials) or "none"
        add(ProblemCode.TISSUE_MATERIAL_UNKNOWN, tissue.material, materials=MATERIALS, known=known)
    if not (math.isfinite(spacing) and spacing > 0.0):
        add(ProblemCode.TISSUE_SPACING, spacing)
    if not (math.isfinite(tissue.bed_stiffness) and tissue.bed_stiffness >= 0.0):
        add(ProblemCode.TISSUE_BED_STIFFNESS, tissue.bed_stiffness)
    elif not 0.0 <= tissue.bed_shear <= tissue.bed_stiffness:
        add(ProblemCode.TISSUE_BED_SHEAR, tissue.bed_shear, normal=tissue.bed_stiffness)
    if not math.isfinite(tissue.gravity):
        add(ProblemCode.TISSUE_GRAVITY, tissue.gravity)
    length = math.hypot(*tissue.gravity_direction)
    if not (math.isfinite(length) and length > 0.0):
        add(ProblemCode.TISSUE_GRAVITY_DIRECTION, tissue.gravity_direction)
    if tissue.uv is not None:
        corners = len(tissue.face_vertex_indices)
        if len(tissue.uv) != corners:
            add(ProblemCode.TISSUE_UV_COUNT, len(tissue.uv), corners=corners)
        elif not np.isfinite(tissue.uv).all():
            add(ProblemCode.TISSUE_UV_NOT_FINITE, "not finite")
    problems += _subsets(procedure)
    held = any(len(tissue.subsets.get(name, ())) for name in ("fixed", "bed"))
    if not held and not tissue.rollers and not any(isinstance(event, Retractor) for event in procedure.events):
        add(ProblemCode.TISSUE_NOT_HELD, "no fixed faces")
    return problems


def _subsets(procedure: Procedure) -> list[Problem]:
    problems = []
    faces = len(procedure.tissue.face_vertex_counts)
    for name, subset in procedure.tissue.subsets.items():
        prim, outside = f"{TISSUE}/{name}", subset[(subset < 0) | (subset >= faces)]
        if len(outside):
            problems.append(problem(ProblemCode.SUBSET_INDEX_RANGE, prim, outside[0], name=name, faces=faces))
        elif len(np.unique(subset)) != len(subset):
            problems.append(problem(ProblemCode.SUBSET_FACE_TWICE, prim, name))
    return problems


def _lattice(measure: TissueMeasure, spacing: float, memory_budget: float) -> list[Problem]:
    if not (math.isfinite(spacing) and spacing > 0.0 and (measure.size > 0.0).any()):
        return []
    problems = []
    lattice = measure.lattice(spacing)
    if lattice.bytes > memory_budget:
        problems.append(
            problem(
                ProblemCode.LATTICE_MEMORY,
                TISSUE,
                f"{spacing:g} mm",
                cells=lattice.cells,
                needed=lattice.bytes / 2**30,
                budget=memory_budget / 2**30,
                least=measure.least_spacing(memory_budget),
            )
        )
    thickness = float(measure.size.min())
    if spacing > thickness > 0.0:
        code = ProblemCode.LATTICE_TOO_COARSE
        problems.append(problem(code, TISSUE, f"{spacing:g} mm", spacing=spacing, thickness=thickness))
    return problems
