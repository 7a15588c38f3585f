"""The menu Lappet in the 3D viewport's header: every tool without the toolbar, and what acts on the active event."""

import bpy

_TOOLS = (
    ("lappet.draw_incision", "SCULPTMODE_HLT"),
    ("lappet.click_excision", "TRASH"),
    ("lappet.draw_undermining", "MOD_EXPLODE"),
    ("lappet.draw_thinning", "MOD_THICKNESS"),
    ("lappet.place_hook", "HOOK"),
    ("lappet.place_retractor", "VIEW_PAN"),
    ("lappet.place_suture", "LINKED"),
    ("lappet.place_landmark", "EMPTY_AXIS"),
)
_ACTS = ("event_jump", "event_duplicate", "event_remove")
_SOLVING = ("plan_now", "solve", "solve_cancel")


class VIEW3D_MT_lappet(bpy.types.Menu):
    bl_label = "Lappet"

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_DEFAULT"
        for name, icon in _TOOLS:
            layout.operator(name, icon=icon)
        layout.separator()
        for name in _ACTS:
            layout.operator(f"lappet.{name}")
        layout.separator()
        for name in _SOLVING:
            layout.operator(f"lappet.{name}")


def _draw_menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    if context.mode == "OBJECT":
        self.layout.menu(VIEW3D_MT_lappet.__name__)


CLASSES = (VIEW3D_MT_lappet,)


def register() -> None:
    """Hang the menu into the header."""
    bpy.types.VIEW3D_MT_editor_menus.append(_draw_menu)


def unregister() -> None:
    """Take it away."""
    bpy.types.VIEW3D_MT_editor_menus.remove(_draw_menu)
