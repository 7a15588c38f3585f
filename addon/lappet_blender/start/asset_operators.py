"""Operators of the template and of the asset library; what is dropped from it is taken up."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent
from bpy.props import StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..events.flap_assets import DESIGN, suit_unit
from ..interface.operator_base import NO_UNDO, OperatorBase
from ..solving.chosen_daemon import ADDON
from . import asset_home
from .asset_home import assets_folder, put_assets, want_assets
from .asset_library import LIBRARY, TAG, is_registered, register_library, unregister_library
from .taken_assets import stands_for, take_up
from .template_files import NAME, is_written, remove_template, write_template


class LAPPET_OT_template_install(OperatorBase, bpy.types.Operator):
    """Add Lappet to File > New: a patch of skin with a first operation, a camera, a light, and room for the strips"""

    bl_label = "Add to File › New"
    bl_options = NO_UNDO

    def run(self, _context: bpy.types.Context) -> str:
        return f"File › New › {NAME} begins with a patch of skin: {write_template(ADDON)}"


class LAPPET_OT_template_remove(OperatorBase, bpy.types.Operator):
    """Take Lappet out of File > New"""

    bl_label = "Remove from File › New"
    bl_options = NO_UNDO

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return is_written()

    def run(self, _context: bpy.types.Context) -> str:
        remove_template()
        return f"File › New has no {NAME} any more."


class LAPPET_OT_assets_install(OperatorBase, bpy.types.Operator):
    """Write models, flaps, materials, threads, instruments and plates as an asset library, and have Blender show it"""

    bl_label = "Add Asset Library"
    bl_options = NO_UNDO

    directory: StringProperty(
        name="Folder", description="Where the library is written; empty = the extension's folder", subtype="DIR_PATH"
    )

    def run(self, context: bpy.types.Context) -> str:
        folder = Path(self.directory or assets_folder())
        count = put_assets(folder)
        register_library(context.preferences, folder)
        want_assets(context.preferences, True)
        return f"The asset browser shows {count} assets as {LIBRARY}."


class LAPPET_OT_assets_remove(OperatorBase, bpy.types.Operator):
    """Take the asset library out of Blender's preferences, for good; its files stay"""

    bl_label = "Remove Asset Library"
    bl_options = NO_UNDO

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return is_registered(context.preferences)

    def run(self, context: bpy.types.Context) -> None:
        unregister_library(context.preferences)
        want_assets(context.preferences, False)


class LAPPET_OT_asset_take_up(OperatorBase, bpy.types.Operator):
    """Do what the active object, dropped from Lappet's asset library, stands for: add the model, set the hook"""

    bl_label = "Take Up Asset"
    edits_procedure = True

    object: StringProperty(name="Object", description="If not given, the active one", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.scene is not None and context.mode == "OBJECT"

    def run(self, context: bpy.types.Context) -> str:
        obj = context.scene.objects.get(self.object) if self.object else context.object
        if obj is None or stands_for(obj) is None:
            raise refused(ProblemCode.ASSET_UNKNOWN)
        return take_up(context, obj)


@persistent  # type: ignore[untyped-decorator]
def _imported(context: Any, *_: object) -> None:
    """Something was appended: what of it stands for an act is taken up once Blender has placed it."""
    if bpy.app.background:
        return
    brought = [each.id for each in context.import_items if getattr(each, "id", None) is not None]
    plans = [each.name for each in brought if DESIGN in each]
    if plans or any(TAG in each for each in brought):
        bpy.app.timers.register(lambda: _placed(plans), first_interval=0.05)


def _placed(plans: list[str]) -> None:
    """Blender has placed what was dropped. plans: the names of plans of flaps among it."""
    scene = bpy.context.scene
    for obj in (scene.objects.get(name) for name in plans) if scene is not None else ():
        if obj is not None:
            suit_unit(scene, obj)
    take_up_dropped()


def take_up_dropped() -> None:
    """Take up the objects of the library that lie in the scene."""
    scene = bpy.context.scene
    waiting = [obj.name for obj in scene.objects if TAG in obj] if scene is not None else []
    window = next(iter(bpy.context.window_manager.windows), None)
    for name in waiting:
        with bpy.context.temp_override(window=window):
            try:
                bpy.ops.lappet.asset_take_up("EXEC_DEFAULT", True, object=name)
            except RuntimeError as error:
                print(f"Lappet: {error}")  # the operator has reported it
                bpy.data.objects.remove(scene.objects[name])  # it shows nothing of its own


def register() -> None:
    """Listen for what is dropped, and offer the library."""
    asset_home.register()
    if hasattr(bpy.app.handlers, "blend_import_post"):
        bpy.app.handlers.blend_import_post.append(_imported)


def unregister() -> None:
    """Listen no more."""
    asset_home.unregister()
    if hasattr(bpy.app.handlers, "blend_import_post") and _imported in bpy.app.handlers.blend_import_post:
        bpy.app.handlers.blend_import_post.remove(_imported)


CLASSES = (
    LAPPET_OT_template_install,
    LAPPET_OT_template_remove,
    LAPPET_OT_assets_install,
    LAPPET_OT_assets_remove,
    LAPPET_OT_asset_take_up,
)
