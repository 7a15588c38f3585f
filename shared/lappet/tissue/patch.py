"""A flat patch of skin: the simplest tissue, a closed sheet with its rim fixed and its underside on a bed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Tissue

UV_SCALE = 0.01  # texture units per mm
# Each side: the axis it stands on, at which end, and the two running axes in the order that turns the normal outwards.
SIDES = ((2, 1, 0, 1), (2, 0, 1, 0), (0, 1, 1, 2), (0, 0, 2, 1), (1, 1, 2, 0), (1, 0, 0, 2))


def flat_patch(
    size: tuple[float, float, float] = (100.0, 80.0, 4.0),
    resolution: float = 2.0,
    center: tuple[float, float] = (0.0, 0.0),
    triangles: bool = False,
    material: str = "skin",
    spacing: float = 1.0,
    gravity: float = Tissue.gravity,
    bed_stiffness: float = Tissue.bed_stiffness,
    bed_shear: float = Tissue.bed_shear,
) -> Tissue:
    """Make a closed flat sheet, its skin at z = thickness and its underside at z = 0.

    The texture is 1 unit per 100 mm over the unfolded sheet: (0, 0) mm maps to (0, 0) on the skin, and the sides
    continue it. The four sides are the subset "fixed", the underside is the subset "bed".

    Parameters
    ----------
    size
        Extent in x and y and the thickness in mm.
    resolution
        Edge of the quadrilaterals in mm; a side that is no multiple of it is divided into the nearest number of equal
        parts.
    center
        Middle of the sheet, x and y in mm.
    triangles
        Whether the quadrilaterals are split.
    material
        Name of the tissue's material.
    spacing
        Edge of the lattice's cells in mm.
    gravity
        Gravity along -z in m/s², 0 for none.
    bed_stiffness
        Stiffness of the bed along its normal in kPa/mm.
    bed_shear
        Stiffness of the bed in its plane in kPa/mm.

    Returns
    -------
    Tissue
        The tissue.

    Raises
    ------
    ValueError
        If the size or the resolution is not positive.

    Examples
    --------
    >>> from lappet.tissue import flat_patch
    >>> sheet = flat_patch((40.0, 30.0, 4.0), resolution=5.0, spacing=2.0)
    >>> len(sheet.points), sorted(sheet.subsets)
    (126, ['bed', 'fixed'])
    """
    if not all(math.isfinite(v) and v > 0.0 for v in (*size, resolution)):
        raise refused(ProblemCode.PATCH_SIZE, "patch", size, resolution=resolution)
    parts = [max(1, round(length / resolution)) for length in size]
    axes = [np.linspace(0.0, length, n + 1) for length, n in zip(size, parts, strict=True)]
    axes[0] += center[0] - size[0] / 2
    axes[1] += center[1] - size[1] / 2
    place, texture, side = _sides(parts, axes)
    key = np.ravel_multi_index(tuple(place.reshape(-1, 3).T), tuple(n + 1 for n in parts))
    used, inverse = np.unique(key, return_inverse=True)
    lattice = np.unravel_index(used, tuple(n + 1 for n in parts))
    points = np.stack([axes[k][lattice[k]] for k in range(3)], axis=1)
    faces = inverse.reshape(-1, 4)
    if triangles:
        split = [0, 1, 2, 0, 2, 3]
        faces, texture, side = faces[:, split].reshape(-1, 3), texture[:, split].reshape(-1, 3, 2), np.repeat(side, 2)
    return Tissue(
        points=points,
        face_vertex_counts=np.full(len(faces), faces.shape[1], np.int32),
        face_vertex_indices=faces.reshape(-1).astype(np.int32),
        uv=texture.reshape(-1, 2).astype(np.float32),
        subsets={
            "fixed": np.flatnonzero(side < 4).astype(np.int32),
            "bed": np.flatnonzero(side == 4).astype(np.int32),
        },
        material=material,
        spacing=spacing,
        gravity=gravity,
        bed_stiffness=bed_stiffness,
        bed_shear=bed_shear,
    )


def _sides(
    parts: Sequence[int], axes: Sequence[NDArray[np.float64]]
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
    """The quadrilaterals of the sides: corners in the grid (n, 4, 3), texture (n, 4, 2), the number of the side (n,).

    A side's number is twice the axis that it stands on, and 1 more at that axis's end.
    """
    thickness = axes[2][-1]
    corners, uv, sides = [], [], []
    for axis, end, first, second in SIDES:
        quads = _quads(parts[first], parts[second])
        place = np.zeros((*quads.shape[:2], 3), np.int64)
        place[..., axis] = parts[axis] * end
        place[..., first], place[..., second] = quads[..., 0], quads[..., 1]
        corners.append(place)
        at = np.stack([axes[k][place[..., k]] for k in range(3)], axis=-1)
        flat = at[..., :2].copy()
        if axis < 2:
            flat[..., axis] += (1 if end else -1) * (thickness - at[..., 2])
        uv.append(flat * UV_SCALE)
        sides.append(np.full(len(place), axis * 2 + end))
    return np.concatenate(corners), np.concatenate(uv), np.concatenate(sides)


def _quads(columns: int, rows: int) -> NDArray[np.int64]:
    """The corners (faces, 4, 2) of a grid of quadrilaterals, counter-clockwise."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    ring = [(0, 0), (1, 0), (1, 1), (0, 1)]
    return np.stack([np.stack([i + di, j + dj], axis=-1) for di, dj in ring], axis=1)
