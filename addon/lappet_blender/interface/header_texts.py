"""The texts that running operators leave in headers and in the status bar."""

import bpy


def clear_texts() -> None:
    """Give every header and the status bar its own text again."""
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        window.workspace.status_text_set(None)
        for area in window.screen.areas:
            area.header_text_set(None)
