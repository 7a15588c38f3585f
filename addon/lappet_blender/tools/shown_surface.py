"""The surface that is shown at the moment, as arrays: where its points are, and where they lie at rest.

It is the solved skin where there is one, else the tissue at rest. Arrays and trees are kept until the mesh or the place
of a vertex changes, so that asking costs a check sum.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import FaceOrigin
from lappet.geometry.triangles import area_normals, barycentric, directions
from lappet.procedure import Tissue
from lappet.tissue.surface import skin_faces

from ..display.skin_display import skin_object
from ..model.made_soon import MadeSoon
from ..model.mesh_values import GROUP
from ..model.units import mm_per_unit
from .surface_ray import SurfaceBlocks, SurfaceRay
from .surface_trees import SurfaceTrees

_LARGE = 60_000  # triangles from which on searches are made on a thread: Blender's trees take 0.3 s at 400 000
_LABELS = ("fixed", "bed", "rim", "underside")


@dataclass(frozen=True, eq=False)
class Located:
    """Points on a surface: triangle (k,) and barycentric weights (k, 3)."""

    triangle: NDArray[np.int64]
    weights: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RestShape:
    """A surface at rest. points: (n, 3) mm. triangles: (m, 3). origin, face: (m,), as `EpochShape` has them."""

    points: NDArray[np.float64]
    triangles: NDArray[np.int32]
    origin: NDArray[np.uint8]
    face: NDArray[np.int32]

    @property
    def is_ready(self) -> bool:
        """Whether the searches answer at once; where they would not, they are begun on a thread."""
        return len(self.triangles) < _LARGE or self._searches.done

    @cached_property
    def _searches(self) -> MadeSoon[tuple[SurfaceBlocks, SurfaceTrees, SurfaceTrees]]:
        return MadeSoon(self._make_searches)

    def _make_searches(self) -> tuple[SurfaceBlocks, SurfaceTrees, SurfaceTrees]:
        blocks = SurfaceBlocks(self.points, self.triangles)
        on_skin = np.zeros(len(self.triangles), bool)
        on_skin[self.skin] = True
        skin = blocks.order[on_skin[blocks.order]]
        whole = SurfaceTrees(self.points, self.triangles, blocks.order)
        return blocks, SurfaceTrees(self.points, self.triangles, skin), whole

    @cached_property
    def blocks(self) -> SurfaceBlocks:
        """The order in which rays try the triangles."""
        large = len(self.triangles) >= _LARGE
        return self._searches.take()[0] if large else SurfaceBlocks(self.points, self.triangles)

    @cached_property
    def skin(self) -> NDArray[np.int64]:
        """The triangles (s,) of the skin; all of them where no face is marked as skin."""
        skin = np.flatnonzero(self.origin == FaceOrigin.SKIN)
        return skin if len(skin) else np.arange(len(self.triangles))

    @cached_property
    def _skin_trees(self) -> SurfaceTrees:
        large = len(self.triangles) >= _LARGE
        return self._searches.take()[1] if large else SurfaceTrees(self.points, self.triangles[self.skin])

    @cached_property
    def _whole_trees(self) -> SurfaceTrees:
        large = len(self.triangles) >= _LARGE
        return self._searches.take()[2] if large else SurfaceTrees(self.points, self.triangles)

    def locate(self, points: NDArray[np.float64], skin_only: bool = True) -> Located:
        """The nearest places to rest points (k, 3), mm, on the skin or on the whole surface."""
        trees = self._skin_trees if skin_only else self._whole_trees
        index, place = trees.nearest(np.asarray(points, np.float64).reshape(-1, 3).tolist())
        in_skin = skin_only and len(self.triangles) < _LARGE  # those of a large surface number all triangles
        triangle = self.skin[index] if in_skin else index
        return Located(triangle, barycentric(place, self.points[self.triangles[triangle]]))

    def at(self, located: Located) -> NDArray[np.float64]:
        """The rest places (k, 3), mm, of located points."""
        return np.einsum("kc,kci->ki", located.weights, self.points[self.triangles[located.triangle]])

    def normals(self, triangle: NDArray[np.int64]) -> NDArray[np.float64]:
        """Unit normals (k, 3) of triangles (k,) at rest."""
        return directions(area_normals(self.points[self.triangles[triangle]]))


@dataclass(frozen=True, eq=False)
class ShownSurface:
    """A surface as it is shown.

    positions: (n, 3) of the world. solved: whether it is a solved skin. key: changes when anything does. mm:
    millimetres per unit of the world.
    """

    rest: RestShape
    positions: NDArray[np.float64]
    solved: bool
    key: tuple[Any, ...]
    mm: float

    @cached_property
    def ray(self) -> SurfaceRay:
        """Answer rays of the world."""
        return SurfaceRay(self.rest.blocks, self.positions)

    def carry(self, located: Located) -> NDArray[np.float64]:
        """Where located points (k,) are in the world, (k, 3)."""
        return np.einsum("kc,kci->ki", located.weights, self.positions[self.rest.triangles[located.triangle]])

    def normals(self, triangle: NDArray[np.int64]) -> NDArray[np.float64]:
        """Unit normals (k, 3) of triangles (k,) in the world."""
        return directions(area_normals(self.positions[self.rest.triangles[triangle]]))


_rests: dict[tuple[Any, ...], RestShape] = {}
_shown: dict[str, ShownSurface] = {}
_KEPT = 12


def clear_cache() -> None:
    """Drop what is kept, after another file was opened."""
    _rests.clear()
    _shown.clear()


def shown_object(scene: bpy.types.Scene, viewport: bpy.types.SpaceView3D | None = None) -> bpy.types.Object | None:
    """The object that is drawn on: the solved skin, or else the tissue; of those that are visible (in a viewport).

    One in edit mode is none: its points are in Blender's hands until the mode ends.
    """
    layer = bpy.context.view_layer if bpy.context.scene == scene else scene.view_layers[0]
    for each in (skin_object(scene), scene.lappet.tissue.object):
        if each is not None and each.type == "MESH" and each.name in layer.objects and not each.data.is_editmode:
            visible = (
                each.visible_get(view_layer=layer, viewport=viewport)
                if viewport
                else each.visible_get(view_layer=layer)
            )
            if visible and len(each.data.polygons):
                return each
    return None


def shown_surface(scene: bpy.types.Scene, viewport: bpy.types.SpaceView3D | None = None) -> ShownSurface | None:
    """The surface of `shown_object`; None where nothing is shown."""
    shown = shown_object(scene, viewport)
    if shown is None:
        return None
    mesh = shown.data
    solved = "rest" in mesh.attributes
    mm = mm_per_unit(scene)
    local = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.attributes["position"].data.foreach_get("vector", local)
    place = np.array(shown.matrix_world, np.float64)
    groups = "" if solved else _groups_sum(scene, mesh)
    shape_key: tuple[Any, ...] = (mesh.session_uid, len(mesh.vertices), len(mesh.loops), len(mesh.polygons), groups)
    sums = (zlib.crc32(local.tobytes()), zlib.crc32(place.tobytes()), mm)
    if not solved:
        shape_key = (*shape_key, *sums)
    key = (*shape_key, *sums)
    known = _shown.get(scene.name)
    if known is not None and known.key == key:
        return known
    positions = local.reshape(-1, 3).astype(np.float64) @ place[:3, :3].T + place[:3, 3]
    rest = _rests.get(shape_key)
    if rest is None:
        rest = _read_rest(scene, mesh, positions * mm)
        while len(_rests) >= _KEPT:
            del _rests[next(iter(_rests))]
        _rests[shape_key] = rest
    surface = ShownSurface(rest, positions, solved, key, mm)
    _shown[scene.name] = surface
    return surface


def _read_rest(scene: bpy.types.Scene, mesh: bpy.types.Mesh, here_mm: NDArray[np.float64]) -> RestShape:
    """A mesh at rest: as its attributes say, or as it is where it has none."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    triangles = np.empty(3 * count, np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    owner = np.empty(count, np.int32)
    mesh.loop_triangles.foreach_get("polygon_index", owner)
    points = here_mm
    if "rest" in mesh.attributes:
        flat = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.attributes["rest"].data.foreach_get("vector", flat)
        points = flat.reshape(-1, 3).astype(np.float64)
        origin = _face_integers(mesh, "origin", 0)[owner].astype(np.uint8)
        face = _face_integers(mesh, "face", -1)[owner]
    else:
        origin = np.where(_tissue_skin(scene, mesh)[owner], FaceOrigin.SKIN, FaceOrigin.UNDERSIDE).astype(np.uint8)
        face = owner
    return RestShape(points, triangles.reshape(-1, 3), origin, face)


