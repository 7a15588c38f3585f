"""A cross-section of the tissue on a panel: its layers, its outline, what it lies on, and the threads near it.

Where a place of the section was at rest follows from the outline by mean value coordinates, and its layer from how deep
that is below the uncut skin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from shapely import contains_xy, polygonize
from shapely.geometry import LineString, Polygon
from shapely.ops import linemerge, unary_union

from lappet.drawing.deep_bed import BED_GAP
from lappet.drawing.framing import Viewpoint
from lappet.drawing.mean_value import mean_values
from lappet.drawing.section_plane import SectionPlane
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.drawn_surface import drawn_surface
from lappet.plates.feature_lines import FeatureLine, LineKind
from lappet.plates.filled_areas import Area, AreaKind, SeenPixels, filled_areas, wall_kinds
from lappet.plates.panel_drawing import PanelDrawing, clipped
from lappet.plates.plate_scene import PlateScene
from lappet.plates.projection import Projection
from lappet.plates.section_lines import section_strokes
from lappet.plates.strokes import Stroke

_PIXEL = 0.24  # mm on paper
_FAR = 1e5  # mm: seen from so far a section is drawn without perspective
_ON_SKIN = 0.5  # mm
_FILL = 0.8  # of a panel's width that the operation takes up
_BED = 5.0  # mm on paper: so much of what lies below the tissue is drawn
_LEAST_SPAN = 15.0  # mm: a section across one straight cut shows what lies about it
_KINDS = tuple(AreaKind)


def section_projection(
    scene: PlateScene,
    plane: SectionPlane,
    size: tuple[float, float],
    about: NDArray[np.float64] | None = None,
    across: float = 0.0,
) -> Projection:
    """Look at a section at right angles, at a scale at which the operation fills a panel.

    Parameters
    ----------
    scene
        The procedure.
    plane
        The section.
    size
        Width and height of a panel in mm.
    about
        A place in mm, shape (3,), that is in the panel's middle; None: the operation's middle.
    across
        How much tissue is seen across the panel about that place, mm.

    Returns
    -------
    Projection
        The projection: the skin up, what is taken away towards the eye.
    """
    normal, field = plane.normal, scene.field
    up = field.normal - (field.normal @ normal) * normal
    if np.linalg.norm(up) < 1e-3:  # a section along the skin
        up = field.up - (field.up @ normal) * normal
    up /= np.linalg.norm(up)
    right = np.cross(up, normal)
    near = field.points[np.abs(plane.beyond(field.points)) < 0.5 * np.ptp(field.points @ right)]
    along = (near if len(near) else field.points) @ right
    middle = field.center - plane.beyond(field.center) * normal
    middle = middle + (0.5 * (along.min() + along.max()) - middle @ right) * right
    scale = _FILL * size[0] / max(float(np.ptp(along)), _LEAST_SPAN)
    if about is not None:
        middle, scale = about - plane.beyond(about) * normal, size[0] / across
    view = Viewpoint(middle + _FAR * normal, np.stack([right, up, normal]), _FAR)
    return Projection(view, size, 0.5 * size[0] / (scale * _FAR))


def section_line(scene: PlateScene, plane: SectionPlane, time: float) -> list[FeatureLine]:
    """Find where a section meets the skin.

    Parameters
    ----------
    scene
        The procedure.
    plane
        The section.
    time
        Time code of the frame.

    Returns
    -------
    list[FeatureLine]
        The line, on the part of the skin that the operation takes up and a little beyond.
    """
    epoch = scene.source.epoch_at(time)
    points = scene.source.positions(epoch, time)
    edges, _ = plane.outline(points, epoch.triangles[epoch.origin == FaceOrigin.SKIN], points)
    along = np.cross(scene.field.normal, plane.normal)
    reach = scene.field.points @ along
    margin = 0.1 * float(np.ptp(reach))
    inside = np.abs(edges.mean(axis=1) @ along - 0.5 * (reach.min() + reach.max())) < 0.5 * np.ptp(reach) + margin
    joined = linemerge([LineString(edge) for edge in np.round(edges[inside], 6)]) if inside.any() else None
    parts = [] if joined is None else getattr(joined, "geoms", [joined])
    return [FeatureLine(LineKind.SECTION, np.array(part.coords), _ON_SKIN) for part in parts]


def section_drawing(
    scene: PlateScene, plane: SectionPlane, projection: Projection, time: float, instruments: bool = True
) -> PanelDrawing:
    """Draw a section.

    Parameters
    ----------
    scene
        The procedure.
    plane
        The section.
    projection
        How it comes onto the paper (`section_projection`).
    time
        Time code of the frame.
    instruments
        Whether hooks near it are drawn.

    Returns
    -------
    PanelDrawing
        The drawing.
    """
    source = scene.source
    epoch = source.epoch_at(time)
    points, rest = source.positions(epoch, time), source.rest(epoch)
    edges, was = plane.outline(points, epoch.triangles, rest)
    pixels = _with_bones(_layers(scene, projection, edges, was), scene, plane, projection)
    bed = _bed(scene, plane, projection)
    areas = tuple(filled_areas(_with_bed(pixels, bed)))
    strokes = [
        Stroke(LineKind.WALL_FOOT, ring)
        for area in areas
        if area.kind not in (AreaKind.SKIN, AreaKind.BED)
        for ring in area.rings
    ]
    strokes += _bed_line(bed, filled_areas(pixels))
    strokes += section_strokes(scene, plane, projection, time, instruments)
    surface = drawn_surface(source, scene.bed, (), time)
    return PanelDrawing(projection, surface, pixels, areas, tuple(clipped(strokes, projection.size)), (), ())


def _layers(
    scene: PlateScene, projection: Projection, edges: NDArray[np.float64], was: NDArray[np.float64]
) -> SeenPixels:
    """What layer each pixel of a panel shows."""
    half = 0.5 * np.asarray(projection.size)
    x = np.arange(-half[0] + 0.5 * _PIXEL, half[0], _PIXEL)
    y = np.arange(-half[1] + 0.5 * _PIXEL, half[1], _PIXEL)
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    kind = np.full(len(places), -1, np.int64)
    depth = np.full(len(places), np.inf)
    first = scene.source.epochs[0]
    skin = first.origin == FaceOrigin.SKIN
    whole = ClosestPoint(scene.source.rest(first), first.triangles[skin])
    for own in _pieces(edges):
        flat = projection.paper(edges[own].reshape(-1, 3))[0].reshape(-1, 2, 2)
        tissue = list(polygonize([LineString(edge) for edge in flat]).geoms)
        inside = contains_xy(unary_union(tissue), places[:, 0], places[:, 1]) & (kind < 0)
        if not inside.any():
            continue
        nearest, _, below = whole.query(mean_values(places[inside], flat, was[own]))
        kind[inside] = wall_kinds(below, scene.source.column(first)[skin][nearest], scene.source.layers)
        depth[inside] = _FAR
    shape = (len(y), len(x))
    return SeenPixels(np.full(shape, -1, np.int64), depth.reshape(shape), kind.reshape(shape), x, y)


def _with_bones(pixels: SeenPixels, scene: PlateScene, plane: SectionPlane, projection: Projection) -> SeenPixels:
    """The same with what bones fill of it."""
    places = np.stack(np.meshgrid(pixels.x, pixels.y), axis=-1).reshape(-1, 2)
    kind = pixels.kind.ravel().copy()
    for bone in scene.source.bones:
        edges, _ = plane.outline(bone.points, bone.triangles, bone.points)
        flat = projection.paper(edges.reshape(-1, 3))[0].reshape(-1, 2, 2)
        solid = list(polygonize([LineString(edge) for edge in np.round(flat, 6)]).geoms)
        if solid:
            kind[contains_xy(unary_union(solid), places[:, 0], places[:, 1]) & (kind < 0)] = _KINDS.index(AreaKind.BONE)
    return replace(pixels, kind=kind.reshape(pixels.kind.shape))


def _bed(scene: PlateScene, plane: SectionPlane, projection: Projection) -> list[LineString]:
    """Where a section meets what the tissue lay on, on paper, from left to right."""
    first = scene.source.epochs[0]
    rest = scene.source.rest(first).astype(np.float64)
    edges, _ = plane.outline(rest, first.triangles[first.origin == FaceOrigin.UNDERSIDE], rest)
    if not len(edges):
        return []
    flat = projection.paper(edges.reshape(-1, 3))[0].reshape(-1, 2, 2) + np.array([0.0, BED_GAP * projection.scale])
    joined = linemerge([LineString(edge) for edge in np.round(flat, 6)])
    lines = [line for line in getattr(joined, "geoms", [joined]) if line.length > 0.0]
    return [line if line.coords[0][0] <= line.coords[-1][0] else line.reverse() for line in lines]


def _with_bed(pixels: SeenPixels, bed: Sequence[LineString]) -> SeenPixels:
    """The same with a band of what lies below the tissue."""
    if not bed:
        return pixels
    # y runs downwards, so what is below a line from left to right is on its left.
    below = unary_union([line.buffer(_BED, single_sided=True) for line in bed])
    inside = contains_xy(below, *np.meshgrid(pixels.x, pixels.y))
    return replace(pixels, kind=np.where((pixels.kind < 0) & inside, _KINDS.index(AreaKind.BED), pixels.kind))


def _bed_line(bed: Sequence[LineString], tissue: Sequence[Area]) -> list[Stroke]:
    """The surface of what lies below the tissue, where no tissue covers it."""
    covered = unary_union([Polygon(area.rings[0]) for area in tissue if area.kind is AreaKind.SKIN])
    bare = unary_union([line.difference(covered) for line in bed])
    return [Stroke(LineKind.WALL_FOOT, np.array(part.coords)) for part in getattr(bare, "geoms", [bare]) if part.length]


def _pieces(edges: NDArray[np.float64]) -> list[NDArray[np.bool_]]:
    """The edges (e,) of each piece of tissue in a section: across a closed wound two pieces touch and are not one."""
    if not len(edges):
        return []
    corners, index = np.unique(np.round(edges.reshape(-1, 3), 6), axis=0, return_inverse=True)
    pairs = index.reshape(-1, 2)
    links = csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(corners), len(corners)))
    count, piece = connected_components(links, directed=False)
    return [piece[pairs[:, 0]] == k for k in range(count)]
