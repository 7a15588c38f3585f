"""What is wrong with the faces that slide."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import MOST_PLACES
from lappet.procedure import Procedure, Retractor, Roller
from lappet.procedure.prim_paths import TISSUE


def roller_problems(procedure: Procedure) -> list[Problem]:
    """Find every problem of the tissue's rollers but for their names (`lappet.procedure.prim_names.name_problems`).

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[Problem]
        The problems.
    """
    tissue = procedure.tissue
    problems: list[Problem] = []
    for roller in tissue.rollers:
        prim = f"{TISSUE}/{roller.faces}"
        faces = tissue.subsets.get(roller.faces)
        if faces is not None and len(faces) == 0:
            problems.append(problem(ProblemCode.ROLLER_FACES_EMPTY, prim, roller.faces))
        length = 1.0 if roller.normal is None else math.hypot(*roller.normal)
        if not (math.isfinite(length) and length > 0.0):
            problems.append(problem(ProblemCode.ROLLER_NORMAL, prim, roller.normal))
        problems += [
            _shared(ProblemCode.ROLLER_HELD, prim, other, both) for other, both in _held(procedure, roller) if len(both)
        ]
    for first, second in combinations(tissue.rollers, 2):
        both = _common(procedure, first.faces, second.faces)
        if len(both):
            problems.append(_shared(ProblemCode.ROLLER_SHARED, f"{TISSUE}/{second.faces}", first.faces, both))
    return problems


def _held(procedure: Procedure, roller: Roller) -> Iterator[tuple[str, NDArray[np.int32]]]:
    grips = [event.grip for event in procedure.events if isinstance(event, Retractor)]
    for name in dict.fromkeys(["fixed", *grips]):
        yield name, _common(procedure, roller.faces, name)


def _common(procedure: Procedure, first: str, second: str) -> NDArray[np.int32]:
    none = np.zeros(0, np.int32)
    subsets = procedure.tissue.subsets
    return np.intersect1d(subsets.get(first, none), subsets.get(second, none))


def _shared(code: ProblemCode, prim: str, other: str, faces: NDArray[np.int32]) -> Problem:
    where = Place(faces=tuple(faces[:MOST_PLACES].tolist()))
    return problem(code, prim, other, place=where, other=other, faces=len(faces), first=faces[0])
