"""Cut a region out of a surface, with a clean border on its faces; its texture coordinates ride along."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.normals import corner_normals
from lappet.geometry.surface_check import directed_edges, unique_edges
from lappet.geometry.triangles import directions
from lappet.tissue.mesh_file import Mesh

Level = Callable[[NDArray[np.float64]], NDArray[np.float64]]
_CREASE = 0.5  # cosine of the angle from which an edge is sharp
_MOST_TRIANGLES = 200_000  # a surface that has more is refined no further
_SNAP = 0.2  # of an edge: a vertex nearer to the border than this is moved onto it


def sphere_level(center: Sequence[float], radius: float) -> list[Level]:
    """Make the signed distance that is negative inside a sphere.

    Parameters
    ----------
    center
        Center in mm.
    radius
        Radius in mm.

    Returns
    -------
    list[Level]
        One function from points (k, 3) in mm to distances (k,) in mm.
    """
    middle = np.asarray(center, np.float64)
    return [lambda p: np.linalg.norm(p - middle, axis=1) - radius]


def box_levels(low: Sequence[float], high: Sequence[float]) -> list[Level]:
    """Make the signed distances to the six sides of a box, all negative inside.

    Parameters
    ----------
    low
        Lowest corner in mm.
    high
        Highest corner in mm.

    Returns
    -------
    list[Level]
        Six functions from points (k, 3) in mm to distances (k,) in mm.
    """

    def side(axis: int, at: float, sign: float) -> Level:
        return lambda p: sign * (p[:, axis] - at)

    return [f for k in range(3) for f in (side(k, float(low[k]), -1.0), side(k, float(high[k]), 1.0))]


def refine_smoothly(mesh: Mesh, length: float) -> tuple[Mesh, float]:
    """Quarter all triangles until their edges are short enough, with the new vertices on a smooth surface.

    A new vertex is the middle of its edge on the cubic of the curved point-normal triangle (Vlachos et al. 2001); old
    vertices stay. Edges that turn 60° and more, and borders, keep straight middles.

    Parameters
    ----------
    mesh
        The mesh.
    length
        Length of the edges in mm, on the average, at most.

    Returns
    -------
    tuple[Mesh, float]
        The refined mesh, and how far the farthest new vertex left its edge in mm.
    """
    points, triangles, uv = mesh.points, mesh.triangles, mesh.uv
    moved = 0.0
    while True:
        edges, inverse, counts = unique_edges(directed_edges(triangles))
        a, b = points[edges[:, 0]], points[edges[:, 1]]
        lengths = np.linalg.norm(b - a, axis=1)
        if float(np.median(lengths)) <= length or len(triangles) > _MOST_TRIANGLES:
            return Mesh(points, triangles, uv), moved
        na, nb, level = _edge_normals(points, triangles, edges, inverse)
        rise = np.einsum("ij,ij->i", b - a, na)[:, None] * na - np.einsum("ij,ij->i", b - a, nb)[:, None] * nb
        smooth = (counts == 2) & level & (np.einsum("ij,ij->i", na, nb) > _CREASE)
        rise = np.where(smooth[:, None], -rise / 8.0, 0.0)
        moved = max(moved, float(np.linalg.norm(rise, axis=1).max()))
        n, m = len(points), len(triangles)
        points = np.concatenate([points, 0.5 * (a + b) + rise])
        m01, m12, m20 = (n + inverse[k * m : (k + 1) * m] for k in range(3))
        triangles = _quarters(*triangles.T, m01, m12, m20)
        if uv is not None:
            t0, t1, t2 = uv.swapaxes(0, 1)
            uv = _quarters(t0, t1, t2, 0.5 * (t0 + t1), 0.5 * (t1 + t2), 0.5 * (t2 + t0))


def _edge_normals(
    points: NDArray[np.float64], triangles: NDArray[np.int64], edges: NDArray[np.int64], inverse: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """Normals at both ends of edges (k, 3), from the triangles at each edge, and whether these agree there."""
    corner = corner_normals(points, triangles)
    directed = directed_edges(triangles)
    begins = np.concatenate([corner[:, k] for k in range(3)])
    ends = np.concatenate([corner[:, (k + 1) % 3] for k in range(3)])
    ahead = (directed[:, 0] == edges[inverse, 0])[:, None]
    sums = []
    for normals in (np.where(ahead, begins, ends), np.where(ahead, ends, begins)):
        total = np.zeros((len(edges), 3))
        np.add.at(total, inverse, normals)
        sums.append(total)
    # Two unit vectors 60° apart have a sum of length √3.
    agree = np.minimum(*(np.linalg.norm(total, axis=1) for total in sums)) >= np.sqrt(2.0 + 2.0 * _CREASE)
    return directions(sums[0]), directions(sums[1]), agree


def _quarters(*corners: NDArray[Any]) -> NDArray[Any]:
    """What the corners of quartered triangles have, from that of the three corners and the three middles of edges."""
    v0, v1, v2, m01, m12, m20 = corners
    parts = ((v0, m01, m20), (m01, v1, m12), (m20, m12, v2), (m01, m12, m20))
    quarters = np.stack([np.stack(part, axis=1) for part in parts], axis=1)
    return quarters.reshape(-1, *quarters.shape[2:])


def near(mesh: Mesh, levels: Sequence[Level]) -> Mesh:
    """Keep the triangles that may reach inside: those whose bounding sphere meets the region.

    Parameters
    ----------
    mesh
        The mesh.
    levels
        Signed distances, all negative inside.

    Returns
    -------
    Mesh
        These triangles and their vertices.
    """
    corners = mesh.points[mesh.triangles]
    middle = corners.mean(axis=1)
    reach = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    keep = np.ones(len(mesh.triangles), bool)
    for level in levels:
        keep &= level(middle) <= 2.0 * reach
    return mesh.part(keep)


def crop(mesh: Mesh, levels: Sequence[Level]) -> Mesh:
    """Cut out the part of a surface where all levels are negative; triangles on the border are cut along it.

    Parameters
    ----------
    mesh
        The mesh.
    levels
        Signed distances, all negative inside.

    Returns
    -------
    Mesh
        The part, without triangles where there is none.
    """
    for level in levels:
        mesh = _crop_one(mesh, level(mesh.points), partial(_zero, mesh.points, level))
        if len(mesh.triangles) == 0:
            break
    return mesh.part(np.ones(len(mesh.triangles), bool))


def crop_by_values(mesh: Mesh, values: NDArray[np.float64]) -> Mesh:
    """Cut out the part of a surface where values are negative, taken as linear along the edges.

    Parameters
    ----------
    mesh
        The mesh.
    values
        A finite value for each vertex, shape (n,).

    Returns
    -------
    Mesh
        The part, without triangles where there is none.
    """

    def zero(edges: NDArray[np.int64]) -> NDArray[np.float64]:
        a, b = values[edges[:, 0]], values[edges[:, 1]]
        return np.asarray(a / (a - b))

    cut = _crop_one(mesh, values, zero)
    return cut.part(np.ones(len(cut.triangles), bool))


def _crop_one(mesh: Mesh, value: NDArray[np.float64], zero: Callable[[NDArray[np.int64]], NDArray[np.float64]]) -> Mesh:
    """The part where the values are negative; `zero` says where along edges (k, 2) of the mesh they vanish."""
    points, triangles = mesh.points, mesh.triangles
    edges = unique_edges(directed_edges(triangles))[0]
    crossing = edges[(value[edges[:, 0]] < 0.0) != (value[edges[:, 1]] < 0.0)]
    at = zero(crossing)

    # Vertices close to the border move onto it, along their nearest crossing edge.
    ends, others = np.concatenate([crossing, crossing[:, ::-1]]).T
    fraction = np.concatenate([at, 1.0 - at])
    order = np.argsort(fraction, kind="stable")
    order = order[fraction[order] < _SNAP]
    snapped, first = np.unique(ends[order], return_index=True)
    moved = order[first]
    points = points.copy()
    points[snapped] += (mesh.points[others[moved]] - mesh.points[snapped]) * fraction[moved, None]
    uv = None if mesh.uv is None else _uv_moved(mesh, mesh.uv, snapped, others[moved], fraction[moved])
    value = value.copy()
    value[snapped] = 0.0

    inside, outside = value < 0.0, value > 0.0
    halved = (inside[crossing[:, 0]] & outside[crossing[:, 1]]) | (outside[crossing[:, 0]] & inside[crossing[:, 1]])
    crossing, at = crossing[halved], at[halved]
    mixed = inside[triangles].any(axis=1) & outside[triangles].any(axis=1)
    kept = ~mixed & inside[triangles].any(axis=1)
    new = {
        (a, b): (len(points) + k, t) for k, ((a, b), t) in enumerate(zip(crossing.tolist(), at.tolist(), strict=True))
    }
    points = np.concatenate([points, _between(points[crossing[:, 0]], points[crossing[:, 1]], at[:, None])])
    cut, cut_uv = _cut_triangles(points, triangles[mixed], None if uv is None else uv[mixed], outside, new)
    return Mesh(
        points,
        np.concatenate([triangles[kept], cut]),
        None if uv is None or cut_uv is None else np.concatenate([uv[kept], cut_uv]),
    )


def _between(a: Any, b: Any, at: Any) -> Any:
    return a + (b - a) * at


def _uv_moved(
    mesh: Mesh,
    uv: NDArray[np.float64],
    moved: NDArray[np.int64],
    towards: NDArray[np.int64],
    fraction: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Texture coordinates where vertices move along edges: those that the edge's triangles have there move with them.

    Beyond a seam, where no triangle of the chart has the edge, a triangle's own map is continued.
    """
    triangles = mesh.triangles
    uv, before = uv.copy(), uv
    owner = {vertex: k for k, vertex in enumerate(moved.tolist())}
    places = [(row, corner) for row, corner in np.argwhere(np.isin(triangles, moved)).tolist()]

    def name(row: int, corner: int) -> tuple[int, float, float]:
        return int(triangles[row, corner]), float(before[row, corner, 0]), float(before[row, corner, 1])

    shift: dict[tuple[int, float, float], NDArray[np.float64]] = {}
    for row, corner in places:
        k = owner[int(triangles[row, corner])]
        end = np.flatnonzero(triangles[row] == towards[k])
        if len(end):
            shift[name(row, corner)] = fraction[k] * (before[row, end[0]] - before[row, corner])
    for row, corner in places:
        vertex = int(triangles[row, corner])
        if name(row, corner) not in shift:
            k = owner[vertex]
            way = fraction[k] * (mesh.points[towards[k]] - mesh.points[vertex])
            others = [(corner + 1) % 3, (corner + 2) % 3]
            sides = mesh.points[triangles[row, others]] - mesh.points[vertex]
            share = np.linalg.lstsq(sides.T, way, rcond=None)[0]
            shift[name(row, corner)] = share @ (before[row, others] - before[row, corner])
        uv[row, corner] += shift[name(row, corner)]
    return uv


