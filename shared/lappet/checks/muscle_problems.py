"""What is wrong with the muscles of a procedure."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import place
from lappet.procedure import Muscle, Procedure, Strand
from lappet.procedure.prim_paths import MATERIALS, MUSCLES
from lappet.tissue.rest_space import RestSpace

_SAMPLES = 25  # between two points of a strand


def muscle_problems(procedure: Procedure, rest: RestSpace | None) -> list[Problem]:
    """Find every problem of a procedure's muscles but for their names.

    Parameters
    ----------
    procedure
        The procedure.
    rest
        The tissue at rest, or None where its mesh cannot be read; places are then left unchecked.

    Returns
    -------
    list[Problem]
        The problems.
    """
    known = [material.name for material in procedure.materials]
    problems: list[Problem] = []
    for muscle in procedure.muscles:
        problems += _problems(muscle, known, rest)
    return problems


def _problems(muscle: Muscle, known: list[str], rest: RestSpace | None) -> list[Problem]:
    path = f"{MUSCLES}/{muscle.name}"
    problems: list[Problem] = []

    def add(code: ProblemCode, value: object, **fields: Any) -> None:
        problems.append(problem(code, path, value, **fields))

    if muscle.material not in known:
        names = ", ".join(known) or "none"
        add(ProblemCode.MUSCLE_MATERIAL_UNKNOWN, muscle.material or "none", materials=MATERIALS, known=names)
    if not muscle.strands:
        add(ProblemCode.MUSCLE_NO_STRAND, "no strand")
    for number, strand in enumerate(muscle.strands, start=1):
        if not _is_finite(strand):
            add(ProblemCode.MUSCLE_NOT_FINITE, "not a number", number=number)
        elif len(strand.points) < 2 or len(set(strand.points)) < 2:
            add(ProblemCode.MUSCLE_SHORT, len(strand.points), number=number)
        elif len(strand.radii) != len(strand.points):
            add(ProblemCode.MUSCLE_RADII, len(strand.radii), number=number, points=len(strand.points))
        elif min(strand.radii) < 0.0 or not max(strand.radii) > 0.0:
            add(ProblemCode.MUSCLE_RADIUS, f"{min(strand.radii):g}", number=number)
        elif rest is not None and bool((rest.outside(_course(strand)) > 0.0).all()):
            at = strand.points[0]
            add(ProblemCode.MUSCLE_OUTSIDE, f"{place(np.array(at))} mm", place=Place.at(at), number=number)
    return problems


def _course(strand: Strand) -> NDArray[np.float64]:
    """Points all along a strand in mm, shape (n, 3)."""
    points, share = np.array(strand.points), np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    stretches = [(1.0 - share) * first + share * last for first, last in pairwise(points)]
    return np.concatenate(stretches)


def _is_finite(strand: Strand) -> bool:
    return all(math.isfinite(each) for each in strand.radii) and bool(np.isfinite(np.array(strand.points)).all())
