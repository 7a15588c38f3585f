"""The surgical events of a timeline: what is pulled, gripped, loaded, sewn, followed and measured; `cuts.py` has cuts.

Below the classes is what differs from event to event and belongs to none of the later stages: when an event begins, and
how it is shifted in time. `event_text.py` has its line in the storyboard.

All points are material (rest) coordinates in mm; times are USD time codes; stiffness is in mN/mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure.cuts import Excision, Incision, Thin, Undermine
from lappet.procedure.exact_values import Point, double_point, set_fields, single_points
from lappet.procedure.prim_paths import TIMELINE
from lappet.procedure.suture_run import SutureMode, SutureRun
from lappet.procedure.threads import THREADS


@dataclass(frozen=True)
class Hook:
    """A spring from a material point to a moving target.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    anchor
        Material point on the tissue in mm.
    targets
        Samples (time code, position in mm) of the target; linear between them, held before and after.
    start
        Time code at which the hook begins to act.
    release
        Time code at which it lets go.
    stiffness
        Stiffness of the spring in mN/mm.
    """

    kind: ClassVar[str] = "Hook"
    name: str
    anchor: Point
    targets: tuple[tuple[float, Point], ...]
    start: float
    release: float
    stiffness: float = 500.0

    def __post_init__(self) -> None:
        targets = tuple((float(time) + 0.0, double_point(target)) for time, target in self.targets)
        set_fields(self, anchor=double_point(self.anchor), targets=targets)


@dataclass(frozen=True)
class Retractor:
    """A rigid motion of the surface points of a face subset.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    grip
        Name of the tissue's face subset whose points move.
    motion
        Samples (time code, 4 × 4 matrix) of the prim's own transform, 16 numbers, row-major, in USD's row-vector
        convention. What acts on the tissue is the transform relative to its value at `start`.
    start
        Time code at which the grip begins.
    release
        Time code at which it ends.
    """

    kind: ClassVar[str] = "Retractor"
    name: str
    grip: str
    motion: tuple[tuple[float, tuple[float, ...]], ...]
    start: float
    release: float

    def __post_init__(self) -> None:
        motion = tuple(
            (float(time) + 0.0, tuple(float(v) + 0.0 for v in np.asarray(matrix, np.float64).reshape(-1)))
            for time, matrix in self.motion
        )
        set_fields(self, motion=motion)


@dataclass(frozen=True)
class Suture:
    """A stitch that draws material points together and then holds them.

    Closed exactly, its two points meet, whatever force that takes. A thread pulls and never pushes: it becomes shorter
    over the duration, from the distance of its points when it is placed to its length, and stretches under its tension.
    It may go through more bites than two, and slides through them: one tension along all of it, its length the sum of
    the distances from each to the next. A loop that is tied ends where it begins; `lappet.procedure.stitches` makes
    the bites of the usual stitches.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    anchors
        The material points in mm, in the order of the thread, shape (n, 3): two, or more for a thread.
    start
        Time code at which drawing together begins.
    duration
        How many time codes it takes.
    stiffness
        Stiffness of a thread that is none from the shelf in mN/mm; a suture that closes exactly has none.
    mode
        "exact" or "thread".
    thread
        A thread of `lappet.procedure.threads.THREADS`, as "nylon 5-0", or "" for the stiffness above.
    length
        Length to which a thread is drawn in mm.
    tension
        Tension in mN with which a thread is drawn at most, or 0 for as much as it takes.
    pull_through
        Tension in mN at which the thread cuts through the tissue, which the report warns of; 0 for what the thread has.
    """

    kind: ClassVar[str] = "Suture"
    name: str
    anchors: tuple[Point, ...]
    start: float
    duration: float = 1.0
    stiffness: float = 1000.0
    mode: SutureMode = "exact"
    thread: str = ""
    length: float = 0.0
    tension: float = 0.0
    pull_through: float = 0.0

    def __post_init__(self) -> None:
        set_fields(self, anchors=tuple(double_point(anchor) for anchor in self.anchors))

    @property
    def rest_length(self) -> float:
        """The sum of the distances from each point to the next at rest in mm."""
        return sum((math.dist(a, b) for a, b in pairwise(self.anchors)), 0.0)

    @property
    def axial_stiffness(self) -> float:
        """Stiffness of the thread in mN/mm, that of a piece as long as it is through its points at rest."""
        known = THREADS.get(self.thread)
        return self.stiffness if known is None else known.stiffness(self.rest_length)

    @property
    def pull_through_limit(self) -> float:
        """Tension in mN at which it cuts through the tissue."""
        if self.pull_through > 0.0:
            return self.pull_through
        return THREADS.get(self.thread, THREADS["nylon 5-0"]).pull_through


@dataclass(frozen=True)
class Landmark:
    """Material points to follow and measure.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    points
        Material points in mm, shape (n, 3), kept in single precision.
    label
        What reports and figures call them.
    """

    kind: ClassVar[str] = "Landmark"
    name: str
    points: tuple[Point, ...]
    label: str

    def __post_init__(self) -> None:
        set_fields(self, points=single_points(self.points))


@dataclass(frozen=True)
class Traction:
    """A force per area on faces of the tissue, in one direction whatever they do.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    faces
        Name of the tissue's face subset that it acts on.
    traction
        Samples (time code, force in kPa by the area of the faces at rest); linear between them, held before and after.
    start
        Time code at which it begins to act.
    release
        Time code at which it ends.
    """

    kind: ClassVar[str] = "Traction"
    name: str
    faces: str
    traction: tuple[tuple[float, Point], ...]
    start: float
    release: float

    def __post_init__(self) -> None:
        samples = tuple((float(time) + 0.0, double_point(value)) for time, value in self.traction)
        set_fields(self, traction=samples)


@dataclass(frozen=True)
class Pressure:
    """A pressure on faces of the tissue, against their normal and by their area as they are now.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    faces
        Name of the tissue's face subset that it acts on.
    pressure
        Samples (time code, pressure in kPa, negative for suction); linear between them, held before and after.
    start
        Time code at which it begins to act.
    release
        Time code at which it ends.
    """

    kind: ClassVar[str] = "Pressure"
    name: str
    faces: str
    pressure: tuple[tuple[float, float], ...]
    start: float
    release: float

    def __post_init__(self) -> None:
        samples = tuple((float(time) + 0.0, float(value) + 0.0) for time, value in self.pressure)
        set_fields(self, pressure=samples)


@dataclass(frozen=True)
class Section:
    """A plane across the tissue at rest, whose force is measured.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure.
    point
        A material point in the plane in mm.
    normal
        Its normal, of any length: the force is that of what lies beyond on what lies before.
    label
        What reports call it.
    """

    kind: ClassVar[str] = "Section"
    name: str
    point: Point
    normal: Point
    label: str

    def __post_init__(self) -> None:
        set_fields(self, point=double_point(self.point), normal=double_point(self.normal))


HOLDS = (Hook, Retractor)  # these act from `start` to `release`


LOADS = (Traction, Pressure)  # these too


MEASURES = (Landmark, Section)  # these have no time


Event = (
    Incision
    | Excision
    | Undermine
    | Thin
    | Hook
    | Retractor
    | Traction
    | Pressure
    | Suture
    | SutureRun
    | Landmark
    | Section
)


def begins(event: Event) -> float:
    """Tell when an event begins to act.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    float
        Its time code; minus infinity for what is only measured.
    """
    match event:
        case Incision() | Excision() | Undermine() | Thin():
            return event.time
        case Landmark() | Section():
            return -math.inf
        case _:
            return event.start


def retimed(event: Event, shift: float) -> Event:
    """Shift an event in time with all its samples.

    Parameters
    ----------
    event
        The event.
    shift
        Time codes to add.

    Returns
    -------
    Event
        The shifted event.

    Raises
    ------
    RefusedError
        If the event is a landmark or a section, which have no time.
    """
    match event:
        case Incision() | Excision() | Undermine() | Thin():
            return replace(event, time=event.time + shift)
        case Hook():
            targets = tuple((time + shift, target) for time, target in event.targets)
            return replace(event, start=event.start + shift, release=event.release + shift, targets=targets)
        case Retractor():
            motion = tuple((time + shift, matrix) for time, matrix in event.motion)
            return replace(event, start=event.start + shift, release=event.release + shift, motion=motion)
        case Traction():
            traction = tuple((time + shift, value) for time, value in event.traction)
            return replace(event, start=event.start + shift, release=event.release + shift, traction=traction)
        case Pressure():
            pressure = tuple((time + shift, value) for time, value in event.pressure)
            return replace(event, start=event.start + shift, release=event.release + shift, pressure=pressure)
        case Suture() | SutureRun():
            return replace(event, start=event.start + shift)
        case Landmark() | Section():
            raise refused(ProblemCode.LANDMARK_RETIMED, f"{TIMELINE}/{event.name}", kind_words(event), name=event.name)


def kind_words(event: Event) -> str:
    """Write the kind of an event as people say it.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    str
        The words: "sutures" of a run of them.
    """
    return "sutures" if isinstance(event, SutureRun) else event.kind.lower()
