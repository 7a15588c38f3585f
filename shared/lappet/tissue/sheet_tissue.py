"""Make tissue of an open surface of polygons that keeps its faces, their groups and its texture coordinates, if any."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.flatten import flatten
from lappet.geometry.mesh_faults import EDGES, refuse_faults, refuse_unreadable
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.thicken import Sheet, rim_rows, thicken


def sheet_tissue(
    points: NDArray[np.float64],
    counts: NDArray[np.integer],
    indices: NDArray[np.integer],
    thickness: float,
    uv: NDArray[np.float32] | None = None,
    subsets: Mapping[str, NDArray[np.integer]] | None = None,
    name: str = "tissue",
) -> Tissue:
    """Make a closed sheet below an open surface of polygons; its first faces are those of the surface, in order.

    The rim joins the subset "fixed", the underside "bed"; where the surface has faces in one of these itself, the
    subsets "rim" and "underside" say which faces are no skin.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    counts
        Corners of each polygon, shape (m,).
    indices
        Vertices of the polygons, oriented outwards, shape (k,).
    thickness
        Thickness of the sheet in mm.
    uv
        Texture coordinates of the corners, shape (k, 2), which the underside shares and the rim continues outwards at
        the same scale; None: the surface is laid out flat, at 1 unit per 100 mm.
    subsets
        Face indices by name.
    name
        What messages call the tissue.

    Returns
    -------
    Tissue
        The tissue.

    Raises
    ------
    RefusedError
        If the surface is not manifold or not oriented alike, or no sheet can be made; names the place.
    """
    sizes = np.asarray(counts, np.int64)
    refuse_unreadable(name, points, sizes, indices)
    used, compact = np.unique(indices, return_inverse=True)
    points, corners = points[used], compact.reshape(-1).astype(np.int64)
    triangles = triangulate(points, sizes, corners)[0]
    refuse_faults(name, points, triangles, EDGES)
    sheet = thicken(points, triangles, thickness, rim_rows(points, triangles, thickness), name)

    back = _reversed_corners(sizes)
    quads = sheet.rim_quads
    faces = len(sizes)
    rim = np.arange(2 * faces, 2 * faces + len(quads))
    underside = np.arange(faces, 2 * faces)
    if uv is None:
        uv = (UV_SCALE * flatten(points, triangles))[corners].astype(np.float32)
    corner_uv = np.concatenate([uv, uv[back], _rim_uv(sheet, points, sizes, corners, uv, thickness)])
    return Tissue(
        points=sheet.points.astype(np.float32).astype(np.float64),
        face_vertex_counts=np.concatenate([sizes, sizes, np.full(len(quads), 4)]).astype(np.int32),
        face_vertex_indices=np.concatenate([corners, corners[back] + len(points), quads.reshape(-1)]).astype(np.int32),
        uv=corner_uv,
        subsets=_subsets(subsets or {}, rim, underside),
    )


def _subsets(
    given: Mapping[str, NDArray[np.integer]], rim: NDArray[np.integer], underside: NDArray[np.integer]
) -> dict[str, NDArray[np.int32]]:
    held = any(len(given.get(name, ())) for name in ("fixed", "bed"))
    added = {"fixed": rim, "bed": underside, **({"rim": rim, "underside": underside} if held else {})}
    nothing = np.zeros(0, np.int32)
    names = [*given, *(name for name in added if name not in given)]
    return {
        name: np.concatenate([given.get(name, nothing), added.get(name, nothing)]).astype(np.int32) for name in names
    }


def _reversed_corners(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each corner of the faces turned around the corner that it was."""
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    within = np.arange(int(counts.sum())) - starts
    return np.asarray(starts + np.repeat(counts, counts) - 1 - within)


def _rim_uv(
    sheet: Sheet,
    points: NDArray[np.float64],
    counts: NDArray[np.int64],
    indices: NDArray[np.int64],
    uv: NDArray[np.float32],
    thickness: float,
) -> NDArray[np.float32]:
    """Texture coordinates (4q, 2) of the rim: the skin's, continued outwards square to the border."""
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    within = np.arange(len(indices)) - starts
    following = starts + (within + 1) % np.repeat(counts, counts)
    size = len(points)
    key = indices * size + indices[following]
    order = np.argsort(key)

    tops = sheet.top[sheet.rim_quads]  # b, a, a, b
    a, b = tops[:, 1], tops[:, 0]
    first = order[np.searchsorted(key[order], a * size + b)]
    second = following[first]
    flat = uv.astype(np.float64)
    along = flat[second] - flat[first]
    # A layout that mirrors the skin has its outside on the other hand.
    third = following[second]
    side = flat[third] - flat[first]
    hand = np.where(along[:, 0] * side[:, 1] - along[:, 1] * side[:, 0] < 0.0, -1.0, 1.0)
    aside = np.zeros((size, 2))
    across = hand[:, None] * np.stack([along[:, 1], -along[:, 0]], axis=1)
    np.add.at(aside, a, across)
    np.add.at(aside, b, across)
    aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-300)
    length = np.linalg.norm(points[b] - points[a], axis=1)
    scale = float(np.median(np.linalg.norm(along, axis=1) / np.maximum(length, 1e-300)))
    base = np.stack([flat[second], flat[first], flat[first], flat[second]], axis=1)
    level = sheet.rim_level[sheet.rim_quads][:, :, None]
    return (base + scale * thickness * level * aside[tops]).reshape(-1, 2).astype(np.float32)
