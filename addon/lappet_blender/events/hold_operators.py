"""Operators that place hooks and retractors."""

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from bpy.props import CollectionProperty, FloatProperty, FloatVectorProperty, StringProperty
from mathutils import Euler, Matrix

from lappet.procedure import Hook, Point, Retractor

from ..model.event_values import add_value, free_name
from .event_check import check_events, tissue_of
from .event_operator import UNDOABLE, attempt, given


class LappetKey(bpy.types.PropertyGroup):
    """Where a hook's or retractor's empty is at a frame."""

    frame: FloatProperty(name="Frame")
    co: FloatVectorProperty(name="Place", description="mm", size=3)
    rotation: FloatVectorProperty(name="Turn", description="Of a retractor", size=3, subtype="EULER")


class LAPPET_OT_hook_add(bpy.types.Operator):
    """Sets a hook into the skin; its empty is keyframed like anything else"""

    bl_idname = "lappet.hook_add"
    bl_label = "Hook"
    bl_options = UNDOABLE

    anchor: FloatVectorProperty(name="Anchor", description="In mm at rest", size=3, precision=3)
    target: FloatVectorProperty(name="Target", description="Where it pulls to, in mm", size=3, precision=3)
    begin: FloatVectorProperty(
        name="From",
        description="Where it starts to pull, in mm: where the skin is by then. Left out: the anchor",
        size=3,
        precision=3,
    )
    start: FloatProperty(name="Frame", description="When it is set; left out: the scene's frame")
    arrive: FloatProperty(
        name="Arrives after", description="Frames from the start to the target; 0 = at once", default=8.0, min=0.0
    )
    end: FloatProperty(name="Release", description="When it lets go; left out: after the scene's last frame")
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=500.0, min=0.0)
    keys: CollectionProperty(
        name="Keyframes", description="Of the empty, instead of a way from the start to the target", type=LappetKey
    )
    name: StringProperty(name="Name", description="Left out: hook and a number")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        start = given(self, "start", scene.frame_current)
        end = given(self, "end", max(scene.frame_end, start) + 1)
        anchor = _point(self.anchor)

        def act() -> None:
            begin = _point(self.begin) if self.properties.is_property_set("begin") else anchor
            targets: list[tuple[float, Point]] = [(key.frame, _point(key.co)) for key in self.keys]
            if not targets:
                targets = [(start + self.arrive, _point(self.target))]
                if self.arrive > 0.0:
                    targets.insert(0, (start, begin))
            name = free_name(scene, "HOOK", self.name)
            value = Hook(name, anchor, tuple(targets), start, end, self.stiffness)
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


class LAPPET_OT_retractor_add(bpy.types.Operator):
    """Grips a group of the tissue's faces and moves them with an empty"""

    bl_idname = "lappet.retractor_add"
    bl_label = "Retractor"
    bl_options = UNDOABLE

    grip: StringProperty(name="Grip", description="The group of the tissue's faces that it holds")
    shift: FloatVectorProperty(name="Shift", description="How far it pulls, in mm", size=3, precision=3)
    start: FloatProperty(name="Frame", description="When it is set; left out: the scene's frame")
    arrive: FloatProperty(
        name="Arrives after", description="Frames from the start to the end of its way", default=8.0, min=0.0
    )
    end: FloatProperty(name="Release", description="When it lets go; left out: after the scene's last frame")
    keys: CollectionProperty(
        name="Keyframes", description="Of the empty, instead of a way by the shift", type=LappetKey
    )
    name: StringProperty(name="Name", description="Left out: retractor and a number")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        start = given(self, "start", scene.frame_current)
        end = given(self, "end", max(scene.frame_end, start) + 1)

        def act() -> None:
            tissue = tissue_of(scene)
            faces = tissue.subsets.get(self.grip, np.zeros(0, np.int32))
            ends = np.cumsum(tissue.face_vertex_counts)
            corners = [
                tissue.face_vertex_indices[ends[face] - tissue.face_vertex_counts[face] : ends[face]] for face in faces
            ]
            middle = tissue.points[np.unique(np.concatenate(corners))].mean(axis=0) if corners else np.zeros(3)
            motion = [(key.frame, _matrix(key.co, key.rotation)) for key in self.keys]
            if not motion:
                motion = [(start, _matrix(middle)), (start + self.arrive, _matrix(middle + np.array(self.shift)))]
                if self.arrive == 0.0 or not any(self.shift):
                    motion = motion[:1]
            value = Retractor(free_name(scene, "RETRACTOR", self.name), self.grip, tuple(motion), start, end)
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


def _point(values: Any) -> Point:
    x, y, z = values
    return (x, y, z)


def _matrix(place: Any, turn: Sequence[float] = (0.0, 0.0, 0.0)) -> tuple[float, ...]:
    """Row-major, row-vector convention."""
    matrix = Matrix.Translation(place) @ Euler(turn).to_matrix().to_4x4()
    return tuple(np.array(matrix.transposed()).ravel().tolist())


CLASSES = (LappetKey, LAPPET_OT_hook_add, LAPPET_OT_retractor_add)
