"""The events of a procedure that act on the frames, in the order in which the daemon counts them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import (
    Event,
    Hook,
    Landmark,
    Point,
    Pressure,
    Procedure,
    Retractor,
    Section,
    Suture,
    Thin,
    Traction,
)
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.anchors import PlacedAnchors


class EventAnchors(NamedTuple):
    """The anchors of events on an epoch's surface; None for an event that does not act in the epoch's frames.

    Parameters
    ----------
    hooks
        The anchor of each hook.
    sutures
        The anchors of each suture in the order of its thread.
    """

    hooks: Sequence[PlacedAnchors | None]
    sutures: Sequence[PlacedAnchors | None]


@dataclass(frozen=True, eq=False)
class TimedEvents:
    """The events of a procedure by kind.

    Parameters
    ----------
    hooks
        Hooks in the procedure's order.
    hooks_by_start
        The same in order of their start, as the program counts them.
    sutures
        Sutures in order of their start.
    retractors
        Retractors in order of their start.
    motions
        Motion of each retractor.
    marks
        Every landmark point with its landmark.
    loads
        Tractions and pressures in order of their start.
    sections
        Sections in the procedure's order.
    """

    hooks: tuple[Hook, ...]
    hooks_by_start: tuple[Hook, ...]
    sutures: tuple[Suture, ...]
    retractors: tuple[Retractor, ...]
    motions: tuple[RigidMotion, ...]
    marks: tuple[tuple[Landmark, Point], ...]
    loads: tuple[Traction | Pressure, ...] = ()
    sections: tuple[Section, ...] = ()

    @classmethod
    def of(cls, procedure: Procedure) -> TimedEvents:
        """Sort the events of a procedure.

        Parameters
        ----------
        procedure
            The procedure.

        Returns
        -------
        TimedEvents
            Its events.

        Raises
        ------
        RefusedError
            If the motion of a retractor is not rigid.
        """
        hooks = [event for event in procedure.events if isinstance(event, Hook)]
        sutures = [event for event in procedure.events if isinstance(event, Suture)]
        retractors = [event for event in procedure.events if isinstance(event, Retractor)]
        retractors.sort(key=lambda event: event.start)
        return cls(
            hooks=tuple(hooks),
            hooks_by_start=tuple(sorted(hooks, key=lambda event: event.start)),
            sutures=tuple(sorted(sutures, key=lambda event: event.start)),
            retractors=tuple(retractors),
            motions=tuple(RigidMotion(retractor.motion, event_path(retractor)) for retractor in retractors),
            marks=tuple(
                (event, point) for event in procedure.events if isinstance(event, Landmark) for point in event.points
            ),
            loads=tuple(
                sorted(
                    [
                        *(event for event in procedure.events if isinstance(event, Traction | Pressure)),
                        *(_dressing(event) for event in procedure.events if isinstance(event, Thin) and event.dressing),
                    ],
                    key=lambda event: event.start,
                )
            ),
            sections=tuple(event for event in procedure.events if isinstance(event, Section)),
        )

    @property
    def loaded(self) -> tuple[str, ...]:
        """The face subsets that loads act on, in order of the first load on each."""
        return tuple(dict.fromkeys(load.faces for load in self.loads))

    def anchors(self) -> NDArray[np.float64]:
        """List all anchors.

        Returns
        -------
        NDArray[np.float64]
            Those of hooks, sutures and landmarks in mm, shape (q, 3).
        """
        anchors = [
            *(hook.anchor for hook in self.hooks),
            *(anchor for suture in self.sutures for anchor in suture.anchors),
            *(point for _, point in self.marks),
        ]
        return np.array(anchors, np.float64).reshape(-1, 3)

    @property
    def suture_rows(self) -> list[slice]:
        """Rows in `anchors` of each suture."""
        ends = np.cumsum([len(self.hooks), *(len(suture.anchors) for suture in self.sutures)]).tolist()
        return [slice(first, end) for first, end in pairwise(ends)]

    @property
    def mark_rows(self) -> slice:
        """Rows in `anchors` of the landmarks."""
        return slice(len(self.hooks) + sum(len(suture.anchors) for suture in self.sutures), None)

    def arrays(self, time: float, anchors_of: EventAnchors) -> dict[str, NDArray[Any]]:
        """Collect what acts at a time.

        Parameters
        ----------
        time
            Time code.
        anchors_of
            Anchors on the surface of the time's epoch.

        Returns
        -------
        dict[str, NDArray[Any]]
            The arrays of `FrameConstraints` by name, without those that are empty.

        Raises
        ------
        RefusedError
            If a hook has no target.
        """
        return {
            **self._hook_arrays(time, anchors_of.hooks),
            **self._suture_arrays(time, anchors_of.sutures),
            **self._retractor_arrays(time),
            **self._load_arrays(time),
        }

    def _hook_arrays(self, time: float, anchors_of: Sequence[PlacedAnchors | None]) -> dict[str, NDArray[Any]]:
        numbers = {hook.name: number for number, hook in enumerate(self.hooks_by_start)}
        pulled = [
            (hook, found)
            for hook, found in zip(self.hooks, anchors_of, strict=True)
            if found is not None and hook.start <= time < hook.release
        ]
        if not pulled:
            return {}
        return {
            "hook_index": np.array([numbers[hook.name] for hook, _ in pulled], np.int32),
            "hook_anchors": np.concatenate([found.point for _, found in pulled]),
            "hook_triangles": np.concatenate([found.triangle for _, found in pulled]),
            "hook_targets": np.array([_target(hook, time) for hook, _ in pulled], np.float64),
            "hook_stiffness": np.array([hook.stiffness for hook, _ in pulled], np.float64),
        }

    def _suture_arrays(self, time: float, anchors_of: Sequence[PlacedAnchors | None]) -> dict[str, NDArray[Any]]:
        placed = [
            (number, suture, found)
            for number, (suture, found) in enumerate(zip(self.sutures, anchors_of, strict=True))
            if found is not None and suture.start <= time
        ]
        if not placed:
            return {}
        arrays: dict[str, NDArray[Any]] = {
            "suture_index": np.array([number for number, _, _ in placed], np.int32),
            "suture_anchors": np.array([found.point[[0, -1]] for _, _, found in placed], np.float64),
            "suture_triangles": np.array([found.triangle[[0, -1]] for _, _, found in placed], np.int32),
            "suture_closure": np.array([_closure(suture, time) for _, suture, _ in placed], np.float64),
            "suture_stiffness": np.array([suture.axial_stiffness for _, suture, _ in placed], np.float64),
        }
        threads = [suture.mode == "thread" for _, suture, _ in placed]
        if any(threads):
            arrays["suture_is_thread"] = np.array(threads, np.uint8)
            arrays["suture_length"] = np.array([suture.length for _, suture, _ in placed], np.float64)
            arrays["suture_tension"] = np.array([suture.tension for _, suture, _ in placed], np.float64)
        inner = [len(found.triangle) - 2 for _, _, found in placed]
        if any(inner):
            arrays["suture_inner_bites"] = np.array(inner, np.int32)
            arrays["inner_bite_anchors"] = np.concatenate([found.point[1:-1] for _, _, found in placed])
            arrays["inner_bite_triangles"] = np.concatenate([found.triangle[1:-1] for _, _, found in placed])
        return arrays

    def _retractor_arrays(self, time: float) -> dict[str, NDArray[Any]]:
        held = [i for i, retractor in enumerate(self.retractors) if retractor.start <= time < retractor.release]
        if not held:
            return {}
        motions = [self.motions[i].between(self.retractors[i].start, time) for i in held]
        return {
            "retractor_index": np.array(held, np.int32),
            "retractor_motion": np.array(motions, np.float64),
        }

    def _load_arrays(self, time: float) -> dict[str, NDArray[Any]]:
        faces = self.loaded
        total: dict[int, NDArray[np.float64]] = {}
        for load in self.loads:
            if load.start <= time < load.release:
                sums = total.setdefault(faces.index(load.faces), np.zeros(4))
                sums += _load_at(load, time)
        if not total:
            return {}
        index = sorted(total)
        sums = np.array([total[k] for k in index], np.float64)
        return {
            "load_index": np.array(index, np.int32),
            "load_traction": np.ascontiguousarray(sums[:, :3]),
            "load_pressure": np.ascontiguousarray(sums[:, 3]),
        }


def _dressing(event: Thin) -> Pressure:
    """What presses a thinned flap onto its ground."""
    samples = ((event.time, 0.0), (event.time + event.duration, event.dressing))
    return Pressure(event.name, event.pressed, samples if event.duration > 0.0 else samples[1:], event.time, np.inf)


def _load_at(load: Traction | Pressure, time: float) -> NDArray[np.float64]:
    """Traction (3) and pressure of a load in kPa, linear between its samples and held before and after."""
    samples: Sequence[tuple[float, Any]] = load.traction if isinstance(load, Traction) else load.pressure
    if not samples:
        raise refused(ProblemCode.EVENT_NO_SAMPLES, event_path(load), "no samples", name=load.kind.lower())
    ordered = sorted(samples)
    when, values = [sample[0] for sample in ordered], np.array([sample[1] for sample in ordered], np.float64)
    if isinstance(load, Pressure):
        return np.array([0.0, 0.0, 0.0, np.interp(time, when, values)])
    return np.array([*(np.interp(time, when, values[:, axis]) for axis in range(3)), 0.0])


def event_path(event: Event) -> str:
    """Find the prim of an event.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    str
        The prim's path.
    """
    return f"{TIMELINE}/{event.name}"


def _target(hook: Hook, time: float) -> NDArray[np.float64]:
    if not hook.targets:
        raise refused(ProblemCode.HOOK_NO_TARGET, event_path(hook))
    samples = sorted(hook.targets)
    when = [sample[0] for sample in samples]
    where = np.array([sample[1] for sample in samples], np.float64)
    return np.array([np.interp(time, when, where[:, axis]) for axis in range(3)])


def _closure(suture: Suture, time: float) -> float:
    if suture.duration <= 0.0:
        return 1.0
    return min(max((time - suture.start) / suture.duration, 0.0), 1.0)
