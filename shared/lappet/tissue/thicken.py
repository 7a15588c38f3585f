"""Thicken an open surface inwards to a closed sheet: skin, underside and rim.

The thickness is the wanted one wherever the surface leaves room for it. It is limited where the surface has an inner
side of its own, where a piece of skin lies behind itself, and where the skin is curved so strongly that its offset
would fold; from there it grows again by a bounded slope.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.border_loops import border_loops
from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import directed_edges, intersections, place, unique_edges
from lappet.geometry.triangles import area_normals, directions
from lappet.geometry.vertex_neighbors import limit_slope, means_around
from lappet.tissue.inner_side import InnerSide, Surroundings, inner_side, opposite_skin

_ATTEMPTS = (0, 1, 4, 16, 64, 256)  # rounds of smoothing of the normals
_WHOLE = (4, 16, 64, 256)  # of these, those with which the thickness is tried as it is wanted
_LIMITED = (0, 1, 4, 16)  # those with which it is lowered, the last one first
_HALF = 0.45  # of the distance to the same piece of skin: each side takes so much, and a gap is left
_SLOPE = 1.0  # mm of thickness per mm along the skin, where it is limited
_LOWER = 0.8  # where the underside folds, the thickness is lowered to this share of it, again and again
_STEPS = 80
_ROUNDED = 1  # rounds of smoothing of the thickness, where it is limited
_LINED = 0.9  # of the distance to the inner side: an underside that comes so near to it lies on it
_LEAST_AREA = 0.02  # of a skin's triangle: an underside's that is smaller, seen from it, counts as folded
_THINNEST = 0.02  # of the wanted thickness: a place that leaves less room is refused


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
    rim_quads
        Corners of the rim's quadrilaterals, shape (q, 4).
    depth
        Thickness below each skin vertex in mm, shape (s,).
    lining
        Which triangles are underside that lies on free inner skin of the surface, such as the lining of a nostril,
        shape (m,).
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    skin: NDArray[np.bool_]
    underside: NDArray[np.bool_]
    rim: NDArray[np.bool_]
    rim_level: NDArray[np.float64]
    top: NDArray[np.int64]
    rim_quads: NDArray[np.int64]
    depth: NDArray[np.float64]
    lining: NDArray[np.bool_]


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


def thicken(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    thickness: float | NDArray[np.float64],
    rows: int,
    name: str,
    around: Surroundings | None = None,
) -> Sheet:
    """Make the sheet between an open surface and its offset against smoothed normals.

    Where the underside would fold or pass through the skin, the normals are smoothed more, up to 256 rounds. Where
    that does not help, the thickness is lowered there, step by step.

    Parameters
    ----------
    points
        Vertices in mm, all used, shape (n, 3).
    triangles
        Vertex indices, oriented outwards, shape (m, 3).
    thickness
        Thickness of the sheet in mm, one number or one for each vertex, shape (n,).
    rows
        Number of rows of quadrilaterals on the rim.
    name
        What messages call the tissue.
    around
        The surface that this one was taken from, whose own inner side the sheet does not pass; None for none.

    Returns
    -------
    Sheet
        The sheet; `Sheet.depth` says how thick it is where.

    Raises
    ------
    RefusedError
        If less than a fiftieth of the thickness has room somewhere, or the surface passes through itself; the message
        names the place.
    """
    wanted = np.broadcast_to(np.asarray(thickness, np.float64), len(points))
    edges = unique_edges(directed_edges(triangles))[0]
    normals = _corner_means(points, triangles)
    started: list[NDArray[np.float64]] = []
    done = 0
    for rounds in _ATTEMPTS:
        for _ in range(rounds - done):
            normals = directions(normals + means_around(normals, edges))
        done = rounds
        if rounds in _LIMITED:
            started.append(normals)
        if rounds in _WHOLE:
            depth, inner = _room(points, triangles, edges, -normals, wanted, around)
            sheet = _sheet(points, triangles, points - depth[:, None] * normals, rows, depth, inner)
            if not len(_turned(sheet)) and next(intersections(sheet.points, sheet.triangles), None) is None:
                return sheet
    for start in reversed(started[1:]):
        with contextlib.suppress(RefusedError):
            return _lowered(points, triangles, edges, start, wanted, rows, name, around)
    return _lowered(points, triangles, edges, started[0], wanted, rows, name, around)


def _corner_means(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    corner = corner_normals(points, triangles)
    normals = np.zeros_like(points)
    np.add.at(normals, triangles.reshape(-1), corner.reshape(-1, 3))
    return directions(normals)


def _room(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    edges: NDArray[np.int64],
    inwards: NDArray[np.float64],
    wanted: NDArray[np.float64],
    around: Surroundings | None,
) -> tuple[NDArray[np.float64], InnerSide | None]:
    """The thickness for which there is room before the surface's inner side and before the same piece of skin."""
    room = np.minimum(wanted, _HALF * opposite_skin(points, triangles, inwards, wanted / _HALF))
    inner = None if around is None else inner_side(points, inwards, wanted, around)
    if inner is not None:
        room = np.minimum(room, inner.distance)
    return (_smoothed(points, edges, room) if (room < wanted).any() else room), inner


