"""What all tools that run while the mouse moves have in common: events in, hints out, and a clean end.

A tool fills its operator's properties and ends by `execute`, so that it is one step of undo, can be adjusted in the
panel of the last operation and runs from Python with arguments.
"""

from __future__ import annotations

from typing import ClassVar

import bpy

from lappet.core.problem import problem, refused
from lappet.core.problem_code import ProblemCode

from ..interface.header_texts import clear_texts
from ..interface.operator_base import OperatorBase
from .preview import clear_preview, redraw
from .shown_surface import shown_object
from .view_under_mouse import View, view_under

Result = set[str]
Hint = tuple[str, str]  # an icon of Blender and a word or two
RUNNING: Result = {"RUNNING_MODAL"}
_NAVIGATION = ("MIDDLEMOUSE", "WHEEL", "TRACKPAD", "MOUSEROTATE", "MOUSESMARTZOOM", "NDOF", "NUMPAD_", "BUTTON")
running: list[SkinModal] = []
_FRAMES = frozenset({"LEFT_ARROW", "RIGHT_ARROW", "UP_ARROW", "DOWN_ARROW", "SPACE", "MEDIA_PLAY", "HOME"})


def check_shown(context: bpy.types.Context) -> None:
    """Raise RefusedError where a tool has no skin to work on."""
    tissue = check_tissue(context)
    if shown_object(context.scene, context.space_data if context.area else None) is None:
        raise refused(ProblemCode.TISSUE_HIDDEN, tissue.name)


def check_tissue(context: bpy.types.Context) -> bpy.types.Object:
    """Return the scene's tissue. Raises RefusedError where there is none."""
    tissue = context.scene.lappet.tissue.object
    if tissue is None:
        raise refused(ProblemCode.TISSUE_NONE)
    return tissue


class SkinModal(OperatorBase):
    """Mixed into an operator; the operator answers `pressed`, `moved`, `released` and, if it likes, `key`.

    They return None to go on, or what the operator returns to Blender to end.
    """

    hints: ClassVar[tuple[Hint, ...]] = ()
    title: ClassVar[str] = ""
    shift = False
    ctrl = False

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and context.mode == "OBJECT"

    def begin(self, context: bpy.types.Context) -> None:
        """Make the tool's state."""

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        """The left button went down in a view."""
        return None

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        """The mouse moved; view: None off every view."""
        return None

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        """The left button went up."""
        return None

    def double_clicked(self, context: bpy.types.Context, view: View) -> Result | None:
        """The second press of a double click."""
        return self.pressed(context, view)

    def confirmed(self, context: bpy.types.Context) -> Result | None:
        """Return or the right button."""
        return {"CANCELLED"}

    def key(self, context: bpy.types.Context, key: str) -> Result | None:
        """Another key went down."""
        return None

    def text(self, context: bpy.types.Context) -> str:
        """What the header says."""
        return self.title

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> Result:
        if context.area is None or context.area.type != "VIEW_3D":
            return self.refuse(problem(ProblemCode.TOOL_NOT_IN_VIEWPORT, "", self.title))
        if not self.attempt(lambda: check_shown(context)):
            return {"CANCELLED"}
        self._scene = context.scene.name
        self.begin(context)
        view = view_under(context, (event.mouse_x, event.mouse_y))
        self._note_keys(event)
        if event.type == "LEFTMOUSE" and event.value in ("PRESS", "CLICK_DRAG") and view is not None:
            ended = self.pressed(context, view)
        else:
            ended = self.moved(context, view)
        if ended is not None:
            clear_preview()
            return ended
        context.window_manager.modal_handler_add(self)
        running.append(self)
        hints = self.hints
        context.workspace.status_text_set(lambda bar, _context: _draw_hints(bar.layout, hints))
        self._say(context)
        return RUNNING

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> Result:
        if context.area is None or context.scene is None or context.scene.name != self._scene:
            return self._end(context, {"CANCELLED"})
        try:
            ended = self._handle(context, event)
        except ReferenceError:  # an object was deleted meanwhile
            ended = self.refuse(problem(ProblemCode.TOOL_GROUND_GONE, "", self.title))
        if ended is None:
            self._say(context)
            return RUNNING
        if ended & {"FINISHED", "CANCELLED"}:
            return self._end(context, ended)
        return ended

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the tool: another file is opened, the window is closed."""
        self._end(context, {"CANCELLED"})

    def abandoned(self, context: bpy.types.Context) -> None:
        """The tool ends without having done anything: takes back what it changed while it ran."""

    def _handle(self, context: bpy.types.Context, event: bpy.types.Event) -> Result | None:
        kind, value = event.type, event.value
        if (kind.startswith(_NAVIGATION) and kind != "NUMPAD_ENTER") or kind in _FRAMES:
            redraw()
            return {"PASS_THROUGH"}
        if kind.startswith("TIMER") or kind in ("WINDOW_DEACTIVATE", "NONE"):
            return {"PASS_THROUGH"}
        self._note_keys(event)
        view = view_under(context, (event.mouse_x, event.mouse_y))
        if kind in ("MOUSEMOVE", "INBETWEEN_MOUSEMOVE"):
            return self.moved(context, view)
        if kind == "LEFTMOUSE":
            if value == "RELEASE":
                return self.released(context, view)
            if view is None or event.alt:  # a panel, the timeline; Alt turns the view with two buttons
                return {"PASS_THROUGH"}
            if value == "DOUBLE_CLICK":
                return self.double_clicked(context, view)
            return self.pressed(context, view) if value == "PRESS" else None
        if kind == "RIGHTMOUSE" and view is None:
            return {"PASS_THROUGH"}
        if value != "PRESS":
            return self.moved(context, view) if kind.endswith(("SHIFT", "CTRL")) else None
        if kind == "ESC":
            return {"CANCELLED"}
        if kind in ("RET", "NUMPAD_ENTER", "RIGHTMOUSE"):
            return self.confirmed(context)
        if kind == "Z" and (event.ctrl or event.oskey):
            kind = "BACK_SPACE"
        ended = self.key(context, kind)
        return ended if ended is not None else self.moved(context, view)

    def _note_keys(self, event: bpy.types.Event) -> None:
        self.shift, self.ctrl = bool(event.shift), bool(event.ctrl or event.oskey)

    def _say(self, context: bpy.types.Context) -> None:
        if context.area is not None:
            context.area.header_text_set(self.text(context))

    def _end(self, context: bpy.types.Context, result: Result) -> Result:
        if self in running:
            running.remove(self)
        if "FINISHED" not in result:
            self.abandoned(context)
        clear_preview()
        if context.area is not None:
            context.area.header_text_set(None)
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        return result


def end_running() -> None:
    """End every tool that runs, before its class goes: Blender frees it without a word to it."""
    while running:
        running.pop().abandoned(bpy.context)
    clear_preview()
    clear_texts()


def _draw_hints(layout: bpy.types.UILayout, hints: tuple[Hint, ...]) -> None:
    for icon, words in hints:
        layout.label(text=words, icon=icon)
        layout.separator(factor=2.0)
