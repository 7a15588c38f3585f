"""Thicken an open surface inwards to a closed sheet: skin, underside and rim."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops
from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import directed_edges, first_intersection, place, unique_edges
from lappet.geometry.triangles import area_normals, directions

_ATTEMPTS = (4, 16, 64, 256)


@dataclass(frozen=True, eq=False)
class Sheet:
    """A closed sheet: the skin's vertices come first, then the underside's in the same order, then the rim's rows.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    skin
        Which triangles are skin, shape (m,).
    underside
        Which triangles are underside, shape (m,).
    rim
        Which triangles are rim, shape (m,).
    rim_level
        Level of each vertex, from 0 on the skin's side to 1 on the underside, shape (n,).
    top
        Skin vertex that each vertex belongs to, shape (n,).
    smoothing
        Rounds of smoothing that the normals took.
    rim_quads
        Corners of the rim's quadrilaterals, shape (q, 4).
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    skin: NDArray[np.bool_]
    underside: NDArray[np.bool_]
    rim: NDArray[np.bool_]
    rim_level: NDArray[np.float64]
    top: NDArray[np.int64]
    smoothing: int
    rim_quads: NDArray[np.int64]


def rim_rows(points: NDArray[np.float64], triangles: NDArray[np.int64], thickness: float) -> int:
    """Count the rows of faces that a rim needs for them to be about as high as the median edge is long.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    thickness
        Thickness of the sheet in mm.

    Returns
    -------
    int
        Number of rows, at least 1.
    """
    edges = np.linalg.norm(points[triangles] - points[np.roll(triangles, 1, axis=1)], axis=2)
    return max(1, round(thickness / float(np.median(edges))))


def thicken(points: NDArray[np.float64], triangles: NDArray[np.int64], thickness: float, rows: int, name: str) -> Sheet:
    """Make the sheet between an open surface and its offset against smoothed normals.

    The normals are smoothed more, up to 256 rounds, where the underside would fold or pass through the skin.

    Parameters
    ----------
    points
        Vertices in mm, all used, shape (n, 3).
    triangles
        Vertex indices, oriented outwards, shape (m, 3).
    thickness
        Thickness of the sheet in mm.
    rows
        Number of rows of quadrilaterals on the rim.
    name
        What messages call the tissue.

    Returns
    -------
    Sheet
        The sheet.

    Raises
    ------
    RefusedError
        If smoothing does not help; the message names the place.
    """
    edges = unique_edges(directed_edges(triangles))[0]
    corner = corner_normals(points, triangles)
    normals = np.zeros_like(points)
    np.add.at(normals, triangles.reshape(-1), corner.reshape(-1, 3))
    normals = directions(normals)
    degree = np.bincount(edges.reshape(-1), minlength=len(points))[:, None]
    done = 0
    where: NDArray[np.float64] | None = None
    for rounds in _ATTEMPTS:
        for _ in range(rounds - done):
            around = np.zeros_like(normals)
            np.add.at(around, edges[:, 0], normals[edges[:, 1]])
            np.add.at(around, edges[:, 1], normals[edges[:, 0]])
            normals = directions(normals + around / np.maximum(degree, 1))
        done = rounds
        sheet = _sheet(points, triangles, points - thickness * normals, rows, rounds)
        where = _fault(sheet, points, triangles)
        if where is None:
            return sheet
    assert where is not None
    raise refused(ProblemCode.SHEET_FOLDS, name, f"{thickness:g}", place=Place.at(where), where=place(where))


def _sheet(
    points: NDArray[np.float64], triangles: NDArray[np.int64], under: NDArray[np.float64], rows: int, rounds: int
) -> Sheet:
    n = len(points)
    vertices, tops, levels = [points, under], [np.arange(n), np.arange(n)], [np.zeros(n), np.ones(n)]
    faces = [triangles, triangles[:, ::-1] + n]
    quads = []
    count = 2 * n
    for loop in border_loops(triangles):
        rails = [loop]
        for row in range(1, rows):
            t = row / rows
            vertices.append((1.0 - t) * points[loop] + t * under[loop])
            tops.append(loop)
            levels.append(np.full(len(loop), t))
            rails.append(count + np.arange(len(loop)))
            count += len(loop)
        rails.append(loop + n)
        for upper, lower in pairwise(rails):
            a, b = upper, np.roll(upper, -1)
            c, d = np.roll(lower, -1), lower
            faces.append(np.concatenate([np.stack([b, a, d], 1), np.stack([b, d, c], 1)]))
            quads.append(np.stack([b, a, d, c], 1))
    kind = np.repeat(np.arange(len(faces)), [len(f) for f in faces])
    return Sheet(
        points=np.concatenate(vertices),
        triangles=np.concatenate(faces),
        skin=kind == 0,
        underside=kind == 1,
        rim=kind > 1,
        rim_level=np.concatenate(levels),
        top=np.concatenate(tops),
        smoothing=rounds,
        rim_quads=np.concatenate(quads) if quads else np.zeros((0, 4), np.int64),
    )


def _fault(sheet: Sheet, points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64] | None:
    """Where the underside is turned over or the sheet passes through itself, or None."""
    n = len(points)
    corners, under = points[triangles], sheet.points[triangles + n]
    turned = np.flatnonzero(np.einsum("ij,ij->i", area_normals(corners), area_normals(under)) <= 0.0)
    if len(turned):
        return np.asarray(corners[turned[0]].mean(axis=0))
    pair = first_intersection(sheet.points, sheet.triangles)
    return None if pair is None else np.asarray(sheet.points[sheet.triangles[list(pair)]].mean(axis=(0, 1)))
