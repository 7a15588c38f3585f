"""Where a surface has an inner side of its own: how far below each point of the skin it lies, and what is behind it.

Below the skin of a nose lies the lining of the nostril, below a cheek the mucosa of the mouth, below a scan of a shell
its inner wall. A sheet of tissue ends there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import closest_points
from lappet.geometry.connected_parts import parts_of
from lappet.geometry.segment_hits import first_hits
from lappet.geometry.triangles import area_normals, directions

_LEAVING = 0.2  # cosine: a ray ends where it leaves the surface at least as steeply as this
_ASKED = 50  # points of the skin of which it is asked to which part they belong
_ROUNDS = 8  # triangles that a ray may pass before it ends
_ONWARDS = 1e-3  # of the reach: so far behind what it has passed a ray goes on


@dataclass(frozen=True, eq=False)
class Surroundings:
    """The whole surface that a piece of skin was taken from.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, oriented outwards, shape (m, 3).
    connected
        Which triangles are connected with the skin, shape (m,).
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    connected: NDArray[np.bool_]

    @staticmethod
    def of(points: NDArray[np.float64], triangles: NDArray[np.int64], skin: NDArray[np.float64]) -> Surroundings:
        """Tell what of a surface is connected with a piece of skin that was taken from it.

        Parameters
        ----------
        points
            Vertices in mm, shape (n, 3).
        triangles
            Vertex indices, oriented outwards, shape (m, 3).
        skin
            Points of the piece in mm, shape (k, 3).

        Returns
        -------
        Surroundings
            The surface.
        """
        part = parts_of(triangles, len(points))
        near = closest_points(skin[:: max(1, len(skin) // _ASKED)], points, triangles)[0]
        return Surroundings(points, triangles, part == np.bincount(part[near]).argmax())


@dataclass(frozen=True, eq=False)
class InnerSide:
    """What lies below each of n points of the skin.

    Parameters
    ----------
    distance
        How far below, mm, shape (n,); infinite where there is nothing within reach.
    free
        Whether it is connected with the skin: the lining of a nostril, mucosa, the back of an ear; shape (n,). What is
        not connected with it is a wall, such as a skull.
    """

    distance: NDArray[np.float64]
    free: NDArray[np.bool_]


def inner_side(
    skin: NDArray[np.float64], inwards: NDArray[np.float64], reach: NDArray[np.float64], around: Surroundings
) -> InnerSide:
    """Find the inner side of a surface below points of its skin.

    A ray from each point ends where it leaves the surface, or where it meets a part of it that is not connected with
    the skin.

    Parameters
    ----------
    skin
        Points of the skin in mm, shape (n, 3).
    inwards
        Unit vectors into the tissue, shape (n, 3).
    reach
        How far to look below each point in mm, shape (n,).
    around
        The surface.

    Returns
    -------
    InnerSide
        What was found.
    """
    low, high = skin.min(axis=0) - reach.max(), skin.max(axis=0) + reach.max()
    corners = around.points[around.triangles]
    kept = np.flatnonzero(((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1))
    walls = ~around.connected[kept]
    triangle, distance = _leave(skin, inwards, reach, around.points, around.triangles[kept], walls)
    met = triangle >= 0
    free = np.zeros(len(skin), bool)
    free[met] = ~walls[triangle[met]]
    return InnerSide(distance, free)


def opposite_skin(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    inwards: NDArray[np.float64],
    reach: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Measure how far below each vertex of a piece of skin that same piece lies again, as in a fold or around a rim.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, oriented outwards, shape (m, 3).
    inwards
        Unit vectors into the tissue, shape (n, 3).
    reach
        How far to look in mm, shape (n,).

    Returns
    -------
    NDArray[np.float64]
        Distances in mm, shape (n,); infinite where there is nothing within reach.
    """
    return _leave(points, inwards, reach, points, triangles, np.zeros(len(triangles), bool))[1]


def _leave(
    starts: NDArray[np.float64],
    inwards: NDArray[np.float64],
    reach: NDArray[np.float64],
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    solid: NDArray[np.bool_],
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """The triangle at which each ray ends, -1 for none, and its distance; `solid` ones end rays from either side."""
    found, distance = np.full(len(starts), -1, np.int64), np.full(len(starts), np.inf)
    if len(triangles) == 0:
        return found, distance
    normals = directions(area_normals(points[triangles]))
    rows = np.arange(len(starts))
    begin = _ONWARDS * reach
    for _ in range(_ROUNDS):
        one = starts[rows] + begin[rows, None] * inwards[rows]
        two = starts[rows] + reach[rows, None] * inwards[rows]
        hits = first_hits(one, two, points, triangles)
        met = hits.triangle >= 0
        rows, triangle, at = rows[met], hits.triangle[met], hits.fraction[met]
        at = begin[rows] + at * (reach[rows] - begin[rows])
        ends = solid[triangle] | (np.einsum("ij,ij->i", normals[triangle], inwards[rows]) > _LEAVING)
        found[rows[ends]], distance[rows[ends]] = triangle[ends], at[ends]
        begin[rows] = at + _ONWARDS * reach[rows]
        rows = rows[~ends & (begin[rows] < reach[rows])]
        if len(rows) == 0:
            break
    return found, distance
