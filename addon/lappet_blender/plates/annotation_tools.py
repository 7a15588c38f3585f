"""Operators that run while the mouse moves: add an annotation by clicks on the skin, drag its text."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import CollectionProperty, EnumProperty, FloatVectorProperty, StringProperty

from lappet.procedure.plate import ANNOTATION_ANCHORS

from ..model.event_properties import LappetPoint
from ..model.plate_names import active_of
from ..model.plate_properties import KINDS
from ..tools.preview import Preview, redraw, show_preview
from ..tools.skin_modal import Result, SkinModal
from ..tools.view_under_mouse import View
from .panel_view import pixels_per_mm
from .plate_edits import add_annotation, chosen_plate, place_annotation
from .plate_overlay import marks_in


class LAPPET_OT_annotation_add(SkinModal, bpy.types.Operator):
    """Add an annotation: click its points on the skin"""

    bl_label = "Add Annotation"
    title = "Annotation"
    hints = (("MOUSE_LMB", "A point"), ("EVENT_RETURN", "Done"), ("EVENT_ESC", "Cancel"))

    kind: EnumProperty(name="Kind", items=KINDS)
    words: StringProperty(name="Text", description="Empty: a measure says its value, a label its name")
    points: CollectionProperty(type=LappetPoint, options={"HIDDEN", "SKIP_SAVE"})

    def begin(self, context: bpy.types.Context) -> None:
        self.points.clear()

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        hit = view.pick(context.scene) if view is not None else None
        dots = [tuple(point.co) for point in self.points]
        show_preview(Preview(context.scene.name, dots=[*dots, *([hit.rest] if hit else [])]))
        return None

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        hit = view.pick(context.scene)
        if hit is not None:
            self.points.add().co = hit.rest
            _, most = ANNOTATION_ANCHORS[self.kind]
            if len(self.points) >= (1 if self.kind == "arrow" and self.shift else most):
                return self.execute(context)
        return self.moved(context, view)

    def confirmed(self, context: bpy.types.Context) -> Result | None:
        least, _ = ANNOTATION_ANCHORS[self.kind]
        return self.execute(context) if len(self.points) >= least else {"CANCELLED"}

    def key(self, context: bpy.types.Context, key: str) -> Result | None:
        if key == "BACK_SPACE" and len(self.points):
            self.points.remove(len(self.points) - 1)
        return None

    def text(self, context: bpy.types.Context) -> str:
        least, most = ANNOTATION_ANCHORS[self.kind]
        wanted = f"{most}" if least == most else f"{least} to {most}"
        return f"{self.title} ({self.kind}): {len(self.points)} of {wanted} points"

    def run(self, context: bpy.types.Context) -> None:
        add_annotation(context.scene, self.kind, [tuple(point.co) for point in self.points], self.words)


class LAPPET_OT_annotation_drag(SkinModal, bpy.types.Operator):
    """Drag the text of an annotation to its place"""

    bl_label = "Drag a Label"
    title = "Drag a label"
    hints = (("MOUSE_LMB_DRAG", "Move a text"), ("EVENT_ESC", "Cancel"))

    annotation: StringProperty(name="Annotation", options={"HIDDEN", "SKIP_SAVE"})
    offset: FloatVectorProperty(name="Offset", size=2, options={"HIDDEN", "SKIP_SAVE"})

    def begin(self, context: bpy.types.Context) -> None:
        self.annotation = ""
        self._before: tuple[bool, tuple[float, float]] | None = None

    def pressed(self, context: bpy.types.Context, view: View) -> Result | None:
        marks = marks_in(context.scene, view.space, view.region, view.data)
        held = [] if marks is None else [text for text in marks.texts if text.holds(view.mouse, marks.size)]
        if not held:
            return None
        plate = chosen_plate(context.scene)
        index = plate.annotations.find(held[-1].note)
        note = active_of(plate.annotations, index)
        if note is None:
            return None
        self.annotation, plate.active_annotation = note.name, index
        self._before = (bool(note.placed), tuple(note.offset))
        self._site = held[-1].site
        scale = pixels_per_mm(plate, (view.region.width, view.region.height))
        # Where its offset is now, so that it does not jump: a label's is the end of its leader.
        anchor = np.array(note.offset) * [1.0, -1.0] * scale + self._site if note.placed else None
        self._grip = np.zeros(2) if anchor is None else np.array(view.mouse) - anchor
        self._scale = scale
        return self.moved(context, view)

    def moved(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if view is None or not self.annotation or self._before is None:
            return None
        self.offset = offset_under(np.array(view.mouse) - self._grip, self._site, self._scale)
        note = self._note(context)
        if note is not None:
            note.placed, note.offset = True, self.offset
        redraw()
        return None

    def released(self, context: bpy.types.Context, view: View | None) -> Result | None:
        if not self.annotation:
            return None
        self.moved(context, view)
        return self.execute(context)

    def abandoned(self, context: bpy.types.Context) -> None:
        note = self._note(context)
        if note is not None and self._before is not None:
            note.placed, note.offset = self._before

    def run(self, context: bpy.types.Context) -> None:
        place_annotation(context.scene, self.annotation, self.offset)

    def _note(self, context: bpy.types.Context) -> bpy.types.PropertyGroup | None:
        scene = bpy.data.scenes.get(self._scene)
        pages = () if scene is None else scene.lappet.pages
        plate = None if scene is None else active_of(pages, scene.lappet.active_page)
        return None if plate is None else active_of(plate.annotations, plate.annotations.find(self.annotation))


def offset_under(mouse: np.ndarray, site: np.ndarray, scale: float) -> tuple[float, float]:
    """The offset of a text under the mouse from its anchor (pixels), in mm on paper to the right and down."""
    away = (np.asarray(mouse, np.float64) - site) / scale
    return round(float(away[0]), 1), round(float(-away[1]), 1)


CLASSES = (LAPPET_OT_annotation_add, LAPPET_OT_annotation_drag)
