"""Edits of an event's points that keep a smooth line's doubled ends together; each is made of the points' operators."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from .handles import event_points, indices_at, is_closed
from .rest_line import segment_at
from .skin_modal import run_operator


def move_point(operator: bpy.types.Operator, event: bpy.types.PropertyGroup, index: int, rest: Sequence[float]) -> bool:
    """Moves a point and those that lie with it to a rest point (mm); all or none. Whether it was done."""
    name, before = event.name, tuple(event.points[index].co)
    moved: list[int] = []
    for each in indices_at(event, index):
        if not run_operator(operator, "point_move", event=name, index=each, co=tuple(rest)):
            for back in moved:
                run_operator(operator, "point_move", event=name, index=back, co=before)
            return False
        moved.append(each)
    return True


def insert_point(operator: bpy.types.Operator, event: bpy.types.PropertyGroup, rest: Sequence[float]) -> int:
    """Inserts a rest point (mm) into an event's line where it is nearest; returns its index, -1 where refused."""
    index = segment_at(event_points(event), rest, is_closed(event))
    done = run_operator(operator, "point_insert", event=event.name, index=index, co=tuple(rest))
    return index if done else -1


def remove_point(operator: bpy.types.Operator, event: bpy.types.PropertyGroup, index: int) -> bool:
    """Removes a point; a doubled end is laid on its neighbour, which then ends the line. Whether it was done."""
    same = indices_at(event, index)
    if len(same) == 1:
        return run_operator(operator, "point_remove", event=event.name, index=index)
    beside = same[-1] + 1 if same[-1] + 1 < len(event.points) else same[0] - 1
    if beside < 0:
        return False
    neighbour = tuple(event.points[beside].co)
    if not move_point(operator, event, index, neighbour):
        return False
    return run_operator(operator, "point_remove", event=event.name, index=beside)


def distinct_points(event: bpy.types.PropertyGroup) -> int:
    """How many points of an event lie apart."""
    points = {tuple(round(float(v), 4) for v in point.co) for point in event.points}
    return len(points)