def _face_integers(mesh: bpy.types.Mesh, name: str, missing: int) -> NDArray[np.int32]:
    values = np.full(len(mesh.polygons), missing, np.int32)
    attribute = mesh.attributes.get(name)
    if attribute is not None and attribute.domain == "FACE" and attribute.data_type in ("INT", "INT8"):
        attribute.data.foreach_get("value", values)
    return values


def _groups(scene: bpy.types.Scene, mesh: bpy.types.Mesh) -> dict[str, NDArray[np.bool_]]:
    """The groups of a closed tissue's faces that say what is skin; an open surface that is thickened is all skin."""
    found = {}
    for label in () if scene.lappet.tissue.thicken else _LABELS:
        attribute = mesh.attributes.get(GROUP + label)
        if attribute is not None and attribute.domain == "FACE" and attribute.data_type == "BOOLEAN":
            found[label] = np.empty(len(mesh.polygons), bool)
            attribute.data.foreach_get("value", found[label])
    return found


def _groups_sum(scene: bpy.types.Scene, mesh: bpy.types.Mesh) -> str:
    return ",".join(f"{label}:{zlib.crc32(mask.tobytes())}" for label, mask in _groups(scene, mesh).items())


def _tissue_skin(scene: bpy.types.Scene, mesh: bpy.types.Mesh) -> NDArray[np.bool_]:
    count = len(mesh.polygons)
    subsets = {label: np.flatnonzero(mask) for label, mask in _groups(scene, mesh).items() if mask.any()}
    return skin_faces(Tissue(np.zeros((0, 3)), np.full(count, 3, np.int32), np.zeros(0, np.int32), subsets=subsets))
