"""How a region of the Timeline or Dope Sheet shows strips, and what is at a pixel of it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import bpy

from .scene_strips import scene_steps, scene_strips
from .strip import Part, Step, Strip, steps_of
from .strip_drag import Span
from .strip_layout import Hit, StripPicture, StripView, hit, strip_picture

MODES = ("TIMELINE", "DOPESHEET")
_SCRUB, _MARKERS, _SCROLLBAR = 24.0, 22.0, 6.0  # heights of Blender's own, at a scale of 1


@dataclass
class StripPreview:
    """What a drag would make of strips: drawn in place of the events, which stay as they are until it ends.

    copies: the events stay and copies would be added. line: the frame that it snapped to.
    """

    scene: str = ""
    spans: dict[str, Span] = field(default_factory=dict)
    copies: bool = False
    line: float | None = None
    step: Step | None = None
    shift: float = 0.0


preview = StripPreview()


def show_preview(shown: StripPreview) -> None:
    """Show what a drag would do from now on."""
    global preview
    preview = shown
    redraw_strips()


def clear_preview() -> None:
    """Show the events as they are."""
    show_preview(StripPreview())


def redraw_strips() -> None:
    """Have the editors that show strips drawn again."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        for area in window.screen.areas:
            if area.type == "DOPESHEET_EDITOR":
                area.tag_redraw()


def shows_strips(scene: bpy.types.Scene | None, space: Any) -> bool:
    """Whether an editor shows the strips of a scene."""
    if scene is None or getattr(space, "type", "") != "DOPESHEET_EDITOR" or space.mode not in MODES:
        return False
    return bool(scene.lappet.show_strips) and len(scene.lappet.events) > 0


def view_of(scene: bpy.types.Scene, space: Any, region: Any) -> StripView:
    """The frames and pixels of a region."""
    points = float(bpy.context.preferences.system.ui_scale) or 1.0  # 0 without windows
    left, right = (region.view2d.region_to_view(x, 0)[0] for x in (0, region.width))
    scale = region.width / max(right - left, 1e-6)
    markers = _MARKERS if len(scene.timeline_markers) and getattr(space, "show_markers", True) else 0.0
    scrolled = 0.0
    if space.mode == "DOPESHEET":
        scrolled = max(0.0, -float(region.view2d.region_to_view(0, region.height)[1]))
    return StripView(left, scale, region.height - _SCRUB * points, (markers + _SCROLLBAR) * points, points, scrolled)


def picture_in(scene: bpy.types.Scene, space: Any, region: Any) -> StripPicture:
    """The strips of a scene in a region, as the drag under way would have them."""
    return strip_picture(shown_strips(scene), shown_steps(scene), view_of(scene, space, region))


def shown_strips(scene: bpy.types.Scene) -> list[Strip]:
    """The strips of a scene, with those that are dragged where they would be."""
    strips = scene_strips(scene)
    if preview.scene != scene.name or not preview.spans:
        return list(strips)
    shown = []
    for strip in strips:
        span = preview.spans.get(strip.uid)
        moved = strip if span is None else replace(strip, start=span.start, end=span.end)
        if preview.copies and span is not None:
            shown += [replace(strip, selected=False), replace(moved, uid=f"{strip.uid} copy")]
        else:
            shown.append(moved)
    return shown


def shown_steps(scene: bpy.types.Scene) -> tuple[Step, ...]:
    """The steps of a scene, with the one that is dragged where it would be."""
    if preview.scene != scene.name or preview.step is None:
        return scene_steps(scene)
    start = round(preview.step.start)
    markers = [
        (each.name, each.frame + (round(preview.shift) if each.frame == start else 0))
        for each in scene.timeline_markers
    ]
    return steps_of([(name, float(frame)) for name, frame in markers], float(scene.frame_end))


def hit_at(context: bpy.types.Context, event: bpy.types.Event) -> Hit | None:
    """What is under the mouse, None where it is not over strips."""
    space, region = context.space_data, context.region
    if region is None or region.type != "WINDOW" or not shows_strips(context.scene, space):
        return None
    x, y = event.mouse_region_x, event.mouse_region_y
    view = view_of(context.scene, space, region)
    if not (0 <= x < region.width and view.bottom <= y <= view.top):
        return None
    return hit(picture_in(context.scene, space, region), x, y, view.points)


def strip_at(context: bpy.types.Context, event: bpy.types.Event) -> str:
    """The uid of the strip under the mouse, "" for none."""
    found = hit_at(context, event)
    return found.uid if found is not None and found.part is not Part.STEP else ""