def _cut_triangles(
    points: NDArray[np.float64],
    triangles: NDArray[np.int64],
    uv: NDArray[np.float64] | None,
    outside: NDArray[np.bool_],
    new: dict[tuple[int, int], tuple[int, float]],
) -> tuple[NDArray[np.int64], NDArray[np.float64] | None]:
    """The inner parts of triangles that the border crosses; `new` has the vertex on each crossed edge and where."""
    cut: list[list[int]] = []
    cut_uv: list[list[NDArray[np.float64]]] = []
    for row, triangle in enumerate(triangles.tolist()):
        polygon: list[int] = []
        texture: list[NDArray[np.float64]] = []
        for i in range(3):
            j = (i + 1) % 3
            a, b = triangle[i], triangle[j]
            if not outside[a]:
                polygon.append(a)
                texture += [] if uv is None else [uv[row, i]]
            middle = new.get((min(a, b), max(a, b)))
            if middle is not None:
                polygon.append(middle[0])
                at = middle[1] if a < b else 1.0 - middle[1]
                texture += [] if uv is None else [_between(uv[row, i], uv[row, j], at)]
        if len(polygon) == 3:
            parts = [(0, 1, 2)]
        else:
            p = points[polygon]
            short = np.linalg.norm(p[0] - p[2]) <= np.linalg.norm(p[1] - p[3])
            parts = [(0, 1, 2), (0, 2, 3)] if short else [(1, 2, 3), (1, 3, 0)]
        cut += [[polygon[k] for k in part] for part in parts]
        cut_uv += [] if uv is None else [[texture[k] for k in part] for part in parts]
    shape = np.array(cut, np.int64).reshape(-1, 3)
    return shape, None if uv is None else np.array(cut_uv, np.float64).reshape(-1, 3, 2)


def _zero(points: NDArray[np.float64], level: Level, edges: NDArray[np.int64]) -> NDArray[np.float64]:
    """Where along each edge (k, 2) the level is zero, by bisection."""
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    low, high = np.zeros(len(edges)), np.ones(len(edges))
    if len(edges) == 0:
        return low
    begin = level(a) < 0.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        same = (level(a + (b - a) * middle[:, None]) < 0.0) == begin
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)
