"""The tension of the skin by region: near the scar, and in each face subset of the skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.triangulation import triangulate
from lappet.procedure import Tissue
from lappet.tissue.surface import LABELS, skin_faces
from lappet.usd.cache_end import CacheEnd, SkinEnd

AT_SCAR = "within 10 mm of the scar"
_NEAR = 10.0  # mm


def skin_regions(end: CacheEnd) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Divide the skin of the last frame into regions; these may overlap.

    Parameters
    ----------
    end
        The last frame of a cache.

    Returns
    -------
    dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]
        By the name of each face subset of the skin, and `AT_SCAR`, the mean tension in kPa and the area in mm² of its
        triangles, each of shape (t,); nothing where the cache has no tension.
    """
    skin = end.skin
    if skin is None or not len(skin.triangles):
        return {}
    tension, area = skin.tension[skin.triangles].mean(axis=1), skin.areas()
    inside = _subsets(skin, end.procedure.tissue)
    seams = [line for line in end.seams.values() if len(line) > 1]
    if seams:
        first = np.concatenate([np.arange(len(line) - 1) + sum(map(len, seams[:k])) for k, line in enumerate(seams)])
        near = ClosestPoint(np.vstack(seams), np.stack([first, first + 1, first + 1], axis=1))
        inside[AT_SCAR] = near.query(skin.points[skin.triangles].mean(axis=1))[2] <= _NEAR
    return {name: (tension[mask], area[mask]) for name, mask in inside.items() if mask.any()}


def _subsets(skin: SkinEnd, tissue: Tissue) -> dict[str, NDArray[np.bool_]]:
    """Which triangles of the skin lie, at rest, in each face subset."""
    outer = skin_faces(tissue)
    names = [name for name, faces in tissue.subsets.items() if name not in LABELS and outer[faces].any()]
    if not names:
        return {}
    counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
    triangles, _, faces = triangulate(tissue.points, counts, indices)
    on_skin = outer[faces]
    nearest = ClosestPoint(tissue.points, triangles[on_skin]).query(skin.rest[skin.triangles].mean(axis=1))[0]
    face = faces[on_skin][nearest]
    return {name: np.isin(face, tissue.subsets[name]) for name in names}
