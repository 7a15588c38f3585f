"""What is wrong between events: each may be right alone, but not together."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.checks.event_problems import at, same_point
from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.mesh_faults import MOST_PLACES
from lappet.procedure import Excision, Hook, Incision, Landmark, Procedure, Retractor, Suture
from lappet.procedure.prim_paths import TIMELINE


def event_conflicts(procedure: Procedure) -> list[Problem]:
    """Find events that are right alone, but not together.

    These are two hooks on one point at one time, faces that two things hold, an excision of what is not cut, one suture
    twice, and one label twice.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[Problem]
        The problems.
    """
    return [
        *_hooks(procedure),
        *_grips(procedure),
        *_excisions(procedure),
        *_sutures(procedure),
        *_labels(procedure),
    ]


def _hooks(procedure: Procedure) -> list[Problem]:
    problems = []
    near = same_point(procedure)
    hooks = [event for event in procedure.events if isinstance(event, Hook)]
    for first, second in combinations(hooks, 2):
        if math.dist(first.anchor, second.anchor) <= near and _together(first, second):
            time = max(first.start, second.start)
            problems.append(
                problem(
                    ProblemCode.HOOK_SAME_POINT,
                    f"{TIMELINE}/{second.name}",
                    at(second.anchor),
                    place=Place.at(second.anchor),
                    time=time,
                    other=first.name,
                    start=second.start,
                )
            )
    return problems


def _grips(procedure: Procedure) -> list[Problem]:
    problems = []
    subsets = procedure.tissue.subsets
    retractors = [event for event in procedure.events if isinstance(event, Retractor) and event.grip in subsets]
    for event in retractors:
        both = np.intersect1d(subsets[event.grip], subsets.get("fixed", np.zeros(0, np.int32)))
        if len(both):
            code = ProblemCode.GRIP_ON_FIXED if event.grip == "fixed" else ProblemCode.GRIP_OF_FIXED
            problems.append(_gripped(code, event, both))
    for first, second in combinations(retractors, 2):
        both = np.intersect1d(subsets[first.grip], subsets[second.grip])
        if len(both) and _together(first, second):
            code = ProblemCode.GRIP_TWICE
            problems.append(_gripped(code, second, both, other=first.name, start=second.start))
    return problems


def _gripped(code: ProblemCode, event: Retractor, faces: NDArray[np.int32], **fields: Any) -> Problem:
    where = Place(faces=tuple(faces[:MOST_PLACES].tolist()))
    prim = f"{TIMELINE}/{event.name}"
    return problem(code, prim, event.grip, place=where, faces=len(faces), first=faces[0], **fields)


def _excisions(procedure: Procedure) -> list[Problem]:
    problems = []
    cuts = [event.time for event in procedure.events if isinstance(event, Incision)]
    for event in procedure.events:
        if isinstance(event, Excision) and not any(time <= event.time for time in cuts):
            problems.append(problem(ProblemCode.EXCISION_BEFORE_CUT, f"{TIMELINE}/{event.name}", f"{event.time:g}"))
    return problems


def _sutures(procedure: Procedure) -> list[Problem]:
    problems = []
    near = same_point(procedure)
    sutures = [event for event in procedure.events if isinstance(event, Suture)]
    by_middle: dict[tuple[int, ...], list[Suture]] = defaultdict(list)
    for event in sutures:
        middle = np.mean(event.anchors, axis=0)
        if np.isfinite(middle).all():
            by_middle[tuple(np.round(middle / (10.0 * near)).astype(int).tolist())].append(event)
    for group in by_middle.values():
        for first, second in combinations(group, 2):
            if _same_anchors(first.anchors, second.anchors, near):
                problems.append(
                    problem(
                        ProblemCode.SUTURE_TWICE,
                        f"{TIMELINE}/{second.name}",
                        at(second.anchors[0]),
                        place=Place.at(*second.anchors),
                        other=first.name,
                    )
                )
    return problems


def _labels(procedure: Procedure) -> list[Problem]:
    marks = [event for event in procedure.events if isinstance(event, Landmark)]
    uses = Counter(event.label for event in marks if event.label)
    return [
        problem(ProblemCode.LANDMARK_LABEL_TWICE, f"{TIMELINE}/{event.name}", event.label, times=uses[event.label])
        for event in marks
        if uses[event.label] > 1
    ]


def _together(first: Hook | Retractor, second: Hook | Retractor) -> bool:
    return first.start < second.release and second.start < first.release


def _same_anchors(a: Sequence[Sequence[float]], b: Sequence[Sequence[float]], near: float) -> bool:
    if len(a) != len(b):
        return False
    return any(all(math.dist(p, q) <= near for p, q in zip(a, other, strict=True)) for other in (b, b[::-1]))
