"""An event's line in the storyboard: its kind, when it acts, and where it is and what it does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from lappet.procedure.cuts import Excision, Incision, Thin, Undermine
from lappet.procedure.events import (
    Event,
    Hook,
    Landmark,
    Pressure,
    Retractor,
    Section,
    Suture,
    Traction,
)
from lappet.procedure.exact_values import Point
from lappet.procedure.plain_text import number, place
from lappet.procedure.suture_run import SutureRun, describe_run

_MAX_PLACES = 3  # of a landmark that are listed


def duration_text(event: Event) -> str:
    """Write when an event acts, as the storyboard does.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    str
        A time code, two with a dash, or "always".
    """
    match event:
        case Hook() | Retractor() | Traction() | Pressure():
            return f"{number(event.start)} – {number(event.release)}"
        case Suture() | SutureRun():
            return f"{number(event.start)} – {number(event.start + event.duration)}"
        case Landmark() | Section():
            return "always"
        case _:
            return number(event.time)


def describe(event: Event) -> str:
    """Describe what an event does, in a few words with units.

    Parameters
    ----------
    event
        The event.

    Returns
    -------
    str
        A part of a sentence.
    """
    match event:
        case Incision():
            depth = "through" if event.depth is None else f"{number(event.depth)} mm deep"
            closed = ", closed" if event.closed else ""
            along = "" if event.direction is None else f", blade along {place(event.direction)}"
            curve = _curve(event.points, event.basis, event.closed)
            return f"{depth}, {curve}{closed}, kerf {number(event.kerf)} mm{along}"
        case Excision():
            return "discards the fragment at " + " and ".join(place(seed) for seed in event.seeds)
        case Undermine():
            return f"frees the bed inside {_curve(event.points, event.basis, True)}"
        case Thin():
            dressing = f", a dressing of {number(event.dressing)} kPa on it" if event.dressing > 0.0 else ""
            return f"leaves {number(event.thickness)} mm inside {_curve(event.points, event.basis, True)}{dressing}"
        case Hook():
            last = event.targets[-1][1] if event.targets else event.anchor
            travel = math.dist(event.anchor, last)
            return f"{place(event.anchor)} drawn {number(travel)} mm to {place(last)}, {number(event.stiffness)} mN/mm"
        case Retractor():
            return f"moves {event.grip!r}{_motion(event)}"
        case Suture():
            ends = f"{place(event.anchors[0])} to {place(event.anchors[-1])}"
            if len(event.anchors) == 2:
                return f"{ends}, {number(event.rest_length)} mm apart at rest, {_hold(event)}"
            bites = f"through {len(event.anchors)} bites, {number(event.rest_length)} mm of thread at rest"
            return f"{ends} {bites}, {_hold(event)}"
        case SutureRun():
            return describe_run(event)
        case Traction():
            most = max((value for _, value in event.traction), key=lambda each: math.hypot(*each), default=(0.0,) * 3)
            return f"{place(most)} kPa at most on {event.faces!r}"
        case Pressure():
            peak = max((value for _, value in event.pressure), key=abs, default=0.0)
            return f"{number(peak)} kPa at most on {event.faces!r}"
        case Landmark():
            if len(event.points) > _MAX_PLACES:
                return f"{event.label!r} at {len(event.points)} points from {place(event.points[0])}"
            return f"{event.label!r} at " + " and ".join(place(point) for point in event.points)
        case Section():
            return f"{event.label!r} through {place(event.point)} across {place(event.normal)}"


def _curve(points: Sequence[Point], basis: str, closed: bool) -> str:
    ring = [*points, points[0]] if closed and points else list(points)
    if basis == "linear":
        return f"{number(sum(math.dist(a, b) for a, b in pairwise(ring)))} mm through {len(points)} points"
    return f"a {basis} curve of {len(points)} points"


def _hold(event: Suture) -> str:
    """How a suture holds."""
    if event.mode == "exact":
        return "closed exactly"
    thread = f"{event.thread}, " if event.thread else ""
    most = f" with {number(event.tension)} mN at most" if event.tension > 0.0 else ""
    return f"{thread}{number(event.axial_stiffness)} mN/mm, drawn to {number(event.length)} mm{most}"


def _motion(event: Retractor) -> str:
    samples = [np.array(matrix).reshape(4, 4) for _, matrix in event.motion if len(matrix) == 16]
    if not samples:
        return ""
    with np.errstate(invalid="ignore"):
        turn = samples[0][:3, :3].T @ samples[-1][:3, :3]
        angle = math.degrees(math.acos(float(np.clip((np.trace(turn) - 1.0) / 2.0, -1.0, 1.0))))
    travel = number(float(np.linalg.norm(samples[-1][3, :3] - samples[0][3, :3])))
    turned = f" and turns it by {angle:.3g}°" if angle > 0.05 else ""
    return f" by {travel} mm{turned} over {len(samples)} samples"
