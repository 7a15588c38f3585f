"""A scalp on a skull, simplified: a cap of a spherical shell of tissue over a cap of bone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Bone, Tissue
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.placement import Place


def dome_scalp(
    radius: float = 80.0,
    reach: float = 60.0,
    thickness: float = 5.0,
    resolution: float = 2.0,
    material: str = "skin",
    spacing: float = 1.0,
    bed_stiffness: float = Tissue.bed_stiffness,
    bed_shear: float = Tissue.bed_shear,
) -> Tissue:
    """Make a cap of a spherical shell of tissue about the origin, its pole at (0, 0, radius).

    The texture is 1 unit per 100 mm, laid out from the pole (true distances from it), the rim continuing the skin. The
    rim, a cone towards the origin, is the subset "fixed", the underside the subset "bed".

    Parameters
    ----------
    radius
        Radius of the skin in mm.
    reach
        Distance from the pole to the rim along the skin in mm.
    thickness
        Depth of the underside below the skin in mm.
    resolution
        Length of the triangles' edges in mm.
    material
        Name of the tissue's material.
    spacing
        Edge of the lattice's cells in mm.
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
    RefusedError
        If the lengths make no cap.
    """
    half = _half_angle("dome_scalp", radius, reach, thickness, resolution)
    directions, triangles, border = _cap(half, max(2, round(reach / resolution)))
    rows = max(1, round(thickness / resolution))
    count = len(directions)
    flat = radius * _layout(directions)
    outwards = flat[border] / np.linalg.norm(flat[border], axis=1, keepdims=True)
    # Skin, underside, then the rows of the rim between them.
    levels = np.arange(1, rows) / rows
    rings = [(radius - level * thickness) * directions[border] for level in levels]
    points = np.vstack([radius * directions, (radius - thickness) * directions, *rings])
    row = [border, *(2 * count + k * len(border) + np.arange(len(border)) for k in range(rows - 1)), border + count]
    rim, rim_uv = [], []
    for k in range(rows):
        top, low = row[k], row[k + 1]
        rim.append(np.stack([top, low, np.roll(low, -1), np.roll(top, -1)], axis=1))
        at = [flat[border] + thickness * j / rows * outwards for j in (k, k + 1)]
        rim_uv.append(np.stack([at[0], at[1], np.roll(at[1], -1, axis=0), np.roll(at[0], -1, axis=0)], axis=1))
    skin_uv = flat[triangles]
    sides = len(triangles), len(triangles) + len(triangles)
    quads = np.concatenate(rim)
    uv = np.vstack([skin_uv.reshape(-1, 2), skin_uv[:, ::-1].reshape(-1, 2), np.concatenate(rim_uv).reshape(-1, 2)])
    return Tissue(
        points=np.round(points, 4),
        face_vertex_counts=np.concatenate([np.full(sides[1], 3, np.int32), np.full(len(quads), 4, np.int32)]),
        face_vertex_indices=np.concatenate(
            [triangles.ravel(), (triangles[:, ::-1] + count).ravel(), quads.ravel()]
        ).astype(np.int32),
        uv=np.round(UV_SCALE * uv, 5).astype(np.float32),
        subsets={
            "fixed": np.arange(sides[1], sides[1] + len(quads), dtype=np.int32),
            "bed": np.arange(*sides, dtype=np.int32),
        },
        material=material,
        spacing=spacing,
        bed_stiffness=bed_stiffness,
        bed_shear=bed_shear,
    )


def dome_bone(
    radius: float, reach: float, thickness: float = 6.0, resolution: float = 4.0, name: str = "skull"
) -> Bone:
    """Make a cap of bone about the origin.

    Parameters
    ----------
    radius
        Radius of its outer face in mm.
    reach
        Distance from the pole to its border along the outer face in mm.
    thickness
        Thickness in mm.
    resolution
        Length of the triangles' edges in mm.
    name
        Name of the bone.

    Returns
    -------
    Bone
        The bone.

    Raises
    ------
    RefusedError
        If the lengths make no cap.
    """
    half = _half_angle("dome_bone", radius, reach, thickness, resolution)
    directions, triangles, border = _cap(half, max(2, round(reach / resolution)))
    count = len(directions)
    rim = np.stack([border, border + count, np.roll(border, -1) + count, np.roll(border, -1)], axis=1)
    return Bone(
        name=name,
        points=np.asarray(np.round(np.vstack([radius * directions, (radius - thickness) * directions]), 4), np.float64),
        face_vertex_counts=np.concatenate([np.full(2 * len(triangles), 3, np.int32), np.full(len(rim), 4, np.int32)]),
        face_vertex_indices=np.concatenate(
            [triangles.ravel(), (triangles[:, ::-1] + count).ravel(), rim.ravel()]
        ).astype(np.int32),
    )


def draped(radius: float) -> Place:
    """Make a `project` for designs drawn in the plane z = radius: onto the sphere, distances from the pole kept.

    Parameters
    ----------
    radius
        Radius of the sphere in mm.

    Returns
    -------
    Place
        A function from points of the plane, shape (k, 3), to points on the sphere, shape (k, 3), in mm.
    """

    def drape(points: NDArray[np.float64]) -> NDArray[np.float64]:
        away = np.linalg.norm(points[:, :2], axis=1)
        polar = away / radius
        aside = points[:, :2] * (radius * np.sin(polar) / np.maximum(away, 1e-300))[:, None]
        return np.column_stack([aside, radius * np.cos(polar)])

    return drape


def _half_angle(what: str, radius: float, reach: float, thickness: float, resolution: float) -> float:
    lengths = {"radius": radius, "reach": reach, "thickness": thickness, "resolution": resolution}
    for name, value in lengths.items():
        if not (np.isfinite(value) and value > 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, what, f"{value:g}", name=name)
    if thickness >= radius or reach > 0.5 * np.pi * radius:
        raise refused(ProblemCode.DOME_NO_CAP, what, radius=radius, thickness=thickness, reach=reach)
    return reach / radius


def _cap(half: float, rings: int) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Directions (n, 3) up to the polar angle `half`, triangles (m, 3) facing outwards, and the border's vertices.

    Ring i has 6 i vertices, so that all triangles are nearly equilateral.
    """
    directions = [np.array([[0.0, 0.0, 1.0]])]
    triangles = []
    start = [0]
    for i in range(1, rings + 1):
        start.append(start[-1] + max(6 * (i - 1), 1))
        polar, turn = half * i / rings, 2.0 * np.pi * np.arange(6 * i) / (6 * i)
        aside = np.sin(polar)
        directions.append(np.column_stack([aside * np.cos(turn), aside * np.sin(turn), np.full(6 * i, np.cos(polar))]))
        inner = max(6 * (i - 1), 1)
        for sextant in range(6):
            for k in range(i):
                a, b = sextant * i + k, (sextant * i + k + 1) % (6 * i)
                c = (sextant * (i - 1) + k) % inner
                triangles.append((start[i] + a, start[i] + b, start[i - 1] + c))
                if k < i - 1:
                    d = (sextant * (i - 1) + k + 1) % inner
                    triangles.append((start[i] + b, start[i - 1] + d, start[i - 1] + c))
    border = start[rings] + np.arange(6 * rings)
    return np.vstack(directions).astype(np.float64), np.array(triangles, np.int64), border


def _layout(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Flat coordinates (n, 2) of directions, in radians from the pole."""
    aside = np.linalg.norm(directions[:, :2], axis=1)
    polar = np.arctan2(aside, directions[:, 2])
    return np.asarray(directions[:, :2] * (polar / np.maximum(aside, 1e-300))[:, None])
