"""A suture run of a scene as the value that a procedure holds, and back."""

from __future__ import annotations

from typing import Any

from lappet.procedure import Point, SutureLayer, SutureRun

from .decimals import decimal
from .event_kinds import MODE_OF, ORDER_OF, PATTERN_OF, THREAD_OF
from .event_list import set_points

_PATTERN_NAMES = {pattern: name for name, pattern in PATTERN_OF.items()}
_ORDER_NAMES = {order: name for name, order in ORDER_OF.items()}
_MODE_NAMES = {mode: name for name, mode in MODE_OF.items()}
_THREAD_NAMES = {thread: name for name, thread in THREAD_OF.items()}


def run_value(event: Any, name: str, start: float, points: tuple[Point, ...]) -> SutureRun:
    """The run of an event with these points of both edges."""
    second = min(int(event.second_from), len(points))
    return SutureRun(
        name,
        (points[:second], points[second:]),
        start,
        (1 if event.first_left else -1, 1 if event.second_left else -1),
        run_corners(event),
        decimal(event.duration),
        decimal(event.spacing),
        decimal(event.margin) if event.margin >= 0.0 else None,
        decimal(event.bite) if event.bite >= 0.0 else None,
        run_layers(event) or (SutureLayer(),),
        PATTERN_OF[event.pattern],
        decimal(event.pass_depth),
        ORDER_OF[event.order],
        MODE_OF[event.mode],
        THREAD_OF[event.thread],
        decimal(event.stiffness),
        decimal(event.drawn),
        decimal(event.tension),
        decimal(event.pull_through),
        run_insides(event),
    )


def set_run(event: Any, run: SutureRun) -> None:
    """Give an event the values of a run."""
    event.start, event.duration, event.stiffness = run.start, run.duration, run.stiffness
    event.spacing, event.pass_depth, event.drawn = run.spacing, run.pass_depth, run.drawn
    event.margin = -1.0 if run.margin is None else run.margin
    event.bite = -1.0 if run.bite is None else run.bite
    event.pattern, event.order = _PATTERN_NAMES[run.pattern], _ORDER_NAMES[run.order]
    event.mode, event.thread = _MODE_NAMES[run.mode], _THREAD_NAMES.get(run.thread, "NONE")
    event.tension, event.pull_through = run.tension, run.pull_through
    event.first_left, event.second_left = run.sides[0] == 1, run.sides[1] == 1
    first, second = run.edges
    set_points(event, (*first, *second))
    event.second_from = len(first)
    set_corners(event, run.corners, run.insides)
    set_layers(event, run.layers)


def run_corners(event: Any) -> tuple[tuple[int, int], ...]:
    """The corners of the edges of an event that meet."""
    return tuple((int(corner.first), int(corner.second)) for corner in event.corners)


def run_insides(event: Any) -> tuple[tuple[Point, Point], ...]:
    """Where the tissue of the corners lies, for all of them or none."""
    if not all(corner.told for corner in event.corners):
        return ()
    return tuple((_point(corner.first_inside), _point(corner.second_inside)) for corner in event.corners)


def set_corners(
    event: Any, corners: tuple[tuple[int, int], ...], insides: tuple[tuple[Point, Point], ...] = ()
) -> None:
    """Give an event the corners of a run, and where their tissue lies."""
    event.corners.clear()
    for k, (one, other) in enumerate(corners):
        corner = event.corners.add()
        corner.first, corner.second = one, other
        if insides:
            corner.told, (corner.first_inside, corner.second_inside) = True, insides[k]


def _point(place: Any) -> Point:
    x, y, z = (decimal(value) for value in place)
    return (x, y, z)


def run_layers(event: Any) -> tuple[SutureLayer, ...]:
    """The layers of an event, none where it has none."""
    return tuple(SutureLayer(str(each.name), decimal(each.depth), bool(each.between)) for each in event.layers)


def set_layers(event: Any, layers: tuple[SutureLayer, ...]) -> None:
    """Give an event the layers of a run."""
    event.layers.clear()
    for layer in layers:
        own = event.layers.add()
        own.name, own.depth, own.between = layer.name, layer.depth, layer.between
