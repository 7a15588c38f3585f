"""What is wrong with single events: their times, numbers and places. `event conflicts` looks at them together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from lappet.core.problem import Problem, Severity
from lappet.core.problem_code import ProblemCode
from lappet.geometry.curve import CurveError, sample_curve
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import Event, Excision, Hook, Incision, Landmark, Point, Procedure, Retractor, Suture, Undermine
from lappet.tissue.rest_space import RestSpace


class EventCheck:
    """Checks the events of one procedure one by one.

    rest: the tissue at rest, or None where its mesh cannot be read; places are then left unchecked.
    """

    def __init__(self, procedure: Procedure, rest: RestSpace | None) -> None:
        self.procedure, self.rest = procedure, rest
        self.problems: list[Problem] = []
        self._path = ""

    def check(self, event: Event, path: str) -> None:
        """Adds the problems of one event to `problems`."""
        self._path = path
        match event:
            case Incision():
                self._time("made", event.time)
                self._positive("kerf", event.kerf, "mm", "Give the cut a width above 0; 0.05 mm is usual.")
                if event.depth is not None:
                    self._positive("depth", event.depth, "mm", "Give a depth above 0, or cut through.")
                self._curve(event.points, event.basis, event.closed)
            case Excision():
                self._time("made", event.time)
                if self._points("seed", event.seeds):
                    self._on_tissue("seed", event.seeds)
            case Undermine():
                self._time("made", event.time)
                self._curve(event.points, event.basis, True)
                if len(self.procedure.tissue.subsets.get("bed", ())) == 0:
                    sentence = "The undermining frees nothing: no face of the tissue is on the bed."
                    self._add("no bed", sentence, "Name the attached faces in the subset bed.", "warning")
            case Hook():
                self._hold(event)
                self._positive("stiffness", event.stiffness, "mN/mm", "Give a stiffness above 0; 500 is usual.")
                if self._points("anchor", [event.anchor]):
                    self._on_tissue("anchor", [event.anchor])
                self._samples("target", [time for time, _ in event.targets])
                self._targets(event)
            case Retractor():
                self._hold(event)
                self._grip(event)
                if self._samples("transform", [time for time, _ in event.motion]):
                    self._rigid(event)
            case Suture():
                self._suture(event)
            case Landmark():
                if not event.label:
                    self._add("no label", "The landmark has no label.", "Give it one; measures are reported under it.")
                if self._points("point", event.points):
                    self._on_tissue("point", event.points)

    def _add(self, value: object, sentence: str, remedy: str, severity: Severity = "error") -> None:
        self.problems.append(Problem(ProblemCode.UNSORTED, self._path, str(value), sentence, remedy, severity))

    def _finite(self, name: str, value: float) -> bool:
        if math.isfinite(value):
            return True
        self._add(f"{value:g}", f"The {name} is {value:g}.", "Give a finite number.")
        return False

    def _positive(self, name: str, value: float, unit: str, remedy: str) -> None:
        if not (math.isfinite(value) and value > 0.0):
            self._add(f"{value:g}", f"The {name} is {value:g} {unit}.", remedy)

    def _time(self, verb: str, time: float, name: str = "time") -> None:
        if not self._finite(name, time):
            return
        start, end = self.procedure.start_time, self.procedure.end_time
        if time > end:
            sentence = f"It is {verb} at time {time:g}, after the end of the timeline at {end:g}."
            self._add(f"{time:g}", sentence, f"Move it to {end:g} or before, or set endTimeCode later.")
        elif time < start:
            sentence = f"It is {verb} at time {time:g}, before the timeline begins at {start:g}, and acts from there."
            self._add(f"{time:g}", sentence, f"Move it to {start:g} or later.", "warning")

    def _hold(self, event: Hook | Retractor) -> None:
        self._time("set", event.start, "start")
        if self._finite("release", event.release) and event.release <= event.start:
            sentence = f"It is released at {event.release:g}, not after its start at {event.start:g}."
            self._add(f"{event.release:g}", sentence, f"Release it after {event.start:g}.")

    def _samples(self, name: str, times: Sequence[float]) -> bool:
        if not times:
            self._add("no samples", f"It has no {name} samples.", f"Author at least one {name}.")
            return False
        if not np.isfinite(times).all():
            self._add("not finite", f"A {name} sample has a time that is not finite.", "Give it a time code.")
            return False
        ordered = sorted(times)
        twice = [a for a, b in pairwise(ordered) if a == b]
        if twice:
            sentence = f"It has two {name}s at time {twice[0]:g}."
            self._add(f"{twice[0]:g}", sentence, "Leave one of them.")
        return not twice

    def _points(self, name: str, points: Sequence[Point]) -> bool:
        if not points:
            self._add(f"no {name}", f"It has no {name}.", f"Give it at least one {name}.")
            return False
        for point in points:
            if not np.isfinite(point).all():
                self._add(at(point), f"The {name} {at(point)} is not finite.", "Replace it by finite numbers.")
                return False
        return True

    def _on_tissue(self, name: str, points: Sequence[Point]) -> None:
        if self.rest is None:
            return
        for point, off in zip(points, self.rest.off(points), strict=True):
            if off > 0.0:
                sentence = f"The {name} {at(point)} is {off:.3g} mm off the tissue."
                self._add(at(point), sentence, "Move it onto the tissue at rest.")

    def _curve(self, points: Sequence[Point], basis: str, closed: bool) -> None:
        if not self._points("point", points):
            return
        step = 1.0 if self.rest is None else max(self.rest.diagonal / 200.0, 1e-9)
        try:
            samples = sample_curve(points, basis, closed, step)  # type: ignore[arg-type]
        except CurveError as cause:
            said, _, remedy = str(cause).partition("; ")
            self._add(f"{len(points)} points", _sentence(said), _sentence(remedy or "draw the curve again"))
            return
        if self.rest is None:
            return
        nearest = self.rest.nearest(samples[:: max(1, len(samples) // 64)])
        if nearest > 0.0:
            sentence = f"The whole curve is off the tissue, by {nearest:.3g} mm or more."
            self._add(f"{nearest:.3g} mm", sentence, "Draw it on the rest surface.")

    def _targets(self, event: Hook) -> None:
        for time, target in event.targets:
            if not np.isfinite(target).all():
                sentence = f"The target {at(target)} at time {time:g} is not finite."
                self._add(at(target), sentence, "Replace it by finite numbers.")
                return

    def _grip(self, event: Retractor) -> None:
        subsets = self.procedure.tissue.subsets
        if event.grip not in subsets:
            known = ", ".join(subsets) or "none"
            sentence = f"It grips the faces {event.grip!r}, which the tissue does not name."
            self._add(event.grip, sentence, f"Name a face subset of the tissue; there are: {known}.")
        elif len(subsets[event.grip]) == 0:
            self._add(event.grip, f"It grips {event.grip!r}, which holds no face.", "Put faces into the subset.")

    def _rigid(self, event: Retractor) -> None:
        wrong = [len(matrix) for _, matrix in event.motion if len(matrix) != 16]
        if wrong:
            self._add(wrong[0], f"A transform has {wrong[0]} numbers.", "Give 16, a 4 by 4 matrix.")
            return
        try:
            RigidMotion(event.motion)
        except ValueError as cause:
            said, _, remedy = str(cause).partition("; ")
            self._add("transform", _sentence(said), _sentence(remedy or "replace it by finite numbers"))

    def _suture(self, event: Suture) -> None:
        self._time("placed", event.start, "start")
        if self._finite("duration", event.duration):
            if event.duration < 0.0:
                sentence = f"The duration is {event.duration:g}."
                self._add(f"{event.duration:g}", sentence, "Give 0 (at once) or a longer time.")
            elif event.start <= self.procedure.end_time < event.start + event.duration:
                drawn, end = event.start + event.duration, self.procedure.end_time
                sentence = f"It is drawn together at {drawn:g}, after the end of the timeline at {end:g}."
                self._add(f"{drawn:g}", sentence, "Shorten it, or set endTimeCode later.", "warning")
        self._positive("stiffness", event.stiffness, "mN/mm", "Give a stiffness above 0; 1000 is usual.")
        if self._points("anchor", event.anchors):
            self._on_tissue("anchor", event.anchors)
            apart, least = math.dist(*event.anchors), same_point(self.procedure)
            if apart <= least:
                sentence = f"It joins a point to itself: both anchors are at {at(event.anchors[0])}."
                self._add(at(event.anchors[0]), sentence, "Put the anchors on the two sides of a wound.")


def same_point(procedure: Procedure) -> float:
    """Anchors nearer than this (mm) are one point: a thousandth of the lattice spacing."""
    spacing = procedure.tissue.spacing
    return 1e-3 * spacing if math.isfinite(spacing) and spacing > 0.0 else 1e-6


def at(point: Sequence[float]) -> str:
    """A point as people read it: (1.25, 0, -3), mm."""
    return "(" + ", ".join(f"{v:.6g}" for v in point) + ")"


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:].rstrip(".") + "."
