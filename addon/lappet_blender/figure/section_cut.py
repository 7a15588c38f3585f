"""A cross-section of solved tissue in the scene: what lies beyond a plane is gone, and the cut face shows its layers.

Where a place of the cut face was at rest follows from the outline by mean value coordinates, and its layer from the
depth below the uncut skin there.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import bmesh
import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.drawing.mean_value import mean_values
from lappet.drawing.section_plane import Lines, SectionPlane
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.tube_shape import Radius
from lappet.geometry.closest_point import ClosestPoint

from ..look.layer_image import ROW, layer_rows
from ..look.skin_import import SCALE, Bed, SkinObject, build_mesh, set_attribute
from ..look.vessel_tubes import HOLLOW, LUMEN

_EDGE = 0.6  # mm, the longest edge of the cut face
_ROUNDS = 8
_BACK, _BEHIND = 0.9, 1.3  # radii of the thickest vessel: its tube ends, its disc begins so far behind the face
_OUT = 0.06  # mm by which a cut vessel stands out of the face


class TubePart(Protocol):
    """Something that is drawn as tubes."""

    def tubes(self, time: float) -> tuple[Sequence[Any], Sequence[Any]]:
        """Lines (k, 3) and radii of a frame, mm."""


class SectionFace:
    """The cut face."""

    def __init__(self, cache: SkinCache, plane: SectionPlane, material: bpy.types.Material) -> None:
        self._cache, self._plane = cache, plane
        mesh = bpy.data.meshes.new("Section")
        mesh.materials.append(material)
        self._object = bpy.data.objects.new("Section", mesh)
        bpy.context.scene.collection.objects.link(self._object)
        first = cache.epochs[0]
        skin = first.origin == SKIN
        self._column = cache.column(first)[skin]
        self._skin = ClosestPoint(cache.rest(first), first.triangles[skin]) if skin.any() else None

    def show(self, time: float) -> None:
        """Cut the tissue of a frame."""
        epoch = self._cache.epoch_at(time)
        points, rest = self._cache.positions(epoch, time), self._cache.rest(epoch)
        edges, values = self._plane.outline(points, epoch.triangles, rest)
        places, triangles = filled(self._plane, edges)
        before = self._object.data
        material = before.materials[0]
        mesh = build_mesh("Section", places.astype(np.float32), triangles)
        mesh.materials.append(material)
        if len(triangles) and self._skin is not None:
            flat = self._plane.flat(edges)
            was = mean_values(self._plane.flat(places), flat, values)
            set_attribute(mesh, "depth", "FLOAT", "POINT", self._skin.query(was)[2].astype(np.float32))
            nearest = self._skin.query(was[triangles].mean(axis=1))[0]
            set_attribute(mesh, ROW, "FLOAT", "FACE", layer_rows(self._cache.layers, self._column[nearest]))
        self._object.data = mesh
        bpy.data.meshes.remove(before)


class BeforePlane:
    """The skin, or the bed, without what lies beyond a plane."""

    def __init__(self, part: SkinObject | Bed, name: str, plane: SectionPlane) -> None:
        """name: of its object."""
        self._part, self._name, self._plane = part, name, plane
        self._cut: bpy.types.Mesh | None = None
        self._whole: bpy.types.Mesh | None = None

    def show(self, time: float) -> None:
        """Show a frame and take away what lies beyond."""
        found = bpy.data.objects.get(self._name)
        if found is not None and self._whole is not None:
            found.data = self._whole
        self._part.show(time)
        if found is None:
            return
        self._whole = found.data
        form = bmesh.new()
        form.from_mesh(found.data)
        geometry = [*form.verts, *form.edges, *form.faces]
        at, way = self._plane.point * SCALE, self._plane.normal
        bmesh.ops.bisect_plane(form, geom=geometry, plane_co=at, plane_no=way, clear_outer=True)
        if self._cut is not None:
            bpy.data.meshes.remove(self._cut)
        self._cut = found.data.copy()
        form.to_mesh(self._cut)
        form.free()
        found.data = self._cut


class TubesBefore:
    """What is drawn as tubes, cut off at a plane.

    covered: `SectionDiscs` cover the ends, which stay behind the plane by a radius: those of oblique tubes are tilted.
    """

    def __init__(self, part: TubePart, plane: SectionPlane, covered: bool = False) -> None:
        self._part, self._plane, self._covered = part, plane, covered

    def tubes(self, time: float) -> tuple[Lines, list[Radius]]:
        """The lines (k, 3) of a frame and their radii, mm."""
        lines, radii = self._part.tubes(time)
        back = _BACK * max((float(np.max(radius)) for radius in radii), default=0.0) if self._covered else 0.0
        return SectionPlane(self._plane.point - back * self._plane.normal, self._plane.normal).before(
            list(lines), radii
        )


class SectionDiscs:
    """The vessels of one kind as the plane cuts them; `lumen`: not they but their openings."""

    def __init__(self, cache: SkinCache, plane: SectionPlane, kind: str, lumen: bool = False) -> None:
        self._cache, self._plane, self._kind, self._lumen = cache, plane, kind, lumen

    def tubes(self, time: float) -> tuple[Lines, list[Radius]]:
        """Short lines (2, 3) across the plane and their radii, mm."""
        kinds = HOLLOW if self._lumen else (self._kind,)
        vessels = [line for line in self._cache.vessels(time) if line.kind in kinds]
        places, number = self._plane.pierced([line.points for line in vessels])
        out, share = (_OUT + 0.02, LUMEN) if self._lumen else (_OUT, 1.0)
        way, radii = self._plane.normal, [vessels[k].radius for k in number]
        back = _BEHIND * max(radii, default=0.0)
        return [np.concatenate([at - back * way, at + out * way]) for at in places], [share * each for each in radii]


def filled(plane: SectionPlane, edges: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Points (p, 3) and triangles (t, 3) that fill an outline (e, 2, 3), with edges of at most `_EDGE` mm."""
    corners, index = np.unique(np.round(edges.reshape(-1, 3), 6), axis=0, return_inverse=True)
    pairs = np.unique(np.sort(index.reshape(-1, 2), axis=1), axis=0)
    form = bmesh.new()
    made = [form.verts.new(corner) for corner in corners]
    lines = [form.edges.new((made[a], made[b])) for a, b in pairs.tolist() if a != b]
    bmesh.ops.triangle_fill(form, edges=lines, use_beauty=True, normal=plane.normal)
    for _ in range(_ROUNDS):
        long = [edge for edge in form.edges if edge.calc_length() > _EDGE]
        if not long:
            break
        bmesh.ops.subdivide_edges(form, edges=long, cuts=1, use_grid_fill=True)
        bmesh.ops.triangulate(form, faces=list(form.faces))
    form.verts.index_update()
    points = np.array([vertex.co for vertex in form.verts], np.float64).reshape(-1, 3)
    triangles = np.array([[v.index for v in face.verts] for face in form.faces], np.int32).reshape(-1, 3)
    form.free()
    return points, triangles
