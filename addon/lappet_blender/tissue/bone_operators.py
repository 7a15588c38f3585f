"""Operators on the bones: meshes that the tissue may not enter."""

import bpy
from bpy.props import StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..model.tissue_values import identifier
from .tissue_objects import named_object
from .tissue_operator import TissueOperator


class LAPPET_OT_bone_add(TissueOperator, bpy.types.Operator):
    """Make a closed mesh a bone, which the tissue cannot enter"""

    bl_label = "Add Bone"

    object: StringProperty(name="Object", description="Name of the object; empty = the active object")

    def run(self, context: bpy.types.Context) -> None:
        procedure = context.scene.lappet
        obj = named_object(context, self.object)
        if obj.type != "MESH":
            raise refused(ProblemCode.OBJECT_NOT_A_MESH, obj.name, obj.type.lower(), role="object")
        if obj == procedure.tissue.object:
            raise refused(ProblemCode.BONE_IS_TISSUE, obj.name)
        if any(bone.object == obj for bone in procedure.bones):
            raise refused(ProblemCode.BONE_KNOWN, obj.name)
        taken = {bone.name for bone in procedure.bones}
        bone = procedure.bones.add()
        bone.name, bone.object = identifier(obj.name, taken), obj


class LAPPET_OT_bone_remove(TissueOperator, bpy.types.Operator):
    """Remove a bone from the procedure; the object stays"""

    bl_label = "Remove Bone"

    object: StringProperty(name="Object", description="Name of the object; empty = the active object")

    def run(self, context: bpy.types.Context) -> None:
        bones = context.scene.lappet.bones
        active = context.view_layer.objects.active
        name = self.object or (active.name if active is not None else "")
        index = next((i for i in range(len(bones) - 1, -1, -1) if _is(bones[i], name)), -1)
        if index < 0:
            known = ", ".join(bone.object.name for bone in bones if bone.object) or "none"
            raise refused(ProblemCode.BONE_UNKNOWN, "", name, known=known)
        bones.remove(index)


def _is(bone: bpy.types.PropertyGroup, name: str) -> bool:
    return bone.name == name if bone.object is None else bone.object.name == name


CLASSES = (LAPPET_OT_bone_add, LAPPET_OT_bone_remove)
