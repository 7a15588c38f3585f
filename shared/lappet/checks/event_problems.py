"""What is wrong with single events: their times, numbers and places. `event conflicts` looks at them together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, get_args

import numpy as np

from lappet.checks.suture_run_problems import MOST_BITES, RunCheck
from lappet.core.problem import Place, Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.curve import sample_curve
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import (
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Point,
    Pressure,
    Procedure,
    Retractor,
    Section,
    Suture,
    SutureMode,
    SutureRun,
    Thin,
    Traction,
    Undermine,
)
from lappet.procedure.threads import THREADS
from lappet.suturing.single_sutures import skin_of
from lappet.tissue.rest_space import RestSpace
from lappet.tissue.skin_sheet import SkinSheet

# In lattice spacings: how far outside the tissue an anchor may be, and how far it is moved without a word (chosen).
OFF_TISSUE, UNSAID = 0.5, 0.01


class EventCheck:
    """A check of the events of one procedure, one by one.

    Parameters
    ----------
    procedure
        The procedure.
    rest
        The tissue at rest, or None where its mesh cannot be read; places are then left unchecked.
    spacing
        Lattice spacing in mm, where it is not the tissue's own.
    """

    def __init__(self, procedure: Procedure, rest: RestSpace | None, spacing: float | None = None) -> None:
        self.procedure, self.rest = procedure, rest
        self.spacing = procedure.tissue.spacing if spacing is None else spacing
        self.problems: list[Problem] = []
        self._path = ""
        # How far each place is outside the tissue, looked up at once: one by one takes longer.
        places = [point for event in procedure.events for point in _places(event) if np.isfinite(point).all()]
        self._outside = {} if rest is None else dict(zip(places, rest.outside(places).tolist(), strict=True))

    def check(self, event: Event, path: str) -> None:
        """Add the problems of one event to `problems`.

        Parameters
        ----------
        event
            The event.
        path
            Path of its prim.
        """
        self._path = path
        match event:
            case Incision():
                self._time("made", event.time)
                self._positive(ProblemCode.CUT_KERF, event.kerf)
                if event.depth is not None:
                    self._positive(ProblemCode.CUT_DEPTH, event.depth)
                if event.direction is not None and not 0.0 < math.hypot(*event.direction) < math.inf:
                    self._add(ProblemCode.CUT_DIRECTION, at(event.direction))
                self._curve(event.points, event.basis, event.closed)
            case Excision():
                self._time("made", event.time)
                if self._points("seed", event.seeds):
                    self._seeds(event.seeds)
            case Undermine():
                self._time("made", event.time)
                self._curve(event.points, event.basis, True)
                if len(self.procedure.tissue.subsets.get("bed", ())) == 0:
                    self._add(ProblemCode.UNDERMINE_NOTHING, "no bed")
            case Thin():
                self._time("made", event.time)
                self._curve(event.points, event.basis, True)
                self._thinning(event)
                self._dressing(event)
            case Hook():
                self._hold(event)
                self._positive(ProblemCode.EVENT_STIFFNESS, event.stiffness, usual=f"{Hook.stiffness:g}")
                if self._points("anchor", [event.anchor]):
                    self._anchors("anchor", [event.anchor])
                self._samples("target", [time for time, _ in event.targets])
                self._targets(event)
            case Retractor():
                self._hold(event)
                self._grip(event)
                if self._samples("transform", [time for time, _ in event.motion]):
                    self._rigid(event)
            case Traction() | Pressure():
                self._load(event)
            case Section():
                self._section(event)
            case Suture():
                self._suture(event)
            case SutureRun():
                self._run(event)
            case Landmark():
                if not event.label:
                    self._add(ProblemCode.LANDMARK_NO_LABEL, "no label")
                if self._points("point", event.points):
                    self._anchors("point", event.points)

    def _add(self, code: ProblemCode, value: object, place: Place | None = None, **fields: Any) -> None:
        self.problems.append(problem(code, self._path, value, place=place, **fields))

    def _finite(self, name: str, value: float) -> bool:
        if math.isfinite(value):
            return True
        self._add(ProblemCode.EVENT_NUMBER_NOT_FINITE, f"{value:g}", name=name)
        return False

    def _positive(self, code: ProblemCode, value: float, **fields: Any) -> None:
        if not (math.isfinite(value) and value > 0.0):
            self._add(code, f"{value:g}", **fields)

    def _time(self, verb: str, time: float, name: str = "time") -> None:
        if not self._finite(name, time):
            return
        start, end = self.procedure.start_time, self.procedure.end_time
        if time > end:
            self._add(ProblemCode.EVENT_AFTER_END, f"{time:g}", verb=verb, end=end)
        elif time < start:
            self._add(ProblemCode.EVENT_BEFORE_START, f"{time:g}", verb=verb, start=start)

    def _hold(self, event: Hook | Retractor | Traction | Pressure) -> None:
        self._time("set", event.start, "start")
        if self._finite("release", event.release) and event.release <= event.start:
            self._add(ProblemCode.EVENT_RELEASE, f"{event.release:g}", start=event.start)

    def _samples(self, name: str, times: Sequence[float]) -> bool:
        if not times:
            self._add(ProblemCode.EVENT_NO_SAMPLES, "no samples", name=name)
            return False
        if not np.isfinite(times).all():
            self._add(ProblemCode.EVENT_SAMPLE_TIME, "not finite", name=name)
            return False
        ordered = sorted(times)
        twice = [a for a, b in pairwise(ordered) if a == b]
        if twice:
            self._add(ProblemCode.EVENT_SAMPLE_TWICE, f"{twice[0]:g}", name=name)
        return not twice

    def _points(self, name: str, points: Sequence[Point]) -> bool:
        if not points:
            self._add(ProblemCode.EVENT_NO_POINT, f"no {name}", name=name)
            return False
        for point in points:
            if not np.isfinite(point).all():
                self._add(ProblemCode.EVENT_POINT_NOT_FINITE, at(point), name=name)
                return False
        return True

    def _seeds(self, seeds: Sequence[Point]) -> None:
        if self.rest is None:
            return
        for seed in seeds:
            off = self._outside[seed]
            if off > self.rest.margin:
                self._add(ProblemCode.EVENT_OFF_TISSUE, at(seed), Place.at(seed), name="seed", off=off)

    def _anchors(self, name: str, points: Sequence[Point]) -> None:
        """Judge what is held where it lies: nothing inside the tissue or on it, the rest by how far it is moved."""
        spacing = self.procedure.tissue.spacing
        if self.rest is None or not spacing > 0.0:  # which is said of the tissue
            return
        for point in points:
            off = self._outside[point]
            if off > OFF_TISSUE * spacing:
                self._add(ProblemCode.EVENT_OFF_TISSUE, at(point), Place.at(point), name=name, off=off)
            elif off > UNSAID * spacing:
                self._add(ProblemCode.EVENT_ANCHOR_MOVED, at(point), Place.at(point), name=name, off=off)

    def _curve(self, points: Sequence[Point], basis: str, closed: bool) -> None:
        if not self._points("point", points):
            return
        step = 1.0 if self.rest is None else max(self.rest.diagonal / 200.0, 1e-9)
        try:
            samples = sample_curve(points, basis, closed, step, self._path)  # type: ignore[arg-type]
        except RefusedError as refusal:
            self.problems += refusal.problems
            return
        if self.rest is None:
            return
        nearest = self.rest.nearest(samples[:: max(1, len(samples) // 64)])
        if nearest > 0.0:
            self._add(ProblemCode.CURVE_OFF_TISSUE, f"{nearest:.3g} mm", Place.at(samples[0]))

    def _thinning(self, event: Thin) -> None:
        self._positive(ProblemCode.THIN_THICKNESS, event.thickness)
        if not event.thickness > 0.0:
            return
        skins = [region.depth_from for region in self.procedure.tissue.regions if region.depth_from > 0.0]
        value, at = f"{event.thickness:g}", Place.at(*event.points)
        if skins and event.thickness < min(skins):
            self._add(ProblemCode.THIN_INTO_SKIN, value, at, skin=min(skins))
        if event.thickness < self.spacing < math.inf:
            self._add(ProblemCode.THIN_BELOW_CELLS, value, at, spacing=self.spacing)

    def _dressing(self, event: Thin) -> None:
        for name in ("dressing", "duration"):
            value: float = getattr(event, name)
            if self._finite(name, value) and value < 0.0:
                self._add(ProblemCode.THIN_NUMBER, f"{value:g}", name=name)

    def _targets(self, event: Hook) -> None:
        for time, target in event.targets:
            if not np.isfinite(target).all():
                self._add(ProblemCode.TARGET_NOT_FINITE, at(target), time=time)
                return

    def _grip(self, event: Retractor) -> None:
        subsets = self.procedure.tissue.subsets
        if event.grip not in subsets:
            known = ", ".join(subsets) or "none"
            self._add(ProblemCode.GRIP_UNKNOWN, event.grip, known=known)
        elif len(subsets[event.grip]) == 0:
            self._add(ProblemCode.GRIP_EMPTY, event.grip)

    def _load(self, event: Traction | Pressure) -> None:
        self._hold(event)
        subsets, samples = self.procedure.tissue.subsets, _samples_of(event)
        if event.faces not in subsets:
            self._add(ProblemCode.LOAD_FACES_UNKNOWN, event.faces, known=", ".join(subsets) or "none")
        elif len(subsets[event.faces]) == 0:
            self._add(ProblemCode.LOAD_FACES_EMPTY, event.faces)
        name = event.kind.lower()
        if self._samples(name, [time for time, _ in samples]):
            for time, value in samples:
                if not np.isfinite(value).all():
                    self._add(ProblemCode.LOAD_NOT_FINITE, at(value), name=name, time=time)
                    return

    def _section(self, event: Section) -> None:
        if not event.label:
            self._add(ProblemCode.LANDMARK_NO_LABEL, "no label")
        length = math.hypot(*event.normal)
        if not (np.isfinite(event.point).all() and math.isfinite(length) and length > 0.0):
            self._add(ProblemCode.SECTION_NO_PLANE, at(event.point), normal=at(event.normal))
        elif self.rest is not None:
            points = np.asarray(self.procedure.tissue.points, np.float64)
            heights = (points - event.point) @ np.asarray(event.normal) / length
            off = max(float(heights.min()), -float(heights.max()))
            if off >= 0.0:
                self._add(ProblemCode.SECTION_OFF_TISSUE, at(event.point), Place.at(event.point), off=off)

    def _rigid(self, event: Retractor) -> None:
        wrong = [len(matrix) for _, matrix in event.motion if len(matrix) != 16]
        if wrong:
            self._add(ProblemCode.TRANSFORM_NUMBERS, wrong[0])
            return
        try:
            RigidMotion(event.motion, self._path)
        except RefusedError as refusal:
            self.problems += refusal.problems

    def _drawing(self, event: Suture | SutureRun) -> None:
        self._time("placed", event.start, "start")
        if self._finite("duration", event.duration):
            if event.duration < 0.0:
                self._add(ProblemCode.SUTURE_DURATION, f"{event.duration:g}")
            elif event.start <= self.procedure.end_time < event.start + event.duration:
                drawn, end = event.start + event.duration, self.procedure.end_time
                self._add(ProblemCode.SUTURE_AFTER_END, f"{drawn:g}", end=end)
        self._positive(ProblemCode.EVENT_STIFFNESS, event.stiffness, usual=f"{Suture.stiffness:g}")

    def _known_thread(self, event: Suture | SutureRun) -> None:
        if event.thread and event.thread not in THREADS:
            self._add(ProblemCode.SUTURE_THREAD, event.thread, known=", ".join(THREADS))

    def _run(self, event: SutureRun) -> None:
        self._drawing(event)
        self._known_thread(event)
        self.problems += RunCheck(event, self._path).check(self.rest, self._skin(), self.spacing)

    def _skin(self) -> SkinSheet | None:
        """The skin, or None where the tissue has none or its subsets name faces that it lacks."""
        try:
            skin = skin_of(self.procedure.tissue)
        except IndexError:
            return None
        return skin if len(skin.normals) else None

    def _suture(self, event: Suture) -> None:
        self._drawing(event)
        self._thread(event)
        if self._points("anchor", event.anchors):
            self._anchors("anchor", event.anchors)
            least = same_point(self.procedure)
            twice = next((a for a, b in pairwise(event.anchors) if math.dist(a, b) <= least), None)
            if twice is not None:
                self._add(ProblemCode.SUTURE_OF_ONE_POINT, at(twice), Place.at(twice))
            self._bites(event)

    def _bites(self, event: Suture) -> None:
        bites, where = len(event.anchors), Place.at(*event.anchors)
        if bites < 2:
            self._add(ProblemCode.SUTURE_ANCHORS, bites, where)
        elif bites > 2 and event.mode == "exact":
            self._add(ProblemCode.SUTURE_EXACT_BITES, bites, where)
        elif bites > MOST_BITES:
            self._add(ProblemCode.SUTURE_BITES, bites, where, most=MOST_BITES)

    def _thread(self, event: Suture) -> None:
        modes = get_args(SutureMode)
        if event.mode not in modes:
            self._add(ProblemCode.SUTURE_MODE, event.mode, known=", ".join(modes))
        self._known_thread(event)
        for name in ("length", "tension", "pull_through"):
            value: float = getattr(event, name)
            if not (math.isfinite(value) and value >= 0.0):
                self._add(ProblemCode.SUTURE_NUMBER, f"{value:g}", name=name.replace("_", "-"))


def _places(event: Event) -> Sequence[Point]:
    """The points of an event that must lie on the tissue."""
    match event:
        case Excision():
            return event.seeds
        case Hook():
            return [event.anchor]
        case Suture():
            return event.anchors
        case Landmark():
            return event.points
    return ()


def _samples_of(event: Traction | Pressure) -> list[tuple[float, tuple[float, ...]]]:
    """The samples of a load, each value as numbers."""
    if isinstance(event, Traction):
        return [(time, value) for time, value in event.traction]
    return [(time, (value,)) for time, value in event.pressure]


def same_point(procedure: Procedure) -> float:
    """Compute how near anchors must be to count as one point.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    float
        Distance in mm: a thousandth of the lattice spacing.
    """
    spacing = procedure.tissue.spacing
    return 1e-3 * spacing if math.isfinite(spacing) and spacing > 0.0 else 1e-6


def at(point: Sequence[float]) -> str:
    """Write a point as people read it: (1.25, 0, -3).

    Parameters
    ----------
    point
        A point in mm.

    Returns
    -------
    str
        The text.
    """
    return "(" + ", ".join(f"{v:.6g}" for v in point) + ")"
