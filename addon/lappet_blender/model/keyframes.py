"""The animation curves of a datablock: in Blender 4.5 on its action, from 5.0 on in the channelbag of its slot."""

from __future__ import annotations

from typing import Any

import bpy


def curves_of(owner: bpy.types.ID) -> list[Any]:
    """Return the F-curves that act on the datablock; since Blender 4.4 an action has slots and layers."""
    data = owner.animation_data
    if data is None or data.action is None:
        return []
    slot = getattr(data, "action_slot", None)
    if slot is None:
        return list(getattr(data.action, "fcurves", ()))  # 5.0 has none, and an action without a slot moves nothing
    bags = (strip.channelbag(slot) for layer in data.action.layers for strip in layer.strips)
    return [curve for bag in bags if bag is not None for curve in bag.fcurves]


def samples(curve: Any, start: int, end: int) -> list[tuple[float, float]]:
    """(time, value) between which linear interpolation follows the curve.

    The keyframes themselves where they are joined by straight lines, otherwise one sample per whole frame between
    `start` and `end` as well.
    """
    points = list(curve.keyframe_points)
    times = {float(point.co[0]) for point in points}
    if any(point.interpolation != "LINEAR" for point in points[:-1]) or curve.modifiers:
        times |= {float(time) for time in range(start, end + 1)}
    return [(time, float(curve.evaluate(time))) for time in sorted(times)]
