"""The labelled triangle surface of a procedure's tissue, before any cut.

Labels: faces of the subset "bed" are the underside; faces of "fixed" that are not bed are the rim; all others are skin.
Subsets named "underside" and "rim" say so themselves and then decide alone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.patch import UV_SCALE
from lappet.procedure import Tissue
from lappet.program import FaceOrigin, Surface
from lappet.surface_check import SurfaceError, check_closed, check_finite, check_not_self_intersecting, signed_volume

LABELS = ("fixed", "bed", "underside", "rim")  # what these subsets say of their faces; all others are grips


def tissue_surface(tissue: Tissue, prim: str = "/Procedure/Tissue") -> Surface:
    """The tissue as a closed, outward oriented, labelled triangle surface.

    Quads are split along their shorter diagonal, larger polygons by ears. A surface that is closed and consistent but
    turned inside out is turned around. Without UVs the surface gets its two widest coordinates, one
    unit per 100 mm. Raises
    SurfaceError, naming `prim`, for a mesh that is not finite, open, not orientable, not manifold, self-intersecting
    or empty inside.
    """
    points = np.ascontiguousarray(tissue.points, np.float64)
    counts = np.asarray(tissue.face_vertex_counts, np.int64)
    indices = np.asarray(tissue.face_vertex_indices, np.int64)
    check_finite(points, counts, indices, prim)
    triangles, corners, faces = triangulate(points, counts, indices)
    triangles, corners, faces = _without_collapsed(triangles, corners, faces)
    check_closed(points, triangles, prim)
    if signed_volume(points, triangles) < 0.0:
        triangles, corners = triangles[:, ::-1], corners[:, ::-1]
    check_not_self_intersecting(points, triangles, prim)

    masks = {}
    for name, subset in tissue.subsets.items():
        mask = np.zeros(len(counts), bool)
        picked = np.asarray(subset, np.int64)
        if len(picked) and (picked.min() < 0 or picked.max() >= len(counts)):
            raise SurfaceError(
                f'{prim}: the subset "{name}" names face {int(picked.max())}, but the mesh has {len(counts)} faces; '
                "mark the subset's faces again"
            )
        mask[picked] = True
        masks[name] = mask[faces]
    nothing = np.zeros(len(triangles), bool)
    fixed, bed = masks.get("fixed", nothing), masks.get("bed", nothing)
    origin = _origins(masks, len(triangles))
    uv = _plane_uv(points)[triangles] if tissue.uv is None else np.asarray(tissue.uv, np.float32)[corners]
    used, compact = np.unique(triangles, return_inverse=True)
    return Surface(
        points=points[used],
        triangles=compact.reshape(-1, 3).astype(np.int32),
        uv=np.ascontiguousarray(uv, np.float32),
        origin=origin,
        fixed=fixed.copy(),
        bed=bed.copy(),
        grips={name: mask for name, mask in sorted(masks.items()) if name not in LABELS},
    )


def skin_faces(tissue: Tissue) -> NDArray[np.bool_]:
    """Which faces of the tissue, (m,), are outer skin. Raises IndexError for a subset that names a face it lacks."""
    count = len(tissue.face_vertex_counts)
    masks = {}
    for name in LABELS:
        if name in tissue.subsets:
            masks[name] = np.zeros(count, bool)
            masks[name][tissue.subsets[name]] = True
    return _origins(masks, count) == FaceOrigin.SKIN


def _origins(masks: dict[str, NDArray[np.bool_]], count: int) -> NDArray[np.uint8]:
    nothing = np.zeros(count, bool)
    fixed, bed = masks.get("fixed", nothing), masks.get("bed", nothing)
    origin = np.full(count, FaceOrigin.SKIN, np.uint8)
    origin[masks.get("rim", fixed & ~bed if "underside" not in masks else nothing)] = FaceOrigin.RIM
    origin[masks.get("underside", bed)] = FaceOrigin.UNDERSIDE
    return origin


def triangulate(
    points: NDArray[np.float64], counts: NDArray[np.int64], indices: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Polygons (counts (m,), indices (k,)) as triangles: vertices (t, 3), face corners (t, 3) and faces (t,)."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    pieces, owners = [], []
    for size in np.unique(counts):
        faces = np.flatnonzero(counts == size)
        corner = starts[faces][:, None] + np.arange(size)
        if size == 3:
            pieces.append(corner)
            owners.append(faces)
        elif size == 4:
            p = points[indices[corner]]
            other = np.sum((p[:, 1] - p[:, 3]) ** 2, axis=1) < np.sum((p[:, 0] - p[:, 2]) ** 2, axis=1) * (1 - 1e-9)
            split = np.where(other[:, None], [1, 2, 3, 1, 3, 0], [0, 1, 2, 0, 2, 3])
            pieces.append(np.take_along_axis(corner, split, axis=1).reshape(-1, 3))
            owners.append(np.repeat(faces, 2))
        elif size > 4:
            for face, row in zip(faces, corner, strict=True):
                ears = clip_ears(points[indices[row]])
                pieces.append(row[ears])
                owners.append(np.full(len(ears), face))
    if not pieces:
        raise SurfaceError("the mesh has no face of three or more corners; give a closed mesh")
    corners: NDArray[np.int64] = np.vstack(pieces)
    owner: NDArray[np.int64] = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    corners = corners[order]
    return np.asarray(indices[corners], np.int64), corners, owner[order]


def clip_ears(polygon: NDArray[np.float64]) -> NDArray[np.int64]:
    """Triangles (n - 2, 3) of one polygon (n, 3), by ear clipping in the plane of its mean normal."""
    normal = np.cross(polygon, np.roll(polygon, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(normal).argmax())
    keep = [(axis + 1) % 3, (axis + 2) % 3]
    flat = polygon[:, keep] * np.array([1.0, 1.0 if normal[axis] >= 0 else -1.0])

    def turn(a: int, b: int, c: int) -> float:
        u, v = flat[b] - flat[a], flat[c] - flat[a]
        return float(u[0] * v[1] - u[1] * v[0])

    ring = list(range(len(polygon)))
    ears = []
    while len(ring) > 3:
        best, best_value = 0, -np.inf
        for k in range(len(ring)):
            a, b, c = ring[k - 1], ring[k], ring[(k + 1) % len(ring)]
            value = turn(a, b, c)
            blocked = value <= 0 or any(
                turn(a, b, q) >= 0 and turn(b, c, q) >= 0 and turn(c, a, q) >= 0 for q in ring if q not in (a, b, c)
            )
            sides = sum(float(np.sum((flat[i] - flat[j]) ** 2)) for i, j in ((a, b), (b, c), (c, a)))
            quality = value / max(sides, 1e-300) - (10.0 if blocked else 0.0)
            if quality > best_value:
                best, best_value = k, quality
        ears.append([ring[best - 1], ring[best], ring[(best + 1) % len(ring)]])
        del ring[best]
    return np.array([*ears, ring], np.int64)


def _without_collapsed(
    triangles: NDArray[np.int64], corners: NDArray[np.int64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Drops triangles that name a vertex twice: they are edges and no faces."""
    a, b, c = triangles.T
    keep = (a != b) & (b != c) & (c != a)
    return triangles[keep], corners[keep], faces[keep]


def _plane_uv(points: NDArray[np.float64]) -> NDArray[np.float32]:
    """The coordinates (n, 2) along the two widest axes from the bounding box's minimum, 1 unit per 100 mm."""
    extent = np.ptp(points, axis=0)
    axes = np.sort(np.argsort(-extent, kind="stable")[:2])
    return (UV_SCALE * (points - points.min(axis=0))[:, axes]).astype(np.float32)
