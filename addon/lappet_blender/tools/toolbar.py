"""The tools of the toolbar: what they are called, which key starts which operator, and their settings in the header."""

from typing import Any, ClassVar

import bpy

from .icon_shapes import icon_path
from .incision_tool import draw_incision_settings

_PRESS = {"type": "LEFTMOUSE", "value": "PRESS"}
_OWN_TOOL, _OWN_KEYMAP = "builtin.select_box", "3D View Tool: Select Box"  # Blender's
TEXTS_OF_SETUP = ("gizmo_group", "data_block", "operator", "idname_fallback", "keymap_fallback")
# When a modal operator ends with the release, Blender still tells of a click, which would select the skin's object.
_CLICK = ("lappet.ignore_click", {"type": "LEFTMOUSE", "value": "CLICK", "any": True}, None)


class LAPPET_OT_ignore_click(bpy.types.Operator):
    """Do nothing: a tool has handled the press and the release"""

    bl_idname = "lappet.ignore_click"
    bl_label = "Ignore Click"
    bl_options: ClassVar[set[str]] = {"INTERNAL"}

    def execute(self, _context: bpy.types.Context) -> set[str]:
        return {"FINISHED"}


CLASSES = (LAPPET_OT_ignore_click,)


class _Tool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_cursor = "CROSSHAIR"
    bl_widget = None


def _on_press(operator: str) -> tuple[Any, ...]:
    """Press, also with the modifiers that the tools read while they run."""
    return (*((operator, {**_PRESS, **keys}, None) for keys in ({}, {"shift": True}, {"ctrl": True})), _CLICK)


def _settings(operator: str, *names: str) -> Any:
    """A tool's part of the header: some properties of its operator, a choice among a few spread out."""

    def draw(_context: bpy.types.Context, layout: bpy.types.UILayout, tool: Any) -> None:
        settings = tool.operator_properties(operator)
        for name in names:
            layout.prop(settings, name, expand=name == "line")

    return staticmethod(draw)


class EditTool(_Tool):
    bl_idname = "lappet.edit"
    bl_label = "Select and Edit"
    bl_description = (
        "Select an event by its points or line and drag its points along the skin.\n"
        "Ctrl-click on a line inserts a point, X removes one, G moves the last one clicked,\n"
        "a double click goes to the event's frame"
    )
    bl_icon = icon_path("edit")
    bl_cursor = "DEFAULT"
    # No two of these answer the same event: Blender does not keep their order.
    bl_keymap = (
        ("lappet.edit_jump", {"type": "LEFTMOUSE", "value": "DOUBLE_CLICK"}, None),
        ("lappet.edit_plan", {**_PRESS, "ctrl": True}, {"properties": [("insert", True)]}),
        ("lappet.edit_plan", _PRESS, None),
        ("lappet.edit_plan", {**_PRESS, "shift": True}, {"properties": [("extend", True)]}),
        ("lappet.edit_plan", {"type": "G", "value": "PRESS"}, {"properties": [("grab", True)]}),
        ("lappet.edit_delete", {"type": "X", "value": "PRESS"}, None),
        ("lappet.edit_delete", {"type": "DEL", "value": "PRESS"}, None),
        _CLICK,
    )

    @staticmethod
    def draw_settings(context: bpy.types.Context, layout: bpy.types.UILayout, _tool: Any) -> None:
        procedure = context.scene.lappet
        if 0 <= procedure.active_event < len(procedure.events):
            event = procedure.events[procedure.active_event]
            layout.label(text=event.name)
            layout.prop(event, "moment")
            if event.kind in ("HOOK", "RETRACTOR"):
                layout.prop(event, "end")
        layout.prop(procedure.look, "show_plan", text="Plan")


class IncisionTool(_Tool):
    bl_idname = "lappet.cutting.incision"
    bl_label = "Incision"
    bl_description = (
        "Click points on the skin, or draw with the button held.\n"
        "Return or the right button finishes, C closes the line"
    )
    bl_icon = icon_path("incision")
    bl_cursor = "KNIFE"
    bl_keymap = _on_press("lappet.draw_incision")

    @staticmethod
    def draw_settings(_context: bpy.types.Context, layout: bpy.types.UILayout, tool: Any) -> None:
        settings = tool.operator_properties("lappet.draw_incision")
        layout.prop(settings, "line", expand=True)
        draw_incision_settings(layout, settings)
        layout.prop(settings, "tolerance")


