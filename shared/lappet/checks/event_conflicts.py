"""What is wrong between events: each may be right alone, but not together."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from itertools import combinations

import numpy as np

from lappet.checks.event_problems import at, same_point
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Excision, Hook, Incision, Landmark, Procedure, Retractor, Suture
from lappet.procedure.prim_paths import TIMELINE


def event_conflicts(procedure: Procedure) -> list[Problem]:
    """Two hooks on one point at one time, faces that two things hold, an excision of what is not cut, one suture
    twice, one label twice."""
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
            sentence = f"It holds {at(second.anchor)} at time {time:g}, where {first.name} holds the same point."
            remedy = f"Release {first.name} before {second.start:g}, or move one of the two."
            problems.append(
                Problem(ProblemCode.UNSORTED, f"{TIMELINE}/{second.name}", at(second.anchor), sentence, remedy)
            )
    return problems


def _grips(procedure: Procedure) -> list[Problem]:
    problems = []
    subsets = procedure.tissue.subsets
    retractors = [event for event in procedure.events if isinstance(event, Retractor) and event.grip in subsets]
    for event in retractors:
        both = np.intersect1d(subsets[event.grip], subsets.get("fixed", np.zeros(0, np.int32)))
        if len(both):
            sentence = f"It grips {len(both)} faces that are also fixed, face {both[0]} among them."
            remedy = f"Take them out of the subset {event.grip!r} or out of 'fixed'."
            if event.grip == "fixed":
                remedy = "Grip another subset; fixed faces stay where they are."
            problems.append(Problem(ProblemCode.UNSORTED, f"{TIMELINE}/{event.name}", event.grip, sentence, remedy))
    for first, second in combinations(retractors, 2):
        both = np.intersect1d(subsets[first.grip], subsets[second.grip])
        if len(both) and _together(first, second):
            sentence = (
                f"It grips {len(both)} faces that {first.name} grips at the same time, face {both[0]} among them."
            )
            remedy = f"Release {first.name} before {second.start:g}, or grip other faces."
            problems.append(Problem(ProblemCode.UNSORTED, f"{TIMELINE}/{second.name}", second.grip, sentence, remedy))
    return problems


def _excisions(procedure: Procedure) -> list[Problem]:
    problems = []
    cuts = [event.time for event in procedure.events if isinstance(event, Incision)]
    for event in procedure.events:
        if isinstance(event, Excision) and not any(time <= event.time for time in cuts):
            sentence = f"No incision is made by time {event.time:g}, so it would discard all tissue."
            remedy = "Cut around the piece first, or excise later."
            problems.append(
                Problem(ProblemCode.UNSORTED, f"{TIMELINE}/{event.name}", f"{event.time:g}", sentence, remedy)
            )
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
                sentence = f"It joins the same two points as {first.name}."
                problem = Problem(
                    ProblemCode.UNSORTED,
                    f"{TIMELINE}/{second.name}",
                    at(second.anchors[0]),
                    sentence,
                    "Remove one of them.",
                )
                problems.append(problem)
    return problems


def _labels(procedure: Procedure) -> list[Problem]:
    marks = [event for event in procedure.events if isinstance(event, Landmark)]
    uses = Counter(event.label for event in marks if event.label)
    return [
        Problem(
            ProblemCode.UNSORTED,
            f"{TIMELINE}/{event.name}",
            event.label,
            f"The label {event.label!r} names {uses[event.label]} landmarks.",
            "Give each its own label.",
        )
        for event in marks
        if uses[event.label] > 1
    ]


def _together(first: Hook | Retractor, second: Hook | Retractor) -> bool:
    return first.start < second.release and second.start < first.release


def _same_anchors(a: Sequence[Sequence[float]], b: Sequence[Sequence[float]], near: float) -> bool:
    return any(math.dist(a[0], c) <= near and math.dist(a[1], d) <= near for c, d in ((b[0], b[1]), (b[1], b[0])))
