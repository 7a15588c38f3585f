"""Operators of the display: presets of the look, variants and their comparison, the stage of a figure."""

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.framing import VIEWS

from ..events.variant import copy_scene
from ..interface.operator_base import NO_UNDO, OperatorBase
from ..interface.problem_sentence import problem_sentence
from . import skin_display
from .figure_setup import clear_stage, set_stage
from .render_still import render_still

PRESETS = {
    "OPERATION": {"color": "PLAIN", "show_plan": True, "show_hooks": True, "show_landmarks": False},
    "MOVEMENT": {"color": "GRID", "show_plan": True, "show_hooks": True, "show_landmarks": True},
    "STRAIN": {"color": "STRAIN", "show_plan": False, "show_hooks": False, "show_landmarks": False},
    "TENSION": {"color": "TENSION", "show_plan": False, "show_hooks": False, "show_landmarks": False},
}
_PRESET_ITEMS = (
    ("OPERATION", "Operation", "Plain skin with thread, steel and pen marks"),
    ("MOVEMENT", "Movement", "The printed grid and the landmarks"),
    ("STRAIN", "Strain map", "How far the skin is stretched, with its scale"),
    ("TENSION", "Tension map", "Tension along the skin, with its scale"),
)


class LAPPET_OT_look_preset(OperatorBase, bpy.types.Operator):
    """Set the colors and the visible parts of the display for a purpose"""

    bl_label = "Look Preset"

    preset: EnumProperty(name="Preset", items=_PRESET_ITEMS)

    def run(self, context: bpy.types.Context) -> None:
        look = context.scene.lappet.look
        for name, value in {"show_walls": True, "show_sutures": True, **PRESETS[self.preset]}.items():
            setattr(look, name, value)


class LAPPET_OT_compare(OperatorBase, bpy.types.Operator):
    """Show the skin of another scene beside this one, frame by frame"""

    bl_label = "Compare"

    scene: StringProperty(
        name="Scene", description="Name of the other scene; empty = no comparison", options={"SKIP_SAVE"}
    )

    def run(self, context: bpy.types.Context) -> None:
        here = context.scene
        other = bpy.data.scenes.get(self.scene) if self.scene else None
        if self.scene and other is None:
            names = ", ".join(s.name for s in bpy.data.scenes if s != here) or "there is no other"
            raise refused(ProblemCode.COMPARE_UNKNOWN, "", self.scene, known=names)
        if other == here:
            raise refused(ProblemCode.COMPARE_ITSELF, here.name)
        here.lappet.compare_with = other
        skin_display.refresh(here)


class LAPPET_OT_variant_new(OperatorBase, bpy.types.Operator):
    """Copy this scene with its procedure, switch to the copy and show this scene beside it"""

    bl_label = "New Variant"

    name: StringProperty(name="Name", description="Name of the new scene; empty = from this one", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There is a tissue whose procedure can be varied."""
        return context.scene is not None and context.scene.lappet.tissue.object is not None

    def run(self, context: bpy.types.Context) -> None:
        here = context.scene
        made = copy_scene(here, self.name or f"{here.name} variant")
        made.lappet.compare_with = here
        if context.window is not None:
            context.window.scene = made
        skin_display.refresh(made)


class LAPPET_OT_set_stage(OperatorBase, bpy.types.Operator):
    """Set up camera, lights, paper and render settings for a textbook picture"""

    bl_label = "Add Camera and Lights"

    view: EnumProperty(
        name="View",
        items=[(v.upper(), v.capitalize(), f"From {angle:g}° above the skin") for v, angle in VIEWS.items()],
    )
    engine: EnumProperty(
        name="Engine",
        items=(
            ("CYCLES", "Cycles", "For the final picture"),
            ("WORKBENCH", "Workbench", "For a draft"),
            ("KEEP", "As it is", "Leave the render settings alone"),
        ),
    )
    width: IntProperty(name="Width", description="Pixels; 0 = the scene's", default=0, min=0, max=16384)
    height: IntProperty(name="Height", description="Pixels; 0 = the scene's", default=0, min=0, max=16384)
    samples: IntProperty(name="Samples", description="Cycles samples per pixel", default=32, min=1, max=4096)

    def run(self, context: bpy.types.Context) -> None:
        size = (self.width, self.height) if self.width and self.height else (0, 0)
        set_stage(context.scene, self.view.lower(), self.engine.lower(), size, self.samples)


class LAPPET_OT_clear_stage(OperatorBase, bpy.types.Operator):
    """Remove the camera, lights and paper that were added for a picture"""

    bl_label = "Remove Camera and Lights"

    def run(self, context: bpy.types.Context) -> None:
        if not clear_stage(context.scene):
            raise refused(ProblemCode.FIGURE_NOT_SET, context.scene.name)


class LAPPET_OT_render_still(OperatorBase, bpy.types.Operator):
    """Render the current frame to a PNG file"""

    bl_label = "Render Still"
    bl_options = NO_UNDO

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def run(self, context: bpy.types.Context) -> None:
        found = render_still(context.scene, self.filepath)
        if found is not None:
            self.report({"WARNING"}, problem_sentence(found))


CLASSES = (
    LAPPET_OT_look_preset,
    LAPPET_OT_compare,
    LAPPET_OT_variant_new,
    LAPPET_OT_set_stage,
    LAPPET_OT_clear_stage,
    LAPPET_OT_render_still,
)
