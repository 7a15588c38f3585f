"""The paper of a stage as views show it: no larger than the camera's picture, while a render has all of it.

A paper that reaches the horizon makes Blender's Frame All draw back so far that the view clips everything away, or
shows the operation as a dot.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Vector

from lappet.drawing.framing import SurgicalField, Viewpoint

_GROUP = "Lappet paper"
_MARGIN = 1.25  # of the paper around the camera's picture
_WIDEST = 8.0  # times the field's extent, of a camera that sees the horizon
# Frame All holds the box around everything in the narrower side of a view with Blender's lens of 50 mm: a little more
# than two diagonals away. The farthest corner is another one behind that.
_DIAGONALS = 4.0


def seen_reach(field: SurgicalField, seen: Viewpoint, tangents: tuple[float, float], lowest: float) -> float:
    """How far from the field's center the paper must reach along its axes to fill a camera's picture, mm.

    tangents: `half_angles` of the picture. lowest: where the paper lies along the field's normal, mm.
    """
    rays = np.array([(x * tangents[0], y * tangents[1], -1.0) for x in (-1, 1) for y in (-1, 1)]) @ seen.axes
    towards = rays @ field.normal
    widest = _WIDEST * field.extent
    if (towards >= 0.0).any():
        return widest
    places = seen.position + ((lowest - seen.position @ field.normal) / towards)[:, None] * rays
    flat = (places - field.center) @ np.stack([field.right, field.up]).T
    return float(min(max(_MARGIN * np.abs(flat).max(), field.extent), widest))


def shorten_in_views(sheet: bpy.types.Object, share: float) -> None:
    """Make a sheet of paper smaller by `share` about its middle, and a render show it as large as it was."""
    middle = sum((vertex.co for vertex in sheet.data.vertices), Vector()) / len(sheet.data.vertices)
    for vertex in sheet.data.vertices:
        vertex.co = share * (vertex.co - middle)
    sheet.location = middle
    modifier = sheet.modifiers.new("Whole in Renders", "NODES")
    modifier.node_group = _enlarging(1.0 / share)
    modifier.show_viewport = False


def _enlarging(factor: float) -> bpy.types.NodeTree:
    """Geometry nodes that enlarge a mesh about its origin."""
    tree = bpy.data.node_groups.new(_GROUP, "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    begin, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    larger = tree.nodes.new("GeometryNodeTransform")
    larger.inputs["Scale"].default_value = (factor,) * 3
    begin.location, end.location = (-200.0, 0.0), (200.0, 0.0)
    tree.links.new(begin.outputs["Geometry"], larger.inputs["Geometry"])
    tree.links.new(larger.outputs["Geometry"], end.inputs["Geometry"])
    return tree


def remove_staged(obj: bpy.types.Object) -> None:
    """Delete an object of a stage; with the paper what enlarges it."""
    trees = [each.node_group for each in obj.modifiers if each.type == "NODES" and each.node_group is not None]
    bpy.data.objects.remove(obj)
    bpy.data.batch_remove([tree for tree in trees if tree.users == 0])


def see_far_enough(objects: list[bpy.types.Object]) -> None:
    """Let every 3D view see so far that Frame All of these objects, as views show them, clips nothing away."""
    corners = np.array([obj.matrix_world @ Vector(corner) for obj in objects for corner in obj.bound_box])
    needed = _DIAGONALS * float(np.linalg.norm(np.ptp(corners, axis=0)))
    for area in (area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D"):
        for space in (space for space in area.spaces if space.type == "VIEW_3D"):
            space.clip_end = max(space.clip_end, needed)
