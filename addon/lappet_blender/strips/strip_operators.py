"""Acts on strips: select, mute, remove, go to, and markers that name the steps."""

from collections.abc import Sequence
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.plate_words import LANGUAGES, plate_words

from ..events.edit_events import jump_to_event
from ..interface.operator_base import NO_UNDO, OperatorBase
from ..model.changes import changed
from ..model.event_list import find_event, remove_event
from .area_edge import raise_edge
from .scene_strips import chosen_strips, scene_steps, scene_strips, select_strips
from .step_names import proposed_steps
from .strip import strips_of_step
from .strip_view import redraw_strips, strip_at

_LANGUAGES = (
    ("AUTO", "Blender's", "That of Blender's interface, else English"),
    *((code, code, f"The catalogue of {code}") for code in LANGUAGES),
)


class _OnStrips(OperatorBase):
    """An operator on chosen strips. From a key: on what is under the mouse, or on the selected ones if that is."""

    events: StringProperty(
        name="Events",
        description="Names or identifiers; if not given, the selected strips",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and len(context.scene.lappet.events) > 0

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in ("LEFTMOUSE", "RET", "NUMPAD_ENTER", "NONE"):  # a menu or a button
            return self.execute(context)
        uid = strip_at(context, event)
        if not uid:
            return {"PASS_THROUGH"}
        selected = [strip.uid for strip in scene_strips(context.scene) if strip.selected]
        self.events = " ".join(selected if uid in selected else [uid])
        return self.execute(context)


class LAPPET_OT_strips_mute(_OnStrips, bpy.types.Operator):
    """Turn the events of strips off, or on again if all of them are off"""

    bl_label = "Mute Strips"

    def run(self, context: bpy.types.Context) -> None:
        strips = chosen_strips(context.scene, self.events)
        on = not any(strip.enabled for strip in strips)
        for strip in strips:
            event: Any = find_event(context.scene, strip.uid)
            event.enabled = on
        redraw_strips()


class LAPPET_OT_strips_remove(_OnStrips, bpy.types.Operator):
    """Remove the events of strips, with the empties that were made for them"""

    bl_label = "Remove Strips"

    def run(self, context: bpy.types.Context) -> None:
        for strip in chosen_strips(context.scene, self.events):
            remove_event(context.scene, find_event(context.scene, strip.uid))
        redraw_strips()


class LAPPET_OT_strips_select(OperatorBase, bpy.types.Operator):
    """Select strips: all, none, those of a step, those of one kind with the active one"""

    bl_label = "Select Strips"

    which: EnumProperty(
        name="Which",
        items=(
            ("ALL", "All", "Every strip"),
            ("NONE", "None", "No strip"),
            ("STEP", "Step", "Those that begin in the step of a frame"),
            ("KIND", "Same Kind", "Those of the active event's kind"),
        ),
        default="ALL",
    )
    frame: IntProperty(
        name="Frame", description="A frame of the step; if not given, the current one", options={"SKIP_SAVE"}
    )

    def run(self, context: bpy.types.Context) -> str:
        scene = context.scene
        strips = scene_strips(scene)
        wanted = [strip.uid for strip in strips] if self.which == "ALL" else []
        if self.which == "STEP":
            frame = self.frame if self.properties.is_property_set("frame") else scene.frame_current
            step = next((each for each in scene_steps(scene) if each.start <= frame < each.end), None)
            if step is None:
                raise refused(ProblemCode.STEP_UNKNOWN, "", frame)
            wanted = strips_of_step(step, strips)
        elif self.which == "KIND":
            kinds = {strip.kind for strip in chosen_strips(scene) if strip.active}
            wanted = [strip.uid for strip in strips if strip.kind in kinds]
        active = next((strip.uid for strip in strips if strip.active and strip.uid in wanted), None)
        select_strips(scene, sorted(wanted, key=lambda uid: uid != active))
        redraw_strips()
        return f"{len(wanted)} of {len(strips)} strips are selected."


class LAPPET_OT_strip_jump(_OnStrips, bpy.types.Operator):
    """Go to the frame at which the event of a strip begins"""

    bl_label = "Jump to Strip"
    bl_options = NO_UNDO  # Blender's undo holds no frames

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        uid = strip_at(context, event)
        if not uid:
            return {"PASS_THROUGH"}
        self.events = uid
        return self.execute(context)

    def run(self, context: bpy.types.Context) -> None:
        jump_to_event(context.scene, find_event(context.scene, chosen_strips(context.scene, self.events)[0].uid))


class LAPPET_OT_steps_mark(OperatorBase, bpy.types.Operator):
    """Name the steps of the operation by markers: planned, cut, raised, sutured, result. Markers of your own stay"""

    bl_label = "Mark Steps"

    language: EnumProperty(name="Language", items=_LANGUAGES, default="AUTO")
    replace: BoolProperty(
        name="Replace", description="Remove markers first that have the name of a step in any language", default=True
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and len(context.scene.lappet.events) > 0

    def run(self, context: bpy.types.Context) -> str:
        scene = context.scene
        steps = proposed_steps(scene_strips(scene), scene.frame_start, scene.frame_end)
        if not steps:
            raise refused(ProblemCode.STEP_NO_EVENTS)
        set_markers(scene, steps, self.language, self.replace)
        redraw_strips()
        return f"{len(steps)} steps."


class LAPPET_OT_strips_room(OperatorBase, bpy.types.Operator):
    """Make this Timeline tall enough for the strips: its upper edge moves up"""

    bl_label = "Make Room for Strips"
    bl_options = NO_UNDO

    height: IntProperty(name="Height", description="Of the area, in pixels at a scale of 1", default=230, min=60)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type == "DOPESHEET_EDITOR"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._mouse = event.mouse_x, event.mouse_y
        return self.execute(context)

    def run(self, context: bpy.types.Context) -> None:
        area = context.area
        wanted = round(self.height * (context.preferences.system.ui_scale or 1.0))
        delta = min(wanted, round(0.5 * context.window.height)) - area.height
        if delta > 0:
            raise_edge(context.window, area, delta, getattr(self, "_mouse", None))


def set_markers(
    scene: bpy.types.Scene, steps: Sequence[tuple[str, int]], language: str = "AUTO", replace: bool = True
) -> None:
    """Set a marker on the frame of each step that has none. replace: those named as steps are removed first."""
    markers = scene.timeline_markers
    if replace:
        known = {plate_words(code)(key) for code in LANGUAGES for key in plate_words(code).texts if _is_step(key)}
        for marker in [each for each in markers if each.name in known]:
            markers.remove(marker)
    say = plate_words(language if language != "AUTO" else interface_language())
    taken = {marker.frame for marker in markers}
    for key, frame in steps:
        if frame not in taken:
            markers.new(say(key), frame=frame)
    changed(scene)


def interface_language() -> str:
    """The language of Blender's interface where the catalogue has it, else English."""
    code = (bpy.app.translations.locale or "en")[:2]
    return code if code in LANGUAGES else "en"


def _is_step(key: str) -> bool:
    return key.startswith("step.") and key != "step.frame"


CLASSES = (
    LAPPET_OT_strips_mute,
    LAPPET_OT_strips_remove,
    LAPPET_OT_strips_select,
    LAPPET_OT_strip_jump,
    LAPPET_OT_steps_mark,
    LAPPET_OT_strips_room,
)
