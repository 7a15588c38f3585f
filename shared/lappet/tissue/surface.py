"""The labeled triangle surface of a procedure's tissue, before any cut.

Labels: faces of the subset "bed" are the underside; faces of "fixed" that are not bed are the rim; all others are skin.
Subsets named "underside" and "rim" say so themselves and then decide alone.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.mesh_faults import SOLID, refuse_faults, refuse_unreadable
from lappet.geometry.surface_check import signed_volume
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue
from lappet.tissue.patch import UV_SCALE

LABELS = ("fixed", "bed", "underside", "rim")  # what these subsets say of their faces; all others are grips

_known: WeakKeyDictionary[Tissue, Surface] = WeakKeyDictionary()  # finding no fault takes longer than all else


def tissue_surface(tissue: Tissue, prim: str = "/Procedure/Tissue") -> Surface:
    """Make the closed, outward oriented, labeled triangle surface of a tissue.

    Quads are split along their shorter diagonal, larger polygons by ears. A surface that is closed and consistent but
    turned inside out is turned around. Without UVs the surface gets its two widest coordinates, one unit per 100 mm.
    It is made once for a tissue, as long as that lives.

    Parameters
    ----------
    tissue
        The tissue.
    prim
        Path of its prim, for messages.

    Returns
    -------
    Surface
        The surface.

    Raises
    ------
    RefusedError
        If the mesh is not finite, open, not orientable, not manifold, self-intersecting or empty inside, or a subset
        names a face that it lacks.
    """
    if tissue not in _known:
        _known[tissue] = _made(tissue, prim)
    return _known[tissue]


def _made(tissue: Tissue, prim: str) -> Surface:
    points = np.ascontiguousarray(tissue.points, np.float64)
    counts = np.asarray(tissue.face_vertex_counts, np.int64)
    indices = np.asarray(tissue.face_vertex_indices, np.int64)
    refuse_unreadable(prim, points, counts, indices)
    triangles, corners, faces = triangulate(points, counts, indices)
    triangles, corners, faces = _without_collapsed(triangles, corners, faces)
    refuse_faults(prim, points, triangles, SOLID)
    if signed_volume(points, triangles) < 0.0:
        triangles, corners = triangles[:, ::-1], corners[:, ::-1]

    masks = {}
    for name, subset in tissue.subsets.items():
        mask = np.zeros(len(counts), bool)
        picked = np.asarray(subset, np.int64)
        if len(picked) and (picked.min() < 0 or picked.max() >= len(counts)):
            raise refused(
                ProblemCode.SUBSET_INDEX_RANGE, f"{prim}/{name}", int(picked.max()), name=name, faces=len(counts)
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
    """Find the faces of a tissue that are outer skin.

    Parameters
    ----------
    tissue
        The tissue.

    Returns
    -------
    NDArray[np.bool_]
        Which faces are, shape (m,).

    Raises
    ------
    IndexError
        If a subset names a face that the tissue lacks.
    """
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


def _without_collapsed(
    triangles: NDArray[np.int64], corners: NDArray[np.int64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Drop triangles that name a vertex twice: they are edges and no faces."""
    a, b, c = triangles.T
    keep = (a != b) & (b != c) & (c != a)
    return triangles[keep], corners[keep], faces[keep]


def _plane_uv(points: NDArray[np.float64]) -> NDArray[np.float32]:
    """The coordinates (n, 2) along the two widest axes from the bounding box's minimum, 1 unit per 100 mm."""
    extent = np.ptp(points, axis=0)
    axes = np.sort(np.argsort(-extent, kind="stable")[:2])
    return (UV_SCALE * (points - points.min(axis=0))[:, axes]).astype(np.float32)
