"""Presets of one's own for skin, thread, plate and look, by Blender's preset system: files in the user's scripts."""

from __future__ import annotations

from typing import Any, ClassVar

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ..interface.operator_base import NO_UNDO

_DATA = "data = bpy.context.scene.lappet"
_SKIN = (
    *("model", "youngs_modulus", "poissons_ratio", "mooney_ratio", "fiber_k1", "fiber_k2", "fiber_dispersion"),
    *("fiber_slack", "fiber_angle", "fiber_direction", "prestretch", "density", "muscle_stress", "activation"),
)
_THREAD = ("mode", "thread", "stiffness", "length", "drawn", "tension", "pull_through")
_PLATE = (
    *("style", "tone", "width", "columns", "language", "view", "quantity", "labels", "letters", "arrows", "measures"),
    *("instruments", "text", "journal", "marks", "marks_spacing", "skin_lines"),
)
_LOOK = (
    *("color", "show_solved", "show_walls", "show_bone", "show_sutures", "show_hooks", "show_landmarks"),
    *("show_vessels", "show_through", "show_legend", "show_plan"),
)


class _Panel(PresetPanel):
    """A list of presets, opened from the header of a panel."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    preset_operator = "script.execute_preset"


class LAPPET_PT_skin_presets(_Panel, bpy.types.Panel):
    """Presets of the chosen material."""

    bl_label = "Skin Presets"
    preset_subdir = "lappet/skin"
    preset_add_operator = "lappet.skin_preset_add"


class LAPPET_PT_thread_presets(_Panel, bpy.types.Panel):
    """Presets of the active suture's thread."""

    bl_label = "Thread Presets"
    preset_subdir = "lappet/thread"
    preset_add_operator = "lappet.thread_preset_add"


class LAPPET_PT_plate_presets(_Panel, bpy.types.Panel):
    """Presets of the chosen plate."""

    bl_label = "Plate Presets"
    preset_subdir = "lappet/plate"
    preset_add_operator = "lappet.plate_preset_add"


class LAPPET_PT_look_presets(_Panel, bpy.types.Panel):
    """Presets of the look."""

    bl_label = "Look Presets"
    preset_subdir = "lappet/look"
    preset_add_operator = "lappet.look_preset_add"


def _values(name: str, fields: tuple[str, ...]) -> list[str]:
    return [f"{name}.{field}" for field in fields]


class _Add(AddPresetBase):
    """Keep or remove a preset: what is set now, under a name."""

    bl_options = NO_UNDO  # a file is not undone


class LAPPET_OT_skin_preset_add(_Add, bpy.types.Operator):
    """Keep the values of the chosen material as a preset, or remove one"""

    bl_idname = "lappet.skin_preset_add"
    bl_label = "Add Skin Preset"
    preset_menu = "LAPPET_PT_skin_presets"
    preset_subdir = "lappet/skin"
    preset_defines: ClassVar[list[str]] = [_DATA, "material = data.materials[data.active_material]"]
    preset_values: ClassVar[list[str]] = _values("material", _SKIN)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A material is chosen."""
        data = context.scene.lappet
        return 0 <= data.active_material < len(data.materials)


class LAPPET_OT_thread_preset_add(_Add, bpy.types.Operator):
    """Keep how the active suture is held as a preset, or remove one"""

    bl_idname = "lappet.thread_preset_add"
    bl_label = "Add Thread Preset"
    preset_menu = "LAPPET_PT_thread_presets"
    preset_subdir = "lappet/thread"
    preset_defines: ClassVar[list[str]] = [_DATA, "event = data.events[data.active_event]"]
    preset_values: ClassVar[list[str]] = _values("event", _THREAD)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """An event is active."""
        data = context.scene.lappet
        return 0 <= data.active_event < len(data.events)


class LAPPET_OT_plate_preset_add(_Add, bpy.types.Operator):
    """Keep the settings of the chosen plate's page as a preset, or remove one"""

    bl_idname = "lappet.plate_preset_add"
    bl_label = "Add Plate Preset"
    preset_menu = "LAPPET_PT_plate_presets"
    preset_subdir = "lappet/plate"
    preset_defines: ClassVar[list[str]] = [_DATA, "page = data.pages[data.active_page]"]
    preset_values: ClassVar[list[str]] = _values("page", _PLATE)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """A plate is chosen."""
        data = context.scene.lappet
        return 0 <= data.active_page < len(data.pages)


class LAPPET_OT_look_preset_add(_Add, bpy.types.Operator):
    """Keep the colors and the visible parts as a preset, or remove one"""

    bl_idname = "lappet.look_preset_add"
    bl_label = "Add Look Preset"
    preset_menu = "LAPPET_PT_look_presets"
    preset_subdir = "lappet/look"
    preset_defines: ClassVar[list[str]] = [_DATA, "look = data.look"]
    preset_values: ClassVar[list[str]] = _values("look", _LOOK)


CLASSES: tuple[Any, ...] = (
    LAPPET_OT_skin_preset_add,
    LAPPET_OT_thread_preset_add,
    LAPPET_OT_plate_preset_add,
    LAPPET_OT_look_preset_add,
    LAPPET_PT_skin_presets,
    LAPPET_PT_thread_presets,
    LAPPET_PT_plate_presets,
    LAPPET_PT_look_presets,
)
_LABELS = {each: each.bl_label for each in CLASSES if issubclass(each, bpy.types.Panel)}


def unregister() -> None:
    """Name the lists as they were: Blender names a list after the preset that was chosen last, for good."""
    for each, label in _LABELS.items():
        each.bl_label = label
