"""What the operators on events share: which event and which frame are meant, and how they refuse."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import bpy

from lappet.core.problem import RefusedError

from ..model.event_list import event_index

UNDOABLE = {"REGISTER", "UNDO"}
SHOWN = {"REGISTER"}


def attempt(operator: bpy.types.Operator, act: Callable[[], object]) -> set[str]:
    """Runs an act; one that is refused is reported as an error (from Python: a RuntimeError) and cancels the
    operator."""
    try:
        act()
    except RefusedError as refused:
        return refuse(operator, " ".join(f"{each.message} {each.remedy}".strip() for each in refused.problems[:3]))
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        return refuse(operator, f"{where}{(error.strerror or str(error)).rstrip('.')}; choose another folder or file.")
    return {"FINISHED"}


def refuse(operator: bpy.types.Operator, sentence: str) -> set[str]:
    """Reports a sentence and cancels."""
    operator.report({"ERROR"}, sentence)
    return {"CANCELLED"}


def named_event(scene: bpy.types.Scene, name: str) -> Any:
    """The event of that name or uid, the active one for "". Raises RefusedError where there is none."""
    events = scene.lappet.events
    index = event_index(scene, name) if name else scene.lappet.active_event
    if 0 <= index < len(events):
        return events[index]
    if not name:
        raise RefusedError("No event is active; choose one in the timeline.")
    known = ", ".join(event.name for event in events[:12]) or "none"
    raise RefusedError(f"There is no event {name!r}; there are: {known}{', …' * (len(events) > 12)}.")


def given(operator: bpy.types.Operator, name: str, otherwise: float) -> float:
    """A number of an operator; where the caller left it out, `otherwise`, which it then shows."""
    if not operator.properties.is_property_set(name):
        setattr(operator, name, otherwise)
    return float(getattr(operator, name))


def places(points: Iterable[Any]) -> list[tuple[float, float, float]]:
    """The points of an operator's collection."""
    return [(point.co[0], point.co[1], point.co[2]) for point in points]
