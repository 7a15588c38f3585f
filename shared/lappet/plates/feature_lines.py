"""The lines by which a surface is known: contours (Hertzmann and Zorin 2000, section 3), wound edges, feet of walls."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.chains import joined_chains
from lappet.plates.drawn_surface import BED, SCENERY, DrawnSurface


class LineKind(StrEnum):
    """What a line of a drawing is; its weight and color follow from that."""

    CONTOUR = "contour"
    WOUND_EDGE = "wound-edge"
    WALL_FOOT = "wall-foot"
    PLAN = "plan"
    UNDERMINED = "undermined"
    UNDERMINED_HATCH = "undermined-hatch"
    THINNED = "thinned"
    THINNED_HATCH = "thinned-hatch"
    DISSECTION = "dissection"
    THREAD = "thread"
    INSTRUMENT = "instrument"
    VESSEL = "vessel"
    HATCHING = "hatching"
    SKIN_LINE = "skin-line"
    SECTION = "section"
    GHOST = "ghost"
    VARIANT = "variant"
    VARIANT_2 = "variant-2"
    VARIANT_3 = "variant-3"
    MARK = "mark"
    MARK_DOT = "mark-dot"


@dataclass(frozen=True, eq=False)
class FeatureLine:
    """A line on the tissue or beside it.

    Parameters
    ----------
    kind
        What it is.
    points
        Its course in mm, shape (k, 3); a closed one repeats its first.
    lift
        How far in mm it may lie behind the surface that is seen there and still be drawn.
    """

    kind: LineKind
    points: NDArray[np.float64]
    lift: float


_LIFT = 0.25  # mm: of edges of the surface itself
_CONTOUR_LIFT = 0.5  # mm: a contour of smooth normals runs inside facets that are turned away


def surface_lines(surface: DrawnSurface, eye: NDArray[np.float64]) -> list[FeatureLine]:
    """Find the lines of a surface.

    Parameters
    ----------
    surface
        The surface.
    eye
        Where the camera stands in mm, shape (3,).

    Returns
    -------
    list[FeatureLine]
        Contours, wound edges and feet of walls, seen or not.
    """
    skin, wall = FaceOrigin.SKIN, FaceOrigin.WOUND_WALL
    lines = [
        FeatureLine(LineKind.WOUND_EDGE, surface.points[each], _LIFT) for each in _borders(surface, (skin,), (wall,))
    ]
    feet = _borders(surface, (wall,), (FaceOrigin.UNDERSIDE, BED))
    lines += [FeatureLine(LineKind.WALL_FOOT, surface.points[each], _LIFT) for each in feet]
    drawn = (surface.origin < FaceOrigin.RIM) | (surface.origin >= SCENERY)
    contours = contour_lines(surface.points, surface.triangles[drawn], surface.normals[drawn], eye)
    return lines + [FeatureLine(LineKind.CONTOUR, each, _CONTOUR_LIFT) for each in contours]


def contour_lines(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    normals: NDArray[np.float64],
    eye: NDArray[np.float64],
) -> list[NDArray[np.float64]]:
    """Find where the smooth normal of a surface is at right angles to the line of sight.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    normals
        Unit normals of the corners, shape (m, 3, 3).
    eye
        Where the camera stands in mm, shape (3,).

    Returns
    -------
    list[NDArray[np.float64]]
        The contours in mm, each of shape (k, 3).
    """
    corners = points[triangles]
    facing = np.einsum("mki,mki->mk", normals, eye - corners)
    positive = facing > 0.0
    crossed = positive.any(axis=1) & ~positive.all(axis=1)
    t, g, p, above = triangles[crossed], facing[crossed], corners[crossed], positive[crossed]
    ends, places = [], []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        cut = above[:, a] != above[:, b]
        share = np.where(cut, g[:, a] / np.where(cut, g[:, a] - g[:, b], 1.0), 0.0)[:, None]
        places.append(p[:, a] + share * (p[:, b] - p[:, a]))
        low, high = np.minimum(t[:, a], t[:, b]), np.maximum(t[:, a], t[:, b])
        ends.append(np.where(cut, low * len(points) + high, -1))
    keys, where = np.stack(ends, axis=1), np.stack(places, axis=1)
    own = keys >= 0
    segments = keys[own].reshape(-1, 2)
    positions = where[own].reshape(-1, 2, 3)
    nodes, inverse = np.unique(segments, return_inverse=True)
    inverse = inverse.reshape(-1, 2)
    at = np.zeros((len(nodes), 3))
    at[inverse.ravel()] = positions.reshape(-1, 3)
    return [at[chain] for chain in joined_chains(inverse)]


def _borders(surface: DrawnSurface, one: tuple[int, ...], other: tuple[int, ...]) -> list[NDArray[np.int64]]:
    """The edges between faces of some origins and faces of others, joined."""
    count = len(surface.points)

    def edges(origins: tuple[int, ...]) -> NDArray[np.int64]:
        t = surface.triangles[np.isin(surface.origin, origins)]
        pairs = np.sort(np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]]), axis=1)
        return np.unique(pairs[:, 0] * count + pairs[:, 1])

    shared = np.intersect1d(edges(one), edges(other))
    return joined_chains(np.stack(np.divmod(shared, count), axis=1))
