"""Operators on the materials of the tissue and its regions."""

import math
import re
from dataclasses import replace

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Region
from lappet.tissue.presets import PRESETS

from ..model.keyframes import curves_of
from ..model.material_values import set_material, set_region
from ..model.mesh_values import group_names
from .face_groups import check_group
from .tissue_objects import tissue_object
from .tissue_operator import TissueOperator
from .tissue_operators import PRESET_ITEMS

_CURVE = re.compile(r"lappet\.materials\[(\d+)\]\.")


def _material(scene: bpy.types.Scene, name: str) -> bpy.types.PropertyGroup:
    found = scene.lappet.materials.get(name)
    if found is None:
        known = ", ".join(each.name for each in scene.lappet.materials) or "none"
        raise refused(ProblemCode.MATERIAL_UNKNOWN, "", name, known=known)
    return found


def _check_new(scene: bpy.types.Scene, name: str) -> None:
    if not (name.isidentifier() and name.isascii()):
        raise refused(ProblemCode.MATERIAL_NAME, "", name)
    if name in scene.lappet.materials:
        raise refused(ProblemCode.MATERIAL_EXISTS, "", name)


class LAPPET_OT_material_add(TissueOperator, bpy.types.Operator):
    """Add a material, with the values of a preset"""

    bl_label = "Add Material"

    name: StringProperty(name="Name", description="Empty = the name of the preset")
    preset: EnumProperty(name="Preset", items=PRESET_ITEMS, default="SKIN")

    def run(self, context: bpy.types.Context) -> None:
        scene, material = context.scene, PRESETS[self.preset.lower()].material
        name, number = self.name or material.name, 1
        while not self.name and name in scene.lappet.materials:
            number += 1
            name = f"{material.name}_{number}"
        _check_new(scene, name)
        set_material(scene, scene.lappet.materials.add(), replace(material, name=name))
        scene.lappet.active_material = len(scene.lappet.materials) - 1


class LAPPET_OT_material_remove(TissueOperator, bpy.types.Operator):
    """Remove a material that nothing is made of"""

    bl_label = "Remove Material"

    name: StringProperty(name="Name")

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        _material(scene, self.name)
        if scene.lappet.tissue.material == self.name and scene.lappet.tissue.object is not None:
            raise refused(ProblemCode.MATERIAL_IN_USE, "", self.name, user="The tissue")
        users = [region.name for region in scene.lappet.regions if region.material == self.name]
        if users:
            raise refused(ProblemCode.MATERIAL_IN_USE, "", self.name, user=f"The region {users[0]!r}")
        index = scene.lappet.materials.find(self.name)
        _move_curves(scene, index)
        scene.lappet.materials.remove(index)
        scene.lappet.active_material = max(0, min(scene.lappet.active_material, len(scene.lappet.materials) - 1))


def _move_curves(scene: bpy.types.Scene, index: int) -> None:
    """Keyframes name materials by their number: those of a removed one go, those behind it move up."""
    each = scene.lappet.materials[index]
    path = each.path_from_id("activation")
    for curve in [curve for curve in curves_of(scene) if curve.data_path == path]:
        for time in [point.co[0] for point in curve.keyframe_points][::-1]:
            each.keyframe_delete("activation", frame=time)
    for curve in curves_of(scene):
        found = _CURVE.match(curve.data_path)
        if found and int(found[1]) > index:
            curve.data_path = f"lappet.materials[{int(found[1]) - 1}].{curve.data_path[found.end() :]}"


class LAPPET_OT_material_rename(TissueOperator, bpy.types.Operator):
    """Rename a material, wherever it is used"""

    bl_label = "Rename Material"

    name: StringProperty(name="Name")
    new_name: StringProperty(name="New name")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        self.new_name = self.name
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        each = _material(scene, self.name)
        _check_new(scene, self.new_name)
        each.name = self.new_name
        for user in (scene.lappet.tissue, *scene.lappet.regions):
            if user.material == self.name:
                user.material = self.new_name


class LAPPET_OT_material_preset(TissueOperator, bpy.types.Operator):
    """Give a material the values of a preset"""

    bl_label = "Use Preset"

    name: StringProperty(name="Name", description="Name of the material; empty = the material of the tissue")
    preset: EnumProperty(name="Preset", items=PRESET_ITEMS, default="SKIN")

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        return PRESETS[properties.preset.lower()].source

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        each = _material(scene, self.name or scene.lappet.tissue.material)
        set_material(scene, each, replace(PRESETS[self.preset.lower()].material, name=each.name))


class LAPPET_OT_region_add(TissueOperator, bpy.types.Operator):
    """Give the tissue below a group of faces another material"""

    bl_label = "Add Region"

    group: StringProperty(name="Group", description="A group of faces of the tissue")
    material: StringProperty(name="Material")
    depth_from: FloatProperty(name="From", description="Depth below the skin, in mm", default=0.0, min=0.0)
    depth_to: FloatProperty(
        name="To", description="Depth below the skin, in mm; 0 = to the bottom", default=0.0, min=0.0
    )

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context: bpy.types.Context) -> None:
        obj, layout = context.scene.lappet.tissue.object, self.layout
        layout.label(text="Groups: " + (", ".join(group_names(obj.data)) if obj is not None else "none"))
        layout.prop(self, "group")
        layout.prop_search(self, "material", context.scene.lappet, "materials")
        layout.prop(self, "depth_from")
        layout.prop(self, "depth_to")

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        obj = tissue_object(scene)
        if not self.group and group_names(obj.data):
            raise refused(ProblemCode.GROUP_NONE_GIVEN, obj.name, known=", ".join(group_names(obj.data)))
        check_group(obj, self.group)
        if self.group in scene.lappet.regions:
            raise refused(ProblemCode.REGION_SUBSET_TWICE, obj.name, self.group, times=2)
        material = self.material or scene.lappet.tissue.material
        _material(scene, material)
        if 0.0 < self.depth_to <= self.depth_from:
            raise refused(ProblemCode.REGION_DEPTHS, self.group, f"{self.depth_to:g}", top=self.depth_from)
        region = Region(self.group, material, self.depth_from, self.depth_to or math.inf)
        set_region(scene.lappet.regions.add(), region)
        scene.lappet.active_region = len(scene.lappet.regions) - 1


class LAPPET_OT_region_remove(TissueOperator, bpy.types.Operator):
    """Remove a region; its group of faces stays"""

    bl_label = "Remove Region"

    group: StringProperty(name="Group")

    def run(self, context: bpy.types.Context) -> None:
        regions = context.scene.lappet.regions
        index = regions.find(self.group)
        if index < 0:
            known = ", ".join(each.name for each in regions) or "none"
            raise refused(ProblemCode.REGION_OF_GROUP_UNKNOWN, "", self.group, known=known)
        regions.remove(index)
        context.scene.lappet.active_region = max(0, min(context.scene.lappet.active_region, len(regions) - 1))


CLASSES = (
    LAPPET_OT_material_add,
    LAPPET_OT_material_remove,
    LAPPET_OT_material_rename,
    LAPPET_OT_material_preset,
    LAPPET_OT_region_add,
    LAPPET_OT_region_remove,
)
