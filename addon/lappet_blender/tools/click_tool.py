"""The tools Excise and Landmark: one click on the tissue."""

from typing import ClassVar

import bpy
from bpy.props import FloatProperty, FloatVectorProperty, StringProperty

from ..events.add_events import add_excision, add_landmark
from ..events.operator_values import given
from ..interface.said import said
from .fragment import fragment_of
from .preview import Preview, show_preview
from .shown_surface import shown_surface
from .skin_modal import Result, SkinModal, check_tissue
from .view_under_mouse import View

_HINTS = (("MOUSE_LMB", "Release to place"), ("EVENT_ESC", "Cancel"))


class _ClickTool(SkinModal):
    """Held down it shows what would happen at the mouse; released, it happens there."""

    hints = _HINTS
    any_face: ClassVar[bool] = False

    def begin(self, context: bpy.types.Context) -> None:
        self._said = ""
        self._held = False

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        self._held = True
        return self.moved(context, view)

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if not self._held or view is None:
            return None
        hit = view.pick(context.scene, self.any_face)
        if hit is None:
            self._held = False
            self._said = "the mouse is not on the tissue; "
            return None
        self.point = hit.rest
        self.time = context.scene.frame_current
        return self.execute(context)

    def text(self, context: bpy.types.Context) -> str:
        pattern, frame = "{tool} at frame {frame}: {note}click on the skin", context.scene.frame_current
        return said(pattern, tool=said(self.title), frame=frame, note=self._said)


def _point() -> object:
    return FloatVectorProperty(
        name="Point", description="At rest, in mm", size=3, precision=3, options={"HIDDEN", "SKIP_SAVE"}
    )


def _time() -> object:
    return FloatProperty(name="Frame", options={"SKIP_SAVE"})


class LAPPET_OT_click_excision(_ClickTool, bpy.types.Operator):
    """Remove a piece of tissue: click a fragment that incisions have cut out"""

    bl_label = "Excise"
    title = "Excise"
    any_face = True

    point: _point()
    time: _time()

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        hit = view.pick(context.scene, True) if view is not None else None
        surface = shown_surface(context.scene, view.space) if view is not None else None
        preview = Preview(context.scene.name)
        if hit is not None and surface is not None:
            preview.dots = [hit.rest]
            held = fragment_of(surface.rest, hit.triangle) if surface.solved else ()
            if len(held):
                preview.faces = surface.positions[surface.rest.triangles[held]]
        show_preview(preview)
        return None

    def run(self, context: bpy.types.Context) -> None:
        check_tissue(context)
        add_excision(context.scene, self.point, given(self, "time", context.scene.frame_current))


class LAPPET_OT_place_landmark(_ClickTool, bpy.types.Operator):
    """Place a landmark: a point to follow and measure"""

    bl_label = "Place Landmark"
    title = "Landmark"

    point: _point()
    time: _time()
    label: StringProperty(name="Label", description="Name in reports; empty = the next letter")

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        hit = view.pick(context.scene) if view is not None else None
        show_preview(Preview(context.scene.name, dots=[hit.rest] if hit else []))
        return None

    def run(self, context: bpy.types.Context) -> None:
        check_tissue(context)
        add_landmark(context.scene, [self.point], label=self.label or next_label(context.scene))


def next_label(scene: bpy.types.Scene) -> str:
    """The first of A, B ... Z, A1, B1 ... that no landmark of a scene has yet."""
    taken = {event.label for event in scene.lappet.events if event.kind == "LANDMARK"}
    letters = [chr(ord("A") + k) for k in range(26)]
    labels = (f"{letter}{turn or ''}" for turn in range(len(taken) + 1) for letter in letters)
    return next(label for label in labels if label not in taken)


CLASSES = (LAPPET_OT_click_excision, LAPPET_OT_place_landmark)
