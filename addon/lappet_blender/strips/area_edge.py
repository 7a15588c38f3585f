"""Move the upper edge of an area; Blender does so only while the mouse is on it: the mouse goes there, and back."""

from __future__ import annotations

import bpy

_PAUSE, _TRIES = 0.05, 20
_waiting: _Edge | None = None


class _Edge:
    """An edge that is still to be moved."""

    def __init__(self, window: bpy.types.Window, at: tuple[int, int], delta: int, mouse: tuple[int, int]) -> None:
        self.window, self.at, self.delta, self.mouse, self.tries = window, at, delta, mouse, 0

    def move(self) -> bool:
        """Whether Blender moved it."""
        with bpy.context.temp_override(window=self.window, screen=self.window.screen):
            if not bpy.ops.screen.area_move.poll():
                return False
            x, y = self.at
            return bpy.ops.screen.area_move("EXEC_DEFAULT", x=x, y=y, delta=self.delta) == {"FINISHED"}


def raise_edge(window: bpy.types.Window, area: bpy.types.Area, delta: int, mouse: tuple[int, int] | None) -> None:
    """Move the upper edge of an area by pixels, at once or when the mouse has come to it.

    mouse: where it is put back, in pixels of the window; None where nobody holds it.
    """
    global _waiting
    at = area.x + area.width // 2, area.y + area.height
    edge = _Edge(window, at, delta, mouse or at)
    if edge.move():
        return
    stop()
    _waiting = edge
    window.cursor_warp(*at)
    bpy.app.timers.register(_try, first_interval=_PAUSE)


def stop() -> None:
    """Move nothing any more."""
    global _waiting
    _waiting = None
    if bpy.app.timers.is_registered(_try):
        bpy.app.timers.unregister(_try)


def _try() -> float | None:
    global _waiting
    edge = _waiting
    if edge is None or edge.window not in list(bpy.context.window_manager.windows):
        _waiting = None
        return None
    edge.tries += 1
    if not edge.move() and edge.tries < _TRIES:
        return _PAUSE
    edge.window.cursor_warp(*edge.mouse)
    _waiting = None
    return None
