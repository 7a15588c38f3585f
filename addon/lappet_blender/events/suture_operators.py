"""Operators that suture: two points, or a run of evenly spaced sutures."""

import bpy
import numpy as np
from bpy.props import BoolProperty, CollectionProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty
from numpy.typing import NDArray

from lappet.core.problem import RefusedError
from lappet.geometry.closest_point import ClosestPoint
from lappet.procedure import Incision, Point, Suture
from lappet.tissue.fan_triangles import fan_triangles

from ..model.event_properties import LappetPoint
from ..model.event_values import add_value, event_value, free_name
from .event_check import check_events, tissue_of
from .event_operator import UNDOABLE, attempt, given, named_event, places
from .suture_pairs import BESIDE, across_incision, along, count_for, incision_line, length, shares_along

Ends = tuple[NDArray[np.float64], NDArray[np.float64]]


class LAPPET_OT_suture_add(bpy.types.Operator):
    """Draws two points together and holds them"""

    bl_idname = "lappet.suture_add"
    bl_label = "Suture"
    bl_options = UNDOABLE

    first: FloatVectorProperty(name="From", description="In mm at rest", size=3, precision=3)
    second: FloatVectorProperty(name="To", description="In mm at rest", size=3, precision=3)
    start: FloatProperty(name="Frame", description="When it is placed; left out: the scene's frame")
    duration: FloatProperty(name="Duration", description="Frames that it takes to close", default=1.0, min=0.0)
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=1000.0, min=0.0)
    depth: FloatProperty(name="Depth", description="Of both ends below the skin, in mm", default=0.0, min=0.0)
    name: StringProperty(name="Name", description="Left out: suture and a number")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        start = given(self, "start", scene.frame_current)

        def act() -> None:
            name = free_name(scene, "SUTURE", self.name)
            first, second = _sunk(scene, np.array([self.first, self.second], np.float64), self.depth)
            value = Suture(name, (_point(first), _point(second)), start, self.duration, self.stiffness)
            check_events(scene, [value])
            add_value(scene, value)

        return attempt(self, act)


class LAPPET_OT_suture_run(bpy.types.Operator):
    """Places evenly spaced sutures between two wound edges, or across an incision"""

    bl_idname = "lappet.suture_run"
    bl_label = "Run of Sutures"
    bl_options = UNDOABLE

    first_edge: CollectionProperty(name="First edge", description="In mm at rest", type=LappetPoint)
    second_edge: CollectionProperty(
        name="Second edge", description="In mm at rest; its first point meets the first edge's", type=LappetPoint
    )
    flip: BoolProperty(name="Flip", description="The second edge runs the other way", default=False)
    incision: StringProperty(name="Incision", description="Suture across this incision, instead of between two edges")
    bite: FloatProperty(
        name="Bite",
        description="From the middle of the incision to an anchor, in mm; 0 = at the wound's edge",
        default=0.0,
        min=0.0,
    )
    depth: FloatProperty(
        name="Depth",
        description="Of the anchors below the skin, in mm: a buried row holds the walls of the wound together",
        default=0.0,
        min=0.0,
    )
    count: IntProperty(name="Sutures", description="How many; 0 = as many as the spacing gives", default=0, min=0)
    spacing: FloatProperty(name="Spacing", description="From suture to suture, in mm", default=4.0, min=0.01)
    inset_start: FloatProperty(
        name="First",
        description="Share of the edge before the first suture; left out: half a distance",
        min=0.0,
        max=1.0,
    )
    inset_end: FloatProperty(
        name="Last", description="Share of the edge after the last suture; left out: half a distance", min=0.0, max=1.0
    )
    start: FloatProperty(name="Frame", description="When they are placed; left out: the scene's frame")
    duration: FloatProperty(name="Duration", description="Frames that they take to close", default=8.0, min=0.0)
    stiffness: FloatProperty(name="Stiffness", description="mN/mm", default=1000.0, min=0.0)
    name: StringProperty(name="Name", description="Of the first; the others are counted up. Left out: suture")

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        start = given(self, "start", scene.frame_current)

        def act() -> None:
            first, second = self._across(scene) if self.incision else self._between()
            first, second = _sunk(scene, first, self.depth), _sunk(scene, second, self.depth)
            stem = f"{self.name}_1" if self.name else ""
            values: list[Suture] = []
            taken: set[str] = set()
            for ends in zip(first, second, strict=True):
                name = free_name(scene, "SUTURE", stem, taken)
                taken.add(name)
                values.append(Suture(name, (_point(ends[0]), _point(ends[1])), start, self.duration, self.stiffness))
            check_events(scene, values)
            for value in values:
                add_value(scene, value)

        return attempt(self, act)

    def _between(self) -> Ends:
        edges = [places(self.first_edge), places(self.second_edge)]
        for name, edge in zip(("first", "second"), edges, strict=True):
            if len(edge) < 2 or length(edge) == 0.0:
                raise RefusedError(f"The {name} edge has {len(edge)} points and no length; draw it along the wound.")
        if self.flip:
            edges[1].reverse()
        shares = self._shares(0.5 * (length(edges[0]) + length(edges[1])))
        return along(edges[0], shares), along(edges[1], shares)

    def _across(self, scene: bpy.types.Scene) -> Ends:
        event = named_event(scene, self.incision)
        value = event_value(scene, event)
        if not isinstance(value, Incision):
            raise RefusedError(f"{event.name} is no incision; name one, or give two edges.")
        skin, normals = _skin(scene)
        bite = self.bite if self.bite > 0.0 else 0.5 * value.kerf + BESIDE
        shares = self._shares(length(incision_line(value)))
        return across_incision(value, shares, bite, skin, normals)

    def _shares(self, size: float) -> NDArray[np.float64]:
        set_start, set_end = (self.properties.is_property_set(name) for name in ("inset_start", "inset_end"))
        return shares_along(
            self.count or count_for(size, self.spacing),
            self.inset_start if set_start else None,
            self.inset_end if set_end else None,
        )


def _skin(scene: bpy.types.Scene) -> tuple[ClosestPoint, NDArray[np.float64]]:
    """The tissue's surface at rest and the normals (m, 3) of its triangles."""
    tissue = tissue_of(scene)
    triangles, _ = fan_triangles(tissue)
    corners = tissue.points[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return ClosestPoint(tissue.points, triangles), normals


def _sunk(scene: bpy.types.Scene, points: NDArray[np.float64], depth: float) -> NDArray[np.float64]:
    """Points (n, 3) on the skin moved into the tissue by `depth` mm."""
    if depth <= 0.0:
        return points
    skin, normals = _skin(scene)
    return np.asarray(points - depth * normals[skin.query(points)[0]], np.float64)


def _point(values: NDArray[np.float64]) -> Point:
    x, y, z = (float(v) for v in values)
    return (x, y, z)


CLASSES = (LAPPET_OT_suture_add, LAPPET_OT_suture_run)
