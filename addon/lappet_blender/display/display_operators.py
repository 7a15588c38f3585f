"""Operators of the display: presets of the look, variants and their comparison, the stage of a figure."""

from pathlib import Path

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from ..figure.framing import VIEWS
from . import skin_display
from .stage import StageError, clear_stage, set_stage

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


def _refuse(operator: bpy.types.Operator, sentence: str) -> set[str]:
    operator.report({"ERROR"}, sentence)
    return {"CANCELLED"}


class LappetLookPreset(bpy.types.Operator):
    """Set colour and parts of the display for a purpose"""

    bl_idname = "lappet.look_preset"
    bl_label = "Look Preset"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    preset: EnumProperty(name="Preset", items=_PRESET_ITEMS)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Sets the look's properties."""
        look = context.scene.lappet.look
        for name, value in {"show_walls": True, "show_sutures": True, **PRESETS[self.preset]}.items():
            setattr(look, name, value)
        return {"FINISHED"}


class LappetCompare(bpy.types.Operator):
    """Show the skin of another scene beside this one, frame by frame"""

    bl_idname = "lappet.compare"
    bl_label = "Compare"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    scene: StringProperty(name="Scene", description="Its name; empty = no comparison", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Sets `compare_with`."""
        here = context.scene
        other = bpy.data.scenes.get(self.scene) if self.scene else None
        if self.scene and other is None:
            names = ", ".join(s.name for s in bpy.data.scenes if s != here) or "there is no other"
            return _refuse(self, f"There is no scene {self.scene!r} to compare with; choose another scene ({names}).")
        if other == here:
            return _refuse(self, f"{here.name} cannot be compared with itself; choose another scene or make a variant.")
        here.lappet.compare_with = other
        skin_display.refresh(here)
        return {"FINISHED"}


class LappetVariantNew(bpy.types.Operator):
    """Copy this scene with its procedure, go there, and show this one beside it"""

    bl_idname = "lappet.variant_new"
    bl_label = "New Variant"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    name: StringProperty(name="Name", description="Of the new scene; empty = like this one", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There is a tissue whose procedure can be varied."""
        return context.scene is not None and context.scene.lappet.tissue.object is not None

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Copies the scene."""
        from ..events.variant import copy_scene

        here = context.scene
        made = copy_scene(here, self.name or f"{here.name} variant")
        made.lappet.compare_with = here
        if context.window is not None:
            context.window.scene = made
        skin_display.refresh(made)
        return {"FINISHED"}


class LappetSetStage(bpy.types.Operator):
    """Set camera, lights and paper, and the render, for a picture as in a textbook"""

    bl_idname = "lappet.set_stage"
    bl_label = "Set Stage"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

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
    samples: IntProperty(name="Samples", description="Of Cycles, a pixel", default=32, min=1, max=4096)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Makes the stage."""
        size = (self.width, self.height) if self.width and self.height else (0, 0)
        try:
            set_stage(context.scene, self.view.lower(), self.engine.lower(), size, self.samples)
        except StageError as error:
            return _refuse(self, str(error))
        return {"FINISHED"}


class LappetClearStage(bpy.types.Operator):
    """Remove the camera, lights and paper that Set Stage made"""

    bl_idname = "lappet.clear_stage"
    bl_label = "Clear Stage"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Removes the stage."""
        if not clear_stage(context.scene):
            return _refuse(self, f"The scene {context.scene.name} has no stage; Set Stage makes one.")
        return {"FINISHED"}


class LappetRenderStill(bpy.types.Operator):
    """Render the current frame to a PNG file"""

    bl_idname = "lappet.render_still"
    bl_label = "Render Still"
    bl_options = {"REGISTER"}  # noqa: RUF012

    filepath: StringProperty(name="File", subtype="FILE_PATH", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Renders."""
        scene = context.scene
        path = Path(bpy.path.abspath(self.filepath)) if self.filepath else None
        if path is None or path.suffix.lower() != ".png":
            return _refuse(self, f"The picture's name {self.filepath!r} does not end in .png; give a .png file.")
        if scene.camera is None:
            return _refuse(self, f"The scene {scene.name} has no camera; press Set Stage or add one.")
        if not path.parent.is_dir():
            return _refuse(self, f"There is no folder {path.parent}; make it or choose another file.")
        before = scene.render.filepath
        kept = scene.render.image_settings.file_format
        try:
            if hasattr(scene.render.image_settings, "media_type"):
                scene.render.image_settings.media_type = "IMAGE"
            scene.render.image_settings.file_format = "PNG"
            scene.render.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=scene.name)
        except RuntimeError as error:
            return _refuse(self, f"{path} was not written: {str(error).strip()}; see whether the folder is writable.")
        finally:
            scene.render.filepath = before
            scene.render.image_settings.file_format = kept
        if not path.is_file():
            return _refuse(self, f"Blender wrote no picture to {path}; see whether the folder is writable.")
        return {"FINISHED"}


CLASSES = (
    LappetLookPreset,
    LappetCompare,
    LappetVariantNew,
    LappetSetStage,
    LappetClearStage,
    LappetRenderStill,
)