def _smoothed(points: NDArray[np.float64], edges: NDArray[np.int64], depth: NDArray[np.float64]) -> NDArray[np.float64]:
    """A thickness that is nowhere larger and changes slowly along the skin."""
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    for _ in range(_ROUNDED):
        depth = np.minimum(depth, 0.5 * (depth + means_around(depth, edges)))
    return limit_slope(depth, edges, lengths, _SLOPE)


def _lowered(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    edges: NDArray[np.int64],
    normals: NDArray[np.float64],
    wanted: NDArray[np.float64],
    rows: int,
    name: str,
    around: Surroundings | None,
) -> Sheet:
    """The sheet whose thickness is lowered wherever its underside folds or meets anything."""
    depth, inner = _room(points, triangles, edges, -normals, wanted, around)
    room = depth.copy()
    where = int(depth.argmin())
    for _ in range(_STEPS):
        sheet = _sheet(points, triangles, points - depth[:, None] * normals, rows, depth, inner)
        bad = np.unique(triangles[_turned(sheet)])
        if len(bad) == 0:
            bad = _crossing(sheet, name)
            if len(bad) == 0:
                return sheet
        room[bad] = _LOWER * depth[bad]
        where = int(bad[(room[bad] / wanted[bad]).argmin()])
        if room[where] < _THINNEST * wanted[where]:
            break
        depth = _smoothed(points, edges, room)
    value = f"{float(wanted[where]):g}"
    raise refused(ProblemCode.SHEET_FOLDS, name, value, place=Place.at(points[where]), where=place(points[where]))


def _turned(sheet: Sheet) -> NDArray[np.int64]:
    """The triangles of the skin below which the underside is turned over or has next to no area."""
    upper = area_normals(sheet.points[sheet.triangles[sheet.skin]])
    lower = area_normals(sheet.points[sheet.triangles[sheet.underside][:, ::-1]])
    squared = np.einsum("ij,ij->i", upper, upper)
    return np.flatnonzero(np.einsum("ij,ij->i", upper, lower) <= _LEAST_AREA * squared)


def _crossing(sheet: Sheet, name: str) -> NDArray[np.int64]:
    """The vertices of the skin below which the underside or the rim passes through something."""
    pairs = list(intersections(sheet.points, sheet.triangles))
    if not pairs:
        return np.zeros(0, np.int64)
    pair = np.concatenate(pairs)
    both = sheet.skin[pair].all(axis=1)
    if both.any():
        where = sheet.points[sheet.triangles[pair[both][0]]].mean(axis=(0, 1))
        raise refused(ProblemCode.MESH_SELF_INTERSECTING, name, place=Place.at(where), where=place(where))
    below = pair[~sheet.skin[pair]]
    return np.unique(sheet.top[sheet.triangles[below]])


def _sheet(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    under: NDArray[np.float64],
    rows: int,
    depth: NDArray[np.float64],
    inner: InnerSide | None,
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
    lining = np.zeros(len(kind), bool)
    if inner is not None:
        on_free = inner.free & (depth >= _LINED * inner.distance)
        lining[kind == 1] = on_free[triangles].all(axis=1)
    return Sheet(
        points=np.concatenate(vertices),
        triangles=np.concatenate(faces),
        skin=kind == 0,
        underside=kind == 1,
        rim=kind > 1,
        rim_level=np.concatenate(levels),
        top=np.concatenate(tops),
        rim_quads=np.concatenate(quads) if quads else np.zeros((0, 4), np.int64),
        depth=depth,
        lining=lining,
    )
