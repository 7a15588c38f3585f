"""A labeled tissue as a manifold3d solid and back: labels ride as run ids, UVs as vertex properties."""

from __future__ import annotations

from dataclasses import dataclass, field

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.surface_check import signed_volume
from lappet.geometry.unique_rows import unique_rows


@dataclass(frozen=True)
class Label:
    """What the triangles of one run have in common.

    Parameters
    ----------
    origin
        Where they come from.
    fixed
        Whether they are held in space.
    bed
        Whether they are attached to the bed.
    grips
        Names of the subsets that hold them.
    """

    origin: FaceOrigin
    fixed: bool = False
    bed: bool = False
    grips: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class LabeledSolid:
    """Tissue in a Boolean operation.

    Parameters
    ----------
    solid
        The solid.
    labels
        What each run id means.
    grips
        Names of the subsets in use.
    """

    solid: manifold3d.Manifold
    labels: dict[int, Label]
    grips: tuple[str, ...] = field(default=())

    @staticmethod
    def from_surface(surface: Surface, tolerance: float = 0.0) -> LabeledSolid:
        """Make the solid of a closed surface.

        Parameters
        ----------
        surface
            The labeled surface.
        tolerance
            Tolerance of the Boolean in mm; 0 leaves it to the library.

        Returns
        -------
        LabeledSolid
            The solid with its labels.

        Raises
        ------
        RefusedError
            If the library refuses the surface.
        """
        names = tuple(surface.grips)
        kinds, kind = unique_rows(
            np.stack([surface.origin, surface.fixed, surface.bed, *(surface.grips[n] for n in names)], axis=1)
        )
        first = manifold3d.Manifold.reserve_ids(len(kinds))
        labels = {
            first + k: Label(
                FaceOrigin(int(row[0])),
                bool(row[1]),
                bool(row[2]),
                tuple(n for n, on in zip(names, row[3:], strict=True) if on),
            )
            for k, row in enumerate(kinds)
        }
        order = np.argsort(kind, kind="stable")
        triangles, uv = surface.triangles[order].astype(np.int64), surface.uv[order].astype(np.float64)
        vertices, corners, from_vertex, to_vertex = _split_by_uv(surface.points, triangles, uv)
        mesh = manifold3d.Mesh64(
            vert_properties=vertices,
            tri_verts=corners.astype(np.uint64),
            merge_from_vert=from_vertex,
            merge_to_vert=to_vertex,
            run_index=np.searchsorted(kind[order], np.arange(len(kinds) + 1)).astype(np.uint64) * np.uint64(3),
            run_original_id=np.arange(first, first + len(kinds), dtype=np.uint32),
            face_id=np.arange(len(triangles), dtype=np.uint64),
            tolerance=tolerance,
        )
        solid = manifold3d.Manifold(mesh)
        if solid.status() != manifold3d.Error.NoError:
            raise refused(ProblemCode.MESH_NOT_SOLID, "/Procedure/Tissue", solid.status().name)
        return LabeledSolid(solid, labels, names)

    def with_solid(self, solid: manifold3d.Manifold, extra: dict[int, Label] | None = None) -> LabeledSolid:
        """Put another solid under the same labels.

        Parameters
        ----------
        solid
            The other solid.
        extra
            Further labels by run id.

        Returns
        -------
        LabeledSolid
            The labeled solid.
        """
        return LabeledSolid(solid, {**self.labels, **(extra or {})}, self.grips)

    def surface(self) -> Surface:
        """Read the labeled surface back.

        Returns
        -------
        Surface
            The surface; its vertices come in the order in which the triangles name them.
        """
        mesh = self.solid.to_mesh64()
        vertices = np.asarray(mesh.vert_properties)
        corners = np.asarray(mesh.tri_verts).astype(np.int64).reshape(-1, 3)
        target = np.arange(len(vertices))
        target[np.asarray(mesh.merge_from_vert, np.int64)] = np.asarray(mesh.merge_to_vert, np.int64)
        while not np.array_equal(target, target[target]):
            target = target[target]
        named = target[corners]
        flat = named.reshape(-1)
        first = np.empty(len(vertices), np.int64)
        first[flat[::-1]] = np.arange(len(flat))[::-1]
        by_first_use = flat[first[flat] == np.arange(len(flat))]
        rank = np.empty(len(vertices), np.int64)
        rank[by_first_use] = np.arange(len(by_first_use))
        uv = vertices[:, 3:5] if vertices.shape[1] >= 5 else np.zeros((len(vertices), 2))
        table = [self.labels[int(i)] for i in mesh.run_original_id]
        place = np.repeat(np.arange(len(table)), np.diff(np.asarray(mesh.run_index, np.int64)) // 3)

        def column(values: list[bool]) -> NDArray[np.bool_]:
            return np.array(values, bool)[place]

        return Surface(
            points=np.ascontiguousarray(vertices[by_first_use, :3]),
            triangles=rank[named].astype(np.int32),
            uv=np.take(uv.astype(np.float32), corners, axis=0),
            origin=np.array([int(label.origin) for label in table], np.uint8)[place],
            fixed=column([label.fixed for label in table]),
            bed=column([label.bed for label in table]),
            grips={n: column([n in label.grips for label in table]) for n in self.grips},
        )


def _split_by_uv(
    points: NDArray[np.float64], triangles: NDArray[np.int64], uv: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.uint64], NDArray[np.uint64]]:
    """One property vertex (x, y, z, u, v) per point and UV; the copies of a point are merged into its first one."""
    flat, uv = triangles.reshape(-1), uv.reshape(-1, 2)
    named = np.full(len(points), -1)
    named[flat[::-1]] = np.arange(len(flat))[::-1]  # the first corner at each point
    used = named >= 0
    # Few points lie on a seam; only theirs are sorted.
    seam = np.zeros(len(points), bool)
    u, v = np.ascontiguousarray(uv.T)
    first_at = named[flat]
    seam[flat[(u != u[first_at]) | (v != v[first_at])]] = True
    on_seam = np.flatnonzero(seam[flat])
    split, which = unique_rows(np.concatenate([flat[on_seam, None].astype(np.float64), uv[on_seam]], axis=1))
    split_owner = split[:, 0].astype(np.int64)
    count = used.astype(np.int64)
    np.add.at(count, split_owner, 1)
    count -= seam
    start = np.cumsum(count) - count
    owner = np.repeat(np.arange(len(points)), count)
    first = start[owner]
    coordinates = uv[named[owner]]
    row = start[split_owner] + np.arange(len(split)) - np.searchsorted(split_owner, split_owner)
    coordinates[row] = split[:, 1:]
    corners = start[flat]
    corners[on_seam] = row[which]
    copies = np.flatnonzero(first != np.arange(len(owner)))
    return (
        np.ascontiguousarray(np.concatenate([points[owner], coordinates], axis=1)),
        corners.reshape(-1, 3),
        copies.astype(np.uint64),
        first[copies].astype(np.uint64),
    )


def closed_solid(points: NDArray[np.float64], triangles: NDArray[np.integer], path: str) -> manifold3d.Manifold:
    """Make a solid of a closed triangle surface.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    path
        Path of the prim, for the message of an error.

    Returns
    -------
    manifold3d.Manifold
        The solid.

    Raises
    ------
    RefusedError
        If the surface is no closed solid.
    """
    if signed_volume(points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    mesh = manifold3d.Mesh64(
        vert_properties=np.array(points, np.float64, order="C"),
        tri_verts=np.array(triangles, np.uint64, order="C"),
    )
    solid = manifold3d.Manifold(mesh)
    if solid.status() != manifold3d.Error.NoError:
        raise refused(ProblemCode.MESH_NOT_SOLID, path, solid.status().name)
    return solid


def solid_surface(solid: manifold3d.Manifold) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Read the triangle surface of a solid.

    Parameters
    ----------
    solid
        The solid.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.int32]]
        Vertices in mm, shape (n, 3), and vertex indices, shape (m, 3).
    """
    mesh = solid.to_mesh64()
    points = np.ascontiguousarray(np.asarray(mesh.vert_properties, np.float64)[:, :3])
    return points, np.asarray(mesh.tri_verts).astype(np.int32).reshape(-1, 3)
