"""Edits of an event's points that keep the doubled ends of a smooth line together, all or none."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from lappet.core.problem import RefusedError

from ..events import edit_points
from .handles import event_points, indices_at, is_closed
from .rest_line import segment_at


def move_points(event: bpy.types.PropertyGroup, index: int, rest: Sequence[float]) -> None:
    """Move a point, and those that lie with it, to a rest point (mm). Raises RefusedError with all as they were."""
    scene, before = event.id_data, tuple(event.points[index].co)
    moved: list[int] = []
    try:
        for each in indices_at(event, index):
            edit_points.move_point(scene, event, each, rest)
            moved.append(each)
    except RefusedError:
        for each in moved:
            edit_points.move_point(scene, event, each, before)
        raise


def insert_nearest(event: bpy.types.PropertyGroup, rest: Sequence[float]) -> int:
    """Insert a rest point (mm) into an event's line where it is nearest, and return its index."""
    index = segment_at(event_points(event), rest, is_closed(event))
    edit_points.insert_point(event.id_data, event, index, rest)
    return index


def remove_points(event: bpy.types.PropertyGroup, index: int) -> None:
    """Remove a point; a doubled end is laid on its neighbor, which then ends the line."""
    same = indices_at(event, index)
    if len(same) == 1:
        edit_points.remove_point(event.id_data, event, index)
        return
    beside = same[-1] + 1 if same[-1] + 1 < len(event.points) else max(same[0] - 1, 0)
    neighbor = tuple(event.points[beside].co)
    move_points(event, index, neighbor)
    edit_points.remove_point(event.id_data, event, beside)


def distinct_points(event: bpy.types.PropertyGroup) -> int:
    """How many points of an event lie apart."""
    points = {tuple(round(float(v), 4) for v in point.co) for point in event.points}
    return len(points)
