"""Operators that place hooks and retractors."""

import bpy
from bpy.props import CollectionProperty, FloatProperty, FloatVectorProperty, StringProperty
from mathutils import Euler, Matrix

from lappet.procedure import Hook

from ..interface.operator_base import OperatorBase
from .add_events import add_hook, add_retractor, straight_motion, straight_targets
from .operator_values import given


class LappetKey(bpy.types.PropertyGroup):
    """Where a hook's or retractor's empty is at a frame."""

    frame: FloatProperty(name="Frame")
    co: FloatVectorProperty(name="Location", description="In mm", size=3)
    rotation: FloatVectorProperty(name="Rotation", description="Of a retractor", size=3, subtype="EULER")


class LAPPET_OT_hook_add(OperatorBase, bpy.types.Operator):
    """Set a hook into the skin; its empty can be keyframed like any object"""

    bl_label = "Hook"

    anchor: FloatVectorProperty(name="Anchor", description="At rest, in mm", size=3, precision=3)
    target: FloatVectorProperty(name="Target", description="Where the hook pulls to, in mm", size=3, precision=3)
    origin: FloatVectorProperty(
        name="From",
        description="Where the hook starts to pull, in mm: where the skin is at that time. If not given, the anchor",
        size=3,
        precision=3,
    )
    start: FloatProperty(name="Frame", description="When it is placed; if not given, the current frame")
    arrive: FloatProperty(
        name="Arrives after", description="Frames from the start to the target; 0 = at once", default=8.0, min=0.0
    )
    end: FloatProperty(name="Release", description="When it lets go; if not given, after the last frame")
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=Hook.stiffness, min=0.0)
    keys: CollectionProperty(
        name="Keyframes", description="Of the empty, instead of a straight path to the target", type=LappetKey
    )
    name: StringProperty(name="Name", description="If not given, hook and a number")

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        start = given(self, "start", scene.frame_current)
        end = given(self, "end", max(scene.frame_end, start) + 1)
        targets = [(key.frame, key.co) for key in self.keys]
        if not targets:
            origin = self.origin if self.properties.is_property_set("origin") else self.anchor
            targets = straight_targets(origin, self.target, start, self.arrive)
        add_hook(scene, self.anchor, targets, start, end, stiffness=self.stiffness, name=self.name)


class LAPPET_OT_retractor_add(OperatorBase, bpy.types.Operator):
    """Grip a group of faces of the tissue and move them with an empty"""

    bl_label = "Retractor"

    grip: StringProperty(name="Grip", description="The group of faces to hold")
    shift: FloatVectorProperty(name="Shift", description="How far it pulls, in mm", size=3, precision=3)
    start: FloatProperty(name="Frame", description="When it is placed; if not given, the current frame")
    arrive: FloatProperty(
        name="Arrives after", description="Frames from the start to the end of the movement", default=8.0, min=0.0
    )
    end: FloatProperty(name="Release", description="When it lets go; if not given, after the last frame")
    keys: CollectionProperty(
        name="Keyframes", description="Of the empty, instead of a straight movement", type=LappetKey
    )
    name: StringProperty(name="Name", description="If not given, retractor and a number")

    def run(self, context: bpy.types.Context) -> None:
        scene = context.scene
        start = given(self, "start", scene.frame_current)
        end = given(self, "end", max(scene.frame_end, start) + 1)
        motion = [(k.frame, Matrix.Translation(k.co) @ Euler(k.rotation).to_matrix().to_4x4()) for k in self.keys]
        if not motion:
            motion = straight_motion(scene, self.grip, self.shift, start, self.arrive)
        add_retractor(scene, self.grip, motion, start, end, name=self.name)


CLASSES = (LappetKey, LAPPET_OT_hook_add, LAPPET_OT_retractor_add)
