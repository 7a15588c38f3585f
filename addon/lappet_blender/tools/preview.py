"""What a running tool shows on the skin; the overlay draws it. There is one at most: tools are modal."""

from __future__ import annotations

from dataclasses import dataclass, field

import bpy
from mathutils import Vector
from numpy.typing import NDArray

from .drawing import DrawnLine, Point


@dataclass
class Preview:
    """Lines and points at rest (mm), which the overlay lays on the skin as it is shown when it draws.

    threads: straight lines of the world. arrows: likewise, with a head at the second end. faces: triangles (k, 3, 3) of
    the world that are tinted. snap: the point that a click would snap to.
    """

    scene: str
    lines: list[DrawnLine] = field(default_factory=list)
    dots: list[Point] = field(default_factory=list)
    threads: list[tuple[Vector, Vector]] = field(default_factory=list)
    arrows: list[tuple[Vector, Vector]] = field(default_factory=list)
    faces: NDArray | None = None
    snap: Point | None = None
    hides: str = ""  # uid of the event that is shown by the preview instead
    kind: str = "INCISION"  # of event: its line_set


_current: list[Preview] = []


def show_preview(preview: Preview) -> None:
    """Show this instead of what was shown."""
    _current[:] = [preview]
    redraw()


def clear_preview() -> None:
    """Show nothing any more."""
    _current.clear()
    redraw()


def preview_of(scene: bpy.types.Scene) -> Preview | None:
    """What is shown in a scene."""
    return _current[0] if _current and _current[0].scene == scene.name else None


def redraw() -> None:
    """Ask every 3D viewport to draw itself anew."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()
