"""Draw all windows at once, before the properties that they show are taken away."""

import bpy


def redraw_windows() -> None:
    """Have every button made anew that shows a property.

    When the mouse leaves a button Blender reads its property once more, even one whose class is gone, and crashes.
    """
    manager = getattr(bpy.context, "window_manager", None)
    if bpy.app.background or manager is None:
        return
    for window in manager.windows:
        for area in window.screen.areas:
            area.tag_redraw()
        with bpy.context.temp_override(window=window):
            bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
