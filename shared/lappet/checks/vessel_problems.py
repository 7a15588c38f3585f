"""What is wrong with the vessels and nerves of a procedure."""

from __future__ import annotations

import math

import numpy as np

from lappet.checks.event_problems import OFF_TISSUE, UNSAID
from lappet.core.problem import Place, Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.curve import sample_curve
from lappet.geometry.surface_check import place
from lappet.procedure import VESSEL_KINDS, Procedure, Vessel
from lappet.procedure.prim_paths import ANATOMY
from lappet.tissue.rest_space import RestSpace

_SAMPLES = 200  # along the tissue's diagonal


def vessel_problems(procedure: Procedure, rest: RestSpace | None) -> list[Problem]:
    """Find every problem of a procedure's vessels but for their names.

    Parameters
    ----------
    procedure
        The procedure.
    rest
        The tissue at rest, or None where its mesh cannot be read; places are then left unchecked.

    Returns
    -------
    list[Problem]
        The problems; of the places along a vessel that are outside the tissue the worst one.
    """
    problems: list[Problem] = []
    for vessel in procedure.vessels:
        path = f"{ANATOMY}/{vessel.name}"
        if vessel.kind not in VESSEL_KINDS:
            known = ", ".join(VESSEL_KINDS)
            problems.append(problem(ProblemCode.VESSEL_KIND, path, repr(vessel.kind), known=known))
        if not (math.isfinite(vessel.radius) and vessel.radius > 0.0):
            problems.append(problem(ProblemCode.VESSEL_RADIUS, path, f"{vessel.radius:g}"))
        problems += _course_problems(vessel, path, rest, procedure.tissue.spacing)
    return problems


def _course_problems(vessel: Vessel, path: str, rest: RestSpace | None, spacing: float) -> list[Problem]:
    step = 1.0 if rest is None else max(rest.diagonal / _SAMPLES, 1e-9)
    try:
        course = sample_curve(vessel.points, vessel.basis, False, step, path)
    except RefusedError as error:
        return list(error.problems)
    if rest is None or not spacing > 0.0:  # which is said of the tissue
        return []
    outside = rest.outside(course)
    worst = int(np.argmax(outside))
    off = float(outside[worst])
    if off <= UNSAID * spacing:
        return []
    code = ProblemCode.EVENT_OFF_TISSUE if off > OFF_TISSUE * spacing else ProblemCode.EVENT_ANCHOR_MOVED
    at = course[worst]
    return [problem(code, path, f"{place(np.round(at, 3))} mm", place=Place.at(at), name="course at", off=off)]
