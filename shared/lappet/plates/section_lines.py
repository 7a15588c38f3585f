"""The lines of a cross-section: tissue, level of dissection, bone, threads, hooks and vessels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon, contains_xy
from shapely.geometry import LineString
from shapely.ops import linemerge, unary_union

from lappet.drawing.section_plane import SectionPlane
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.feature_lines import LineKind
from lappet.plates.plate_scene import PlateScene
from lappet.plates.projection import Projection
from lappet.plates.strokes import Stroke

_NEAR = 1.5  # mm: threads that come so near the plane are drawn
_LEAST_VESSEL = 0.65  # mm on paper: radius of the ring of a fine vessel
_AREA_STEP = 1.0  # mm


def section_strokes(
    scene: PlateScene, plane: SectionPlane, projection: Projection, time: float, instruments: bool
) -> list[Stroke]:
    """Draw the lines of a section.

    Parameters
    ----------
    scene
        The procedure.
    plane
        The section.
    projection
        How it comes onto the paper.
    time
        Time code of the frame.
    instruments
        Whether hooks near it are drawn.

    Returns
    -------
    list[Stroke]
        The skin as edge of the wound, the level of dissection, the rest of the outline as contour; the rim of the
        cut-out is not drawn.
    """
    source = scene.source
    epoch = source.epoch_at(time)
    points, rest = source.positions(epoch, time), source.rest(epoch)
    skin, wall = (
        plane.outline(points, epoch.triangles[epoch.origin == kind], rest)[0]
        for kind in (FaceOrigin.SKIN, FaceOrigin.WOUND_WALL)
    )
    below, was = plane.outline(points, epoch.triangles[epoch.origin == FaceOrigin.UNDERSIDE], rest)
    freed = _freed(scene, was, time)
    strokes = _joined(LineKind.CONTOUR, np.concatenate([wall, below[~freed]]), projection)
    strokes += _joined(LineKind.DISSECTION, below[freed], projection)
    strokes += _joined(LineKind.WOUND_EDGE, skin, projection)
    for bone in source.bones:
        edges, _ = plane.outline(bone.points, bone.triangles, bone.points)
        strokes += _joined(LineKind.CONTOUR, edges, projection)
    for line in scene.strands(time):
        away = plane.beyond(line.points)
        if line.kind is LineKind.THREAD or (instruments and line.kind is LineKind.INSTRUMENT):
            strokes += [Stroke(line.kind, run) for run in _runs(projection.paper(line.points)[0], np.abs(away) < _NEAR)]
    return strokes + _vessels(scene, plane, projection, time)


def _freed(scene: PlateScene, was: NDArray[np.float64], time: float) -> NDArray[np.bool_]:
    """Whether edges (e, 2, 3), at rest, lie below what has been undermined."""
    starts = [each.start for each in scene.source.events if each.kind == "Undermine"]
    areas = scene.source.undermined_areas(_AREA_STEP) if starts and max(starts) <= time else []
    flat = [Polygon(area @ scene.axes[:2].T).buffer(0.0) for area in areas if len(area) > 3]
    if not flat or not len(was):
        return np.zeros(len(was), bool)
    middles = was.mean(axis=1) @ scene.axes[:2].T
    found: NDArray[np.bool_] = contains_xy(unary_union(flat), middles[:, 0], middles[:, 1])
    return found


def _vessels(scene: PlateScene, plane: SectionPlane, projection: Projection, time: float) -> list[Stroke]:
    """Rings where vessels meet the plane."""
    vessels = scene.source.vessels(time)
    places, number = plane.pierced([each.points for each in vessels])
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    rings = []
    for at, k in zip(places, number, strict=True):
        radius = max(vessels[k].radius * projection.scale, _LEAST_VESSEL)
        rings.append(Stroke(LineKind.VESSEL, projection.paper(at)[0] + radius * ring))
    return rings


def _joined(kind: LineKind, edges: NDArray[np.float64], projection: Projection) -> list[Stroke]:
    """Edges (e, 2, 3) as strokes."""
    flat = projection.paper(edges.reshape(-1, 3))[0].reshape(-1, 2, 2)
    if not len(flat):
        return []
    joined = unary_union([LineString(edge) for edge in np.round(flat, 6)])
    merged = linemerge(joined) if joined.geom_type == "MultiLineString" else joined
    return [Stroke(kind, np.array(line.coords)) for line in getattr(merged, "geoms", [merged])]


def _runs(points: NDArray[np.float64], kept: NDArray[np.bool_]) -> Sequence[NDArray[np.float64]]:
    """The parts of a line (k, 2) whose points are kept."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], kept, [False]])))
    return [points[a:b] for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a > 1]
