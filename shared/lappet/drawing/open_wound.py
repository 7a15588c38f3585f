"""How much of a wound is left open: what lies between skin edges that sutures do not bring together."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, STRtree, polygonize, polygons, unary_union

from lappet.drawing.skin_source import SkinSource
from lappet.geometry.labeled_surface import FaceOrigin

_HALF_GAP = 1.5  # mm: a seam that gapes by less than twice this is closed


def open_area(source: SkinSource, time: float, normal: NDArray[np.float64]) -> float:
    """Measure the wound that gapes at a frame, seen along the skin's normal.

    Parameters
    ----------
    source
        The solved procedure.
    time
        Time code of the frame.
    normal
        Unit normal of the surgical field, shape (3,).

    Returns
    -------
    float
        The area in mm² that is left of the gaps between the edges of the skin when 1.5 mm are taken off all around.
    """
    epoch = source.epoch_at(time)
    skin = epoch.triangles[epoch.origin == FaceOrigin.SKIN].astype(np.int64)
    walls = epoch.triangles[epoch.origin == FaceOrigin.WOUND_WALL].astype(np.int64)
    edges = _shared(_edges(skin), _edges(walls))
    if not len(edges):
        return 0.0
    across = np.linalg.svd(normal[None])[2][1:]
    flat = source.positions(epoch, time).astype(np.float64) @ across.T
    # Edges that run over each other are cut where they cross.
    lines = unary_union([LineString(flat[edge]) for edge in edges])
    faces = [face for face in polygonize([lines]).geoms if face.area > (2.0 * _HALF_GAP) ** 2]
    sheet = STRtree(polygons(flat[skin]))
    found = 0.0
    for face in faces:
        gap = face.buffer(-_HALF_GAP)
        if gap.is_empty or len(sheet.query(gap.representative_point(), predicate="intersects")):
            continue
        found += float(gap.area)
    return found


def _edges(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """The edges of triangles, the lower vertex first, (3 m, 2)."""
    return np.sort(np.concatenate([triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))]), axis=1)


def _shared(one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.int64]:
    """The edges that are in both, (k, 2)."""
    count = int(max(one.max(initial=0), other.max(initial=0))) + 1
    keys = np.intersect1d(one[:, 0] * count + one[:, 1], other[:, 0] * count + other[:, 1])
    return np.stack([keys // count, keys % count], axis=1)
