"""Measures of surfaces, for tests: closedness, areas, volumes, caps to cut."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import Surface
from lappet.procedure import Tissue


def assert_closed(surface: Surface) -> None:
    """Every directed edge occurs once and its opposite once; the surface faces outwards."""
    t = surface.triangles.astype(np.int64)
    edges = np.vstack([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
    key = edges[:, 0] * len(surface.points) + edges[:, 1]
    back = edges[:, 1] * len(surface.points) + edges[:, 0]
    assert len(np.unique(key)) == len(key)
    assert np.array_equal(np.sort(key), np.sort(back))
    assert volume(surface) > 0.0
    assert np.array_equal(np.unique(t), np.arange(len(surface.points)))


def areas(surface: Surface) -> NDArray[np.float64]:
    """The area of each triangle."""
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def volume(surface: Surface) -> float:
    """The enclosed volume."""
    a, b, c = (surface.points[surface.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def euler_number(surface: Surface) -> int:
    """Vertices - edges + faces: 2 for a ball, 0 for a ring."""
    return len(surface.points) - 3 * len(surface.triangles) // 2 + len(surface.triangles)


def heights(surface: Surface) -> NDArray[np.float64]:
    """The height of each triangle over its longest edge."""
    corners = surface.points[surface.triangles]
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    return np.asarray(2.0 * areas(surface) / longest)


def spherical_cap(radius: float = 60.0, thickness: float = 4.0, half_angle: float = 40.0, rings: int = 16) -> Tissue:
    """A cap of a spherical shell around the z axis: skin outside, bed inside, fixed conical rim."""
    points, faces, fixed, bed = [], [], [], []
    columns = 4 * rings
    for r in (radius, radius - thickness):
        points.append((0.0, 0.0, r))
        for i in range(1, rings + 1):
            polar = np.radians(half_angle) * i / rings
            for j in range(columns):
                turn = 2.0 * np.pi * j / columns
                points.append((r * np.sin(polar) * np.cos(turn), r * np.sin(polar) * np.sin(turn), r * np.cos(polar)))
    half = 1 + rings * columns

    def vertex(i: int, j: int) -> int:
        return 0 if i == 0 else 1 + (i - 1) * columns + j % columns

    for i in range(rings):
        for j in range(columns):
            face = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]
            faces.append(face[:3] if i == 0 else face)
            bed.append(len(faces))
            faces.append([v + half for v in reversed(faces[-1])])
    for j in range(columns):
        a, b = vertex(rings, j), vertex(rings, j + 1)
        fixed.append(len(faces))
        faces.append([a, a + half, b + half, b])
    return Tissue(
        points=np.array(points),
        face_vertex_counts=np.array([len(f) for f in faces], np.int32),
        face_vertex_indices=np.concatenate(faces).astype(np.int32),
        subsets={"fixed": np.array(fixed, np.int32), "bed": np.array(bed, np.int32)},
    )
