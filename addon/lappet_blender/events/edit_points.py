"""Move, insert and remove the points of an event."""

from __future__ import annotations

from typing import Any

import bpy

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode

from ..model.changes import changed
from ..model.event_list import set_points
from ..model.event_values import event_value
from .add_events import Place
from .event_check import check_events

# Fewest points of a kind whose number may change: hooks and sutures keep the number they have.
MIN_POINTS = {"INCISION": 2, "UNDERMINE": 3, "THIN": 3, "EXCISION": 1, "LANDMARK": 1}


def move_point(scene: bpy.types.Scene, event: Any, index: int, co: Place) -> None:
    """Move a point of an event. co: mm at rest."""
    places = _places(event, index)
    places[index] = tuple(co)
    _change(scene, event, places)


def insert_point(scene: bpy.types.Scene, event: Any, index: int, co: Place) -> None:
    """Insert a point into the line of an event, before the one of this index. co: mm at rest."""
    places = _places(event, index, beyond=1)
    if event.kind not in MIN_POINTS:
        raise refused(ProblemCode.EVENT_POINTS_FIXED, event.name, len(places))
    places.insert(index, tuple(co))
    _change(scene, event, places)


def remove_point(scene: bpy.types.Scene, event: Any, index: int) -> None:
    """Remove a point from the line of an event."""
    places = _places(event, index)
    if len(places) <= MIN_POINTS.get(event.kind, len(places)):
        raise refused(ProblemCode.EVENT_POINTS_NEEDED, event.name, len(places))
    del places[index]
    _change(scene, event, places)


def _places(event: Any, index: int, beyond: int = 0) -> list[tuple[float, ...]]:
    """The points of an event; raises RefusedError for an index that it has not."""
    places = [tuple(point.co) for point in event.points]
    if index >= len(places) + beyond:
        raise refused(ProblemCode.EVENT_POINT_UNKNOWN, event.name, index, count=len(places))
    return places


def _change(scene: bpy.types.Scene, event: Any, places: list[tuple[float, ...]]) -> None:
    """Give the event other points, or leave it as it was and raise why not."""
    before = [tuple(point.co) for point in event.points]
    set_points(event, places)
    try:
        check_events(scene, [event_value(scene, event)])
    except RefusedError:
        set_points(event, before)
        raise
    changed(scene)