class ExciseTool(_Tool):
    bl_idname = "lappet.excise"
    bl_label = "Excise"
    bl_description = "Click a piece that incisions have cut out to remove it"
    bl_icon = icon_path("excise")
    bl_keymap = _on_press("lappet.click_excision")


class UndermineTool(_Tool):
    bl_idname = "lappet.cutting.undermining"
    bl_label = "Undermine"
    bl_description = "Draw around an area to free its skin from the bed"
    bl_icon = icon_path("undermine")
    bl_cursor = "KNIFE"
    bl_keymap = _on_press("lappet.draw_undermining")
    draw_settings = _settings("lappet.draw_undermining", "line", "tolerance")


class ThinTool(_Tool):
    bl_idname = "lappet.cutting.thinning"
    bl_label = "Thin"
    bl_description = "Draw around an area to take its deep tissue away, as a flap is thinned"
    bl_icon = icon_path("thin")
    bl_cursor = "KNIFE"
    bl_keymap = _on_press("lappet.draw_thinning")
    draw_settings = _settings("lappet.draw_thinning", "line", "thickness", "tolerance")


class HookTool(_Tool):
    bl_idname = "lappet.hook"
    bl_label = "Hook"
    bl_description = (
        "Press on the skin and drag to where it should be pulled.\nHold Shift to pull along the skin's normal"
    )
    bl_icon = icon_path("hook")
    bl_keymap = _on_press("lappet.place_hook")
    draw_settings = _settings("lappet.place_hook", "frames", "stiffness")


class RetractorTool(_Tool):
    bl_idname = "lappet.retractor"
    bl_label = "Retractor"
    bl_description = "Press on the skin and drag to grip the faces around the mouse,\nor the group chosen in the header"
    bl_icon = icon_path("retractor")
    bl_keymap = _on_press("lappet.place_retractor")

    @staticmethod
    def draw_settings(_context: bpy.types.Context, layout: bpy.types.UILayout, tool: Any) -> None:
        settings = tool.operator_properties("lappet.place_retractor")
        layout.prop(settings, "grip")
        if not settings.grip:
            layout.prop(settings, "radius")
        layout.prop(settings, "frames")


class SutureTool(_Tool):
    bl_idname = "lappet.suture"
    bl_label = "Suture"
    bl_description = (
        "Click one edge of the wound, then the other.\nA run: click along one edge, Return, then along the other"
    )
    bl_icon = icon_path("suture")
    bl_keymap = _on_press("lappet.place_suture")

    @staticmethod
    def draw_settings(_context: bpy.types.Context, layout: bpy.types.UILayout, tool: Any) -> None:
        settings = tool.operator_properties("lappet.place_suture")
        layout.prop(settings, "mode", expand=True)
        if settings.mode != "ONE":
            layout.prop(settings, "count")
            row = layout.row()
            row.enabled = settings.count == 0
            row.prop(settings, "spacing")
        if settings.mode == "INCISION":
            layout.prop(settings, "bite")
        layout.prop(settings, "depth")
        layout.prop(settings, "duration")
        layout.prop(settings, "stiffness")


class LandmarkTool(_Tool):
    bl_idname = "lappet.landmark"
    bl_label = "Landmark"
    bl_description = "Click a point on the skin to follow and measure"
    bl_icon = icon_path("landmark")
    bl_keymap = _on_press("lappet.place_landmark")
    draw_settings = _settings("lappet.place_landmark", "label")


TOOLS = (
    EditTool,
    IncisionTool,
    ExciseTool,
    UndermineTool,
    ThinTool,
    HookTool,
    RetractorTool,
    SutureTool,
    LandmarkTool,
)


def register() -> None:
    """Put the tools at the end of the toolbar."""
    for index, each in enumerate(TOOLS):
        bpy.utils.register_tool(each, separator=index == 0)


def unregister() -> None:
    """Take them out; a workspace that has one of them in hand gets Blender's own."""
    _put_down({each.bl_idname for each in TOOLS})
    for each in reversed(TOOLS):
        bpy.utils.unregister_tool(each)


def _put_down(names: set[str]) -> None:
    """Give every workspace with a tool of these in hand Blender's own to select with.

    Blender takes each text of `setup` that is left out for a null pointer, and crashes: all of them are given.
    """
    for workspace in () if bpy.app.background else bpy.data.workspaces:
        tool = workspace.tools.from_space_view3d_mode("OBJECT", create=False)
        if tool is not None and tool.idname in names:
            texts = dict.fromkeys(TEXTS_OF_SETUP, "")
            tool.setup(idname=_OWN_TOOL, keymap=_OWN_KEYMAP, **texts)
