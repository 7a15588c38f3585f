"""What the properties of an operator on events mean: which event, which frame, which points."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import bpy

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..model.event_list import event_index


def named_event(scene: bpy.types.Scene, name: str) -> Any:
    """The event of that name or uid, the active one for "". Raises RefusedError where there is none."""
    events = scene.lappet.events
    index = event_index(scene, name) if name else scene.lappet.active_event
    if 0 <= index < len(events):
        return events[index]
    if not name:
        raise refused(ProblemCode.EVENT_NONE_ACTIVE)
    known = ", ".join([event.name for event in events[:12]] + ["…"] * (len(events) > 12)) or "none"
    raise refused(ProblemCode.EVENT_UNKNOWN, "", name, known=known)


def given(operator: bpy.types.Operator, name: str, otherwise: float) -> float:
    """A number of an operator; where the caller left it out, `otherwise`, which it then shows."""
    if not operator.properties.is_property_set(name):
        setattr(operator, name, otherwise)
    return float(getattr(operator, name))


def places(points: Iterable[Any]) -> list[tuple[float, float, float]]:
    """The points of an operator's collection."""
    return [(point.co[0], point.co[1], point.co[2]) for point in points]
