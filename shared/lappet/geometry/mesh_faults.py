"""What is wrong with a mesh of polygons, and where: every fault is found here, whoever reports or repairs it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import intersections, place, signed_volume, unique_edges
from lappet.geometry.triangulation import triangulate

EDGES = frozenset({ProblemCode.MESH_NOT_MANIFOLD, ProblemCode.MESH_NOT_ORIENTED})
"""Of a surface that may be open."""
CLOSED = EDGES | {ProblemCode.MESH_OPEN, ProblemCode.MESH_NO_VOLUME}
"""Of a surface that may pass through itself or be inside out."""
SOLID = CLOSED | {ProblemCode.MESH_SELF_INTERSECTING}
"""Of a surface that may be inside out: that is turned."""
MODELLED = SOLID | {ProblemCode.MESH_INSIDE_OUT, ProblemCode.MESH_LOOSE_POINTS, ProblemCode.MESH_NO_AREA}
"""Of a mesh as somebody modeled it."""

MOST_PLACES = 100  # faces and points that a problem names
_NO_AREA = 1e-10  # of the square of the longest edge


def _none(*shape: int) -> NDArray[np.int64]:
    return np.zeros((0, *shape), np.int64)


@dataclass(frozen=True, eq=False)
class MeshFault:
    """One kind of fault of one mesh.

    Parameters
    ----------
    code
        Which fault it is.
    value
        What was found.
    fields
        Further fields of the code's texts.
    edges
        Edges that have it, pairs of the mesh's points, shape (k, 2).
    vertices
        Points that have it, shape (k,).
    faces
        Polygons that have it, shape (k,).
    corners
        Triangles that have it in mm, shape (k, 3, 3).
    places
        Where it is in mm, shape (k, 3); the first is named.
    """

    code: ProblemCode
    value: object
    fields: Mapping[str, object]
    edges: NDArray[np.int64] = field(default_factory=lambda: _none(2))
    vertices: NDArray[np.int64] = field(default_factory=_none)
    faces: NDArray[np.int64] = field(default_factory=_none)
    corners: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3, 3)))
    places: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    def problem(self, prim: str) -> Problem:
        """Make the problem of this fault.

        Parameters
        ----------
        prim
            Path of the mesh's prim.

        Returns
        -------
        Problem
            The problem.
        """
        where = None
        if len(self.faces) or len(self.places):
            points = tuple((float(x), float(y), float(z)) for x, y, z in self.places[:MOST_PLACES])
            where = Place(tuple(self.faces[:MOST_PLACES].tolist()), points)
        return problem(self.code, prim, self.value, place=where, **self.fields)


def mesh_faults(
    points: NDArray[np.float64],
    counts: NDArray[np.integer],
    indices: NDArray[np.integer],
    kinds: Collection[ProblemCode] = SOLID,
    most_crossings: int = 1,
) -> list[MeshFault]:
    """Find every fault of some kinds in a mesh.

    A mesh whose numbers cannot be used has only the faults that say so, whatever the kinds.

    Parameters
    ----------
    points
        Points in mm, shape (n, 3).
    counts
        Corners of each polygon, shape (m,).
    indices
        Points of the polygons, shape (k,).
    kinds
        Which faults count.
    most_crossings
        How many triangles that pierce others are looked for. With 1, a surface whose edges or volume are wrong is not
        searched for crossings.

    Returns
    -------
    list[MeshFault]
        The faults.
    """
    sizes, corner_points = np.asarray(counts, np.int64), np.asarray(indices, np.int64)
    unreadable = list(_unreadable(points, sizes, corner_points))
    if unreadable:
        return unreadable
    faults = _loose(points, corner_points) if ProblemCode.MESH_LOOSE_POINTS in kinds else []
    triangles, _, faces = triangulate(points, sizes, corner_points)
    flat = np.zeros(len(triangles), bool)
    if ProblemCode.MESH_NO_AREA in kinds:
        flat = _without_area(points[triangles])
        if flat.any():
            corners = points[triangles[flat]]
            faults.append(_fault(ProblemCode.MESH_NO_AREA, corners.mean(axis=1), faces=faces[flat], corners=corners))
    edges = [fault for fault in _of_edges(points, sizes, corner_points) if fault.code in kinds]
    faults += edges
    if not edges:
        volume = _of_volume(points, triangles)
        faults += [fault for fault in volume if fault.code in kinds]
        edges = [fault for fault in volume if fault.code is ProblemCode.MESH_NO_VOLUME]
    if ProblemCode.MESH_SELF_INTERSECTING in kinds and (most_crossings > 1 or not edges):
        faults += _crossings(points, triangles[~flat], faces[~flat], most_crossings)
    return faults


def refuse_faults(
    prim: str, points: NDArray[np.float64], triangles: NDArray[np.integer], kinds: Collection[ProblemCode] = CLOSED
) -> None:
    """Refuse a mesh of triangles with faults of some kinds.

    Parameters
    ----------
    prim
        Path of the mesh's prim.
    points
        Points in mm, shape (n, 3).
    triangles
        Point indices, shape (m, 3).
    kinds
        Which faults count.

    Raises
    ------
    RefusedError
        If there are any; holds every one.
    """
    faults = mesh_faults(points, np.full(len(triangles), 3), np.asarray(triangles).reshape(-1), kinds)
    if faults:
        raise RefusedError([fault.problem(prim) for fault in faults])


def refuse_unreadable(
    prim: str, points: NDArray[np.float64], counts: NDArray[np.integer], indices: NDArray[np.integer]
) -> None:
    """Refuse a mesh of polygons whose numbers cannot be used.

    Parameters
    ----------
    prim
        Path of the mesh's prim.
    points
        Points in mm, shape (n, 3).
    counts
        Corners of each polygon, shape (m,).
    indices
        Points of the polygons, shape (k,).

    Raises
    ------
    RefusedError
        If the numbers cannot be used.
    """
    faults = list(_unreadable(points, np.asarray(counts, np.int64), np.asarray(indices, np.int64)))
    if faults:
        raise RefusedError([fault.problem(prim) for fault in faults])


def polygon_edges(counts: NDArray[np.int64], indices: NDArray[np.int64]) -> NDArray[np.int64]:
    """List the edges of polygons in their direction, one for each corner.

    Parameters
    ----------
    counts
        Corners of each polygon, shape (m,).
    indices
        Points of the polygons, shape (k,).

    Returns
    -------
    NDArray[np.int64]
        Pairs of points, shape (k, 2).
    """
    ends = np.cumsum(counts)
    following = np.arange(1, len(indices) + 1)
    following[ends - 1] = ends - counts
    return np.stack([indices, indices[following]], axis=1)


def _fault(code: ProblemCode, places: NDArray[np.float64], uses: int = 0, **parts: NDArray[Any]) -> MeshFault:
    where = place(places[0])
    fields = {"count": len(places), "where": where, "uses": uses}
    return MeshFault(code, where, fields, places=places, **parts)


def _unreadable(
    points: NDArray[np.float64], counts: NDArray[np.int64], indices: NDArray[np.int64]
) -> Iterator[MeshFault]:
    numbers = {"points": len(points), "faces": len(counts), "corners": len(indices)}
    if len(points) == 0 or len(counts) == 0:
        yield MeshFault(ProblemCode.MESH_EMPTY, "empty", numbers)
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(bad):
        value = "(" + ", ".join(f"{v:g}" for v in points[bad[0]]) + ")"
        fields = {**numbers, "count": len(bad), "first": bad[0]}
        yield MeshFault(ProblemCode.MESH_NOT_FINITE, value, fields, vertices=bad)
    small = np.flatnonzero(counts < 3)
    if len(small):
        yield MeshFault(ProblemCode.MESH_SMALL_FACE, counts[small[0]], {"first": small[0]}, faces=small)
    total = int(counts.sum())
    if total != len(indices):
        yield MeshFault(ProblemCode.MESH_CORNER_COUNT, total, numbers)
    outside = np.flatnonzero((indices < 0) | (indices >= len(points)))
    if len(outside):
        yield MeshFault(ProblemCode.MESH_INDEX_RANGE, indices[outside[0]], {**numbers, "count": len(outside)})


def _loose(points: NDArray[np.float64], indices: NDArray[np.int64]) -> list[MeshFault]:
    loose = np.setdiff1d(np.arange(len(points)), indices)
    return [_fault(ProblemCode.MESH_LOOSE_POINTS, points[loose], vertices=loose)] if len(loose) else []


def _of_edges(
    points: NDArray[np.float64], counts: NDArray[np.int64], indices: NDArray[np.int64]
) -> Iterator[MeshFault]:
    edges = polygon_edges(counts, indices)
    real = edges[:, 0] != edges[:, 1]
    edges = edges[real]
    if _all_paired(edges):  # what is wrong takes longer to find
        return
    owners = np.repeat(np.arange(len(counts)), counts)[real]
    pairs, inverse, uses = unique_edges(edges)
    forward = np.zeros(len(pairs), np.int64)
    np.add.at(forward, inverse, np.where(edges[:, 0] < edges[:, 1], 1, -1))
    for code, wrong in (
        (ProblemCode.MESH_OPEN, uses == 1),
        (ProblemCode.MESH_NOT_MANIFOLD, uses > 2),
        (ProblemCode.MESH_NOT_ORIENTED, (uses == 2) & (forward != 0)),
    ):
        if wrong.any():
            middles = points[pairs[wrong]].mean(axis=1)
            faces = np.unique(owners[wrong[inverse]])
            yield _fault(code, middles, edges=pairs[wrong], faces=faces, uses=int(uses[wrong][0]))


def _all_paired(edges: NDArray[np.int64]) -> bool:
    """Whether each directed edge (k, 2) occurs once, and once the other way around."""
    a, b = edges[:, 0], edges[:, 1]
    size = int(edges.max(initial=0)) + 1
    ahead = a < b
    # Neighbors lie near each other in a mesh: a stable sort finds runs and takes half the time.
    there = np.sort((a * size + b)[ahead], kind="stable")
    back = np.sort((b * size + a)[~ahead], kind="stable")
    return np.array_equal(there, back) and bool((there[1:] != there[:-1]).all())


def _of_volume(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> list[MeshFault]:
    volume = signed_volume(points, triangles)
    if not abs(volume) > 1e-12 * float(np.ptp(points, axis=0).max()) ** 3:
        return [MeshFault(ProblemCode.MESH_NO_VOLUME, f"{volume:.3g}", {})]
    return [MeshFault(ProblemCode.MESH_INSIDE_OUT, f"{volume:.4g}", {})] if volume < 0.0 else []


def _crossings(
    points: NDArray[np.float64], triangles: NDArray[np.int64], faces: NDArray[np.int64], most: int
) -> list[MeshFault]:
    """The triangles that pierce others; the search ends once `most` are found."""
    found: list[NDArray[np.int64]] = []
    for pairs in intersections(points, triangles):
        found.append(pairs[:1] if most == 1 else pairs)
        if sum(each.size for each in found) > most:
            break
    if not found:
        return []
    which = np.unique(np.concatenate(found))
    corners = points[triangles[which]]
    middles = corners.mean(axis=(0, 1))[None] if most == 1 else corners.mean(axis=1)
    return [_fault(ProblemCode.MESH_SELF_INTERSECTING, middles, faces=np.unique(faces[which]), corners=corners)]


def _without_area(corners: NDArray[np.float64]) -> NDArray[np.bool_]:
    sides = corners - np.roll(corners, 1, axis=1)
    longest = np.linalg.norm(sides, axis=2).max(axis=1)
    area = np.linalg.norm(np.cross(sides[:, 1], sides[:, 2]), axis=1)
    return np.asarray(area <= _NO_AREA * longest**2)
