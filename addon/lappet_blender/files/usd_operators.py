"""Operators, menu entries and the drop of files that import and export procedures and skin caches."""

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from lappet.foreign.limits import DEFAULT_LIMITS, GIB, ReadLimits

from ..interface.operator_base import NO_UNDO, OperatorBase
from ..interface.problem_sentence import problem_sentence
from ..interface.sidebar_panel import CLOSED, SidebarPanel
from .export_usd import write_cache, write_scene
from .import_usd import look_into, read_into

_GLOB = "*.usda;*.usdc;*.usd"


def _path(operator: Any) -> Path:
    return Path(bpy.path.abspath(operator.filepath))


class LAPPET_OT_export_procedure(OperatorBase, bpy.types.Operator, ExportHelper):
    """Write the procedure to a USD file, for `lappet solve` and other programs"""

    bl_label = "Export Lappet Procedure"
    bl_options = NO_UNDO

    filename_ext = ".usda"
    check_extension = None
    filter_glob: StringProperty(default=_GLOB, options={"HIDDEN"})

    def run(self, context: bpy.types.Context) -> str:
        write_scene(context.scene, _path(self))
        return f"Wrote {_path(self).name}."


class LAPPET_OT_export_cache(OperatorBase, bpy.types.Operator, ExportHelper):
    """Write the solved frames to a skin cache, a USD file layered over the procedure; nothing is solved"""

    bl_label = "Export Lappet Skin Cache"
    bl_options = NO_UNDO

    filename_ext = ".usdc"
    check_extension = None
    filter_glob: StringProperty(default=_GLOB, options={"HIDDEN"})

    def run(self, context: bpy.types.Context) -> str:
        beside = write_cache(context.scene, _path(self))
        return f"Wrote {_path(self).name}, and {beside.name} beside it."


class LAPPET_OT_import_procedure(OperatorBase, bpy.types.Operator, ImportHelper):
    """Read a procedure or a skin cache"""

    bl_label = "Import Lappet Procedure"

    filter_glob: StringProperty(default=_GLOB, options={"HIDDEN"})
    new_scene: BoolProperty(
        name="New Scene",
        description="Import into a new scene; if not given, only if this scene already has a tissue or events",
        default=False,
    )
    allow_external: BoolProperty(
        name="Allow External",
        description="Follow references to files outside the folder of the file. Only for files that you trust",
        default=False,
        options={"SKIP_SAVE"},
    )
    read_memory: FloatProperty(
        name="Memory",
        description="Memory that reading the file may take, in GiB",
        default=DEFAULT_LIMITS.memory / GIB,
        min=0.5,
        options={"SKIP_SAVE"},
    )
    read_seconds: IntProperty(
        name="Seconds",
        description="Seconds of a processor that reading the file may take",
        default=DEFAULT_LIMITS.seconds,
        min=1,
        options={"SKIP_SAVE"},
    )
    read_size: FloatProperty(
        name="Size",
        description="Size that the file, and what is read of it, may have, in GiB",
        default=DEFAULT_LIMITS.size / GIB,
        min=0.001,
        options={"SKIP_SAVE"},
    )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if self.properties.is_property_set("filepath") and self.filepath:  # dropped on the window
            return self.execute(context)
        return set(ImportHelper.invoke(self, context, event))

    def limits(self) -> ReadLimits:
        """What reading the file may take, as the properties say."""
        memory, size = round(self.read_memory * GIB), round(self.read_size * GIB)
        return ReadLimits(memory, self.read_seconds, size, self.allow_external)

    def run(self, context: bpy.types.Context) -> str:
        path, scene = _path(self), context.scene
        taken = scene.lappet.tissue.object is not None or len(scene.lappet.events) > 0
        apart = self.new_scene if self.properties.is_property_set("new_scene") else taken
        # Refuses what is no USD before a scene is made for it.
        found = look_into(path, self.limits())
        target = _fresh_scene(scene, path.stem) if apart else scene
        try:
            notes = read_into(target, found)
        except BaseException:
            if apart:
                bpy.data.scenes.remove(target)
            raise
        if apart and context.window is not None:
            context.window.scene = target
        return " ".join([f"Read {path.name}.", *map(problem_sentence, notes)])


class LAPPET_FH_procedure(bpy.types.FileHandler):
    """Procedures and skin caches that are dropped on a 3D view."""

    bl_label = "Lappet Procedure"
    bl_import_operator = "lappet.import_procedure"
    bl_export_operator = "lappet.export_procedure"
    bl_file_extensions = ".usda;.usdc;.usd"

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type == "VIEW_3D"


def _fresh_scene(like: bpy.types.Scene, name: str) -> bpy.types.Scene:
    """An empty scene with the units of another."""
    fresh = bpy.data.scenes.new(name)
    fresh.unit_settings.system = like.unit_settings.system
    fresh.unit_settings.scale_length = like.unit_settings.scale_length
    fresh.unit_settings.length_unit = like.unit_settings.length_unit
    return fresh


def export_entries(menu: Any, _context: bpy.types.Context) -> None:
    """In File > Export."""
    menu.layout.operator("lappet.export_procedure", text="Lappet Procedure (.usda)")
    menu.layout.operator("lappet.export_cache", text="Lappet Skin Cache (.usdc)")


def import_entries(menu: Any, _context: bpy.types.Context) -> None:
    """In File > Import."""
    menu.layout.operator("lappet.import_procedure", text="Lappet Procedure or Skin Cache (.usda, .usdc)")


class LAPPET_PT_files(SidebarPanel, bpy.types.Panel):
    """Import and export."""

    bl_label = "Files"
    bl_order = 60
    bl_options = CLOSED

    def draw(self, _context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("lappet.import_procedure", text="Import Procedure", icon="IMPORT")
        column.operator("lappet.export_procedure", text="Export Procedure", icon="EXPORT")
        column.operator("lappet.export_cache", text="Export Skin Cache", icon="EXPORT")


CLASSES = (
    LAPPET_OT_export_procedure,
    LAPPET_OT_export_cache,
    LAPPET_OT_import_procedure,
    LAPPET_FH_procedure,
    LAPPET_PT_files,
)
