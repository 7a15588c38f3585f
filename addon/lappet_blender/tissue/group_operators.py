"""Operators on groups of the tissue's faces."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

from ..model.mesh_values import group_names
from .face_choice import WHICH, chosen_faces
from .face_groups import change_group, remove_group, select_group
from .tissue_objects import tissue_object
from .tissue_operator import OnTissue


class LAPPET_OT_faces_assign(OnTissue, bpy.types.Operator):
    """Add faces of the tissue to a group: fixed faces are held, bed faces are tied to deep tissue"""

    bl_label = "Assign Faces"

    group: StringProperty(name="Group", default="fixed")
    faces: StringProperty(name="Faces", description='Indices such as "0,1,5-9"; empty = the choice below')
    which: EnumProperty(name="Which", items=WHICH, default="SELECTED")
    action: EnumProperty(
        name="Action",
        items=(
            ("ADD", "Add", "Add to the group"),
            ("REMOVE", "Remove", "Take out of the group"),
            ("SET", "Set", "These and no others"),
        ),
        default="ADD",
    )

    def run(self, context: bpy.types.Context) -> str:
        obj = tissue_object(context.scene)
        faces = chosen_faces(context.scene, obj, self.faces, self.which)
        count = change_group(obj, self.group, faces, self.action)
        return f"The group {self.group!r} has {count} faces."


class LAPPET_OT_faces_new(OnTissue, bpy.types.Operator):
    """Make a group of the selected faces: for a retractor to grip, or for a region of another material"""

    bl_label = "New Group"

    group: StringProperty(name="Group", default="grip")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self)

    def run(self, context: bpy.types.Context) -> str:
        obj = tissue_object(context.scene)
        if self.group in group_names(obj.data):
            raise refused(ProblemCode.GROUP_EXISTS, obj.name, self.group)
        count = change_group(obj, self.group, chosen_faces(context.scene, obj, "", "SELECTED"), "SET")
        return f"The group {self.group!r} has {count} faces."


class LAPPET_OT_faces_clear(OnTissue, bpy.types.Operator):
    """Remove a group; its faces stay"""

    bl_label = "Remove Group"

    group: StringProperty(name="Group", default="fixed")

    def run(self, context: bpy.types.Context) -> None:
        remove_group(tissue_object(context.scene), self.group)


class LAPPET_OT_faces_select(OnTissue, bpy.types.Operator):
    """Select the faces of a group"""

    bl_label = "Select Group"

    group: StringProperty(name="Group", default="fixed")
    extend: BoolProperty(name="Extend", default=False)

    def run(self, context: bpy.types.Context) -> None:
        select_group(tissue_object(context.scene), self.group, self.extend)


CLASSES = (LAPPET_OT_faces_assign, LAPPET_OT_faces_new, LAPPET_OT_faces_clear, LAPPET_OT_faces_select)
