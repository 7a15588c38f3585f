"""Validates a procedure before it is solved: every problem at once, each with its prim, value and remedy."""

from __future__ import annotations

import math
import os

import numpy as np

from lappet.checks.bone_overlap import overlap_problems
from lappet.checks.event_conflicts import event_conflicts
from lappet.checks.event_problems import EventCheck
from lappet.checks.lattice_size import TissueMeasure
from lappet.checks.material_problems import material_problems, region_problems
from lappet.checks.mesh_problems import MeshReport, mesh_problems
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Procedure, Retractor
from lappet.procedure.prim_names import name_problems
from lappet.procedure.prim_paths import BONE, MATERIALS, ROOT, TIMELINE, TISSUE
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.rest_space import RestSpace
from lappet.usd.stage import read_what_can_be

MEMORY_BUDGET = 8 << 30  # bytes, as `SolverSettings.memory_budget`
MOST_FRAMES = 1_000_000


def check(procedure: Procedure, memory_budget: float = MEMORY_BUDGET, spacing: float | None = None) -> list[Problem]:
    """Every problem of a procedure; errors are refused before solving, warnings are not.

    memory_budget: bytes. spacing: the lattice spacing in mm, where it is not the tissue's own. Nothing is cut, so what
    only shows in the cut surface (an anchor whose tissue is excised) is found when the procedure is compiled.
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
        problems += _lattice(TissueMeasure(procedure.tissue.points, triangles), size, memory_budget)
    for material in procedure.materials:
        problems += material_problems(material, f"{MATERIALS}/{material.name}")
    problems += region_problems(procedure)
    for bone in procedure.bones:
        path = f"{BONE}/{bone.name}"
        found = mesh_problems(bone, path)
        problems += found.problems
        if _is_solid(report) and _is_solid(found) and math.isfinite(size) and size > 0.0:
            problems += overlap_problems(bone, found.triangles, procedure.tissue.points, report.triangles, size)
    events = EventCheck(procedure, rest)
    for event in procedure.events:
        events.check(event, f"{TIMELINE}/{event.name}")
    return [*problems, *events.problems, *event_conflicts(procedure)]


def check_file(
    path: str | os.PathLike[str], notes: list[str] | None = None, memory_budget: float = MEMORY_BUDGET
) -> list[Problem]:
    """Every problem of a procedure file: those of reading it and those of `check`, together.

    notes: gets a sentence for everything that was converted or left aside while reading. Raises RefusedError only
    where the file cannot be opened as USD. A prim that could not be read is not judged a second time.
    """

    procedure, unread = read_what_can_be(path, notes)
    if procedure is None:
        return unread
    known = {problem.prim for problem in unread}
    return unread + [problem for problem in check(procedure, memory_budget) if problem.prim not in known]


def _is_solid(report: MeshReport) -> bool:
    return report.readable and not any(problem.severity == "error" for problem in report.problems)


def _timeline(procedure: Procedure) -> list[Problem]:
    start, end, fps = procedure.start_time, procedure.end_time, procedure.fps
    problems = []
    if not (math.isfinite(start) and math.isfinite(end)):
        sentence = f"The timeline runs from {start:g} to {end:g}."
        problems.append(
            Problem(
                ProblemCode.UNSORTED, ROOT, f"{start:g} to {end:g}", sentence, "Give finite start and end time codes."
            )
        )
    elif math.floor(end) < math.ceil(start):
        sentence = f"The timeline from {start:g} to {end:g} holds no frame."
        remedy = "Set endTimeCode to startTimeCode or later; frames are the whole time codes between them."
        problems.append(Problem(ProblemCode.UNSORTED, ROOT, f"{start:g} to {end:g}", sentence, remedy))
    elif end - start >= MOST_FRAMES:
        sentence = f"The timeline from {start:g} to {end:g} holds {end - start + 1:.3g} frames."
        remedy = f"Keep it below {MOST_FRAMES} frames; frames are the whole time codes."
        problems.append(Problem(ProblemCode.UNSORTED, ROOT, f"{start:g} to {end:g}", sentence, remedy))
    if not (math.isfinite(fps) and fps > 0.0):
        sentence = f"There are {fps:g} time codes per second."
        problems.append(
            Problem(ProblemCode.UNSORTED, ROOT, f"{fps:g}", sentence, "Set timeCodesPerSecond above 0; 24 is usual.")
        )
    return problems


def _tissue(procedure: Procedure, spacing: float) -> list[Problem]:
    tissue = procedure.tissue
    problems = []

    def add(value: object, sentence: str, remedy: str, path: str = TISSUE) -> None:
        problems.append(Problem(ProblemCode.UNSORTED, path, str(value), sentence, remedy))

    if tissue.material not in {material.name for material in procedure.materials}:
        known = ", ".join(material.name for material in procedure.materials) or "none"
        sentence = f"The tissue is made of {tissue.material!r}, which no material is named."
        add(tissue.material, sentence, f"Point lappet:material to one under {MATERIALS}; there are: {known}.")
    if not (math.isfinite(spacing) and spacing > 0.0):
        add(f"{spacing:g}", f"The lattice spacing is {spacing:g} mm.", "Give a spacing above 0; 1 mm is usual.")
    if not (math.isfinite(tissue.bed_stiffness) and tissue.bed_stiffness >= 0.0):
        sentence = f"The bed stiffness is {tissue.bed_stiffness:g} kPa/mm."
        add(f"{tissue.bed_stiffness:g}", sentence, "Give a stiffness of at least 0; 10 is usual.")
    if tissue.gravity is not None and not math.isfinite(tissue.gravity):
        sentence = f"The gravity is {tissue.gravity:g} m/s²."
        add(f"{tissue.gravity:g}", sentence, "Give a finite number, 9.81 on earth, or none.")
    if tissue.uv is not None:
        corners = len(tissue.face_vertex_indices)
        if len(tissue.uv) != corners:
            sentence = f"There are {len(tissue.uv)} texture coordinates for {corners} face corners."
            add(len(tissue.uv), sentence, "Give one for each face corner, or none.")
        elif not np.isfinite(tissue.uv).all():
            add("not finite", "A texture coordinate is not finite.", "Unwrap the mesh again.")
    faces = len(tissue.face_vertex_counts)
    for name, subset in tissue.subsets.items():
        outside = subset[(subset < 0) | (subset >= faces)]
        if len(outside):
            sentence = f"The subset {name!r} names face {outside[0]}, but the tissue has {faces} faces."
            add(outside[0], sentence, "Select its faces again.", f"{TISSUE}/{name}")
        elif len(np.unique(subset)) != len(subset):
            sentence = f"The subset {name!r} names a face twice."
            add(name, sentence, "Select its faces again.", f"{TISSUE}/{name}")
    held = any(len(tissue.subsets.get(name, ())) for name in ("fixed", "bed"))
    if not held and not any(isinstance(event, Retractor) for event in procedure.events):
        sentence = "Nothing holds the tissue: no face is fixed or on the bed, and no retractor grips it."
        remedy = "Put faces into the subset fixed or bed."
        problems.append(Problem(ProblemCode.UNSORTED, TISSUE, "no fixed faces", sentence, remedy, "warning"))
    return problems


def _lattice(measure: TissueMeasure, spacing: float, memory_budget: float) -> list[Problem]:
    if not (math.isfinite(spacing) and spacing > 0.0 and (measure.size > 0.0).any()):
        return []
    problems = []
    lattice = measure.lattice(spacing)
    if lattice.bytes > memory_budget:
        least = measure.least_spacing(memory_budget)
        sentence = (
            f"A lattice of {spacing:g} mm would have about {lattice.cells:.2g} cells and take "
            f"{lattice.bytes / 2**30:.3g} GiB, more than the memory budget of {memory_budget / 2**30:.3g} GiB."
        )
        problems.append(
            Problem(
                ProblemCode.UNSORTED, TISSUE, f"{spacing:g} mm", sentence, f"Use a spacing of at least {least:g} mm."
            )
        )
    thickness = float(measure.size.min())
    if spacing > thickness > 0.0:
        sentence = f"The lattice spacing of {spacing:g} mm is larger than the tissue is thick ({thickness:.3g} mm)."
        remedy = f"Use a spacing of {thickness:.3g} mm or less."
        problems.append(Problem(ProblemCode.UNSORTED, TISSUE, f"{spacing:g} mm", sentence, remedy, "warning"))
    return problems
