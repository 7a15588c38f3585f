"""The keys and the menu of strips in the Timeline and the Dope Sheet."""

from __future__ import annotations

from typing import Any

import bpy

from .strip_view import MODES

_KEYMAP, _SPACE = "Dopesheet", "DOPESHEET_EDITOR"
# (operator, key, value, modifiers, properties); where no strip is under the mouse a key means what it does to Blender.
KEYS: tuple[tuple[str, str, str, dict[str, bool], dict[str, Any]], ...] = (
    ("lappet.strip_jump", "LEFTMOUSE", "DOUBLE_CLICK", {}, {}),
    ("lappet.strips_move", "LEFTMOUSE", "PRESS", {}, {}),
    ("lappet.strips_move", "LEFTMOUSE", "PRESS", {"shift": True}, {}),
    ("lappet.strips_move", "LEFTMOUSE", "PRESS", {"ctrl": True}, {}),
    ("lappet.strips_move", "G", "PRESS", {}, {}),
    ("lappet.strips_move", "D", "PRESS", {"shift": True}, {"copy": True}),
    ("lappet.strips_mute", "H", "PRESS", {}, {}),
    ("lappet.strips_remove", "X", "PRESS", {}, {}),
    ("lappet.strips_remove", "DEL", "PRESS", {}, {}),
)
_made: list[tuple[Any, Any]] = []


class LAPPET_MT_strips(bpy.types.Menu):
    """Acts on the strips of the operation's events"""

    bl_label = "Strips"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.prop(context.scene.lappet, "show_strips")
        layout.operator("lappet.strips_room", icon="FULLSCREEN_ENTER")
        layout.separator()
        layout.operator("lappet.steps_mark", icon="MARKER_HLT")
        layout.separator()
        for which, name in (("ALL", "Select All"), ("NONE", "Select None"), ("STEP", "Select Step")):
            layout.operator("lappet.strips_select", text=name).which = which
        layout.operator("lappet.strips_select", text="Select Same Kind").which = "KIND"
        layout.separator()
        layout.operator_context = "EXEC_DEFAULT"
        layout.operator("lappet.strips_mute", icon="HIDE_ON")
        layout.operator("lappet.strips_remove", icon="REMOVE")


def _draw_menu(self: Any, context: bpy.types.Context) -> None:
    space, scene = context.space_data, context.scene
    if getattr(space, "mode", "") in MODES and scene is not None and len(scene.lappet.events):
        row = self.layout.row(align=True)
        row.prop(scene.lappet, "show_strips", text="", icon="NLA")
        row.menu(LAPPET_MT_strips.__name__)


CLASSES = (LAPPET_MT_strips,)


def register() -> None:
    """Add the keys and hang the menu into the header."""
    bpy.types.DOPESHEET_HT_header.append(_draw_menu)
    manager = bpy.context.window_manager
    configuration = manager.keyconfigs.addon if manager is not None else None
    if configuration is None or _made:
        return  # without windows there are no keys
    keymap = configuration.keymaps.new(name=_KEYMAP, space_type=_SPACE)
    for operator, key, value, modifiers, properties in reversed(KEYS):  # the last that is added comes first
        item = keymap.keymap_items.new(operator, key, value, **modifiers)
        for name, given in properties.items():
            setattr(item.properties, name, given)
        _made.append((keymap, item))


def unregister() -> None:
    """Take the keys and the menu away."""
    for keymap, item in _made:
        keymap.keymap_items.remove(item)
    _made.clear()
    bpy.types.DOPESHEET_HT_header.remove(_draw_menu)
