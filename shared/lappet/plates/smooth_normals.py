"""The normals of a drawn surface without what is smaller than a length: facets throw no bands of light."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import splu

from lappet.plates.drawn_surface import DrawnSurface

_STEEPEST = 10.0  # cotangents of slivers are taken for no more


def smooth_normals(surface: DrawnSurface, length: float) -> NDArray[np.float64]:
    """Let the normals diffuse along the surface, not across the borders between faces of different origin.

    A wave of wavelength λ keeps 1 / (1 + (2π length / λ)²) of its height: one step of implicit diffusion with the
    cotangent Laplacian (Desbrun et al. 1999, *Implicit Fairing*), without its negative weights.

    Parameters
    ----------
    surface
        The surface.
    length
        What is smaller is smoothed away, in mm; zero or more.

    Returns
    -------
    NDArray[np.float64]
        Unit normals of the corners, shape (m, 3, 3).
    """
    corners = surface.points[surface.triangles]
    double_area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    # A vertex is one for each origin of the faces around it, as in the normals of the surface.
    keys = surface.triangles + surface.origin[:, None] * len(surface.points)
    used, first, inverse = np.unique(keys.ravel(), return_index=True, return_inverse=True)
    place = inverse.reshape(-1, 3)
    mass = np.bincount(inverse, np.repeat(double_area / 6.0, 3), len(used)) + 1e-12
    weights = []
    for k in range(3):
        one, other = corners[:, k] - corners[:, k - 1], corners[:, (k + 1) % 3] - corners[:, k - 1]
        cotangent = np.einsum("mi,mi->m", one, other) / np.maximum(double_area, 1e-12)
        weights.append(0.5 * np.clip(cotangent, 0.0, _STEEPEST))
    ends = np.concatenate([place[:, [k, (k + 1) % 3]] for k in range(3)])
    one_way = coo_matrix((np.concatenate(weights), (ends[:, 0], ends[:, 1])), shape=(len(used), len(used)))
    coupling = (one_way + one_way.T).tocsr()
    laplacian = diags(np.asarray(coupling.sum(axis=1)).ravel()) - coupling
    before = surface.normals.reshape(-1, 3)[first]
    diffused = splu((diags(mass) + length**2 * laplacian).tocsc()).solve(mass[:, None] * before)
    lengths = np.linalg.norm(diffused, axis=1, keepdims=True)
    unit = np.where(lengths > 1e-9, diffused / np.maximum(lengths, 1e-9), before)
    normals: NDArray[np.float64] = unit[place]
    return normals
