"""An open surface of polygons as a closed sheet: its faces, its texture, what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import signed_volume
from lappet.tissue.sheet_tissue import sheet_tissue
from lappet.tissue.surface import tissue_surface
from refusals import refuses

THICKNESS = 3.0


def cap(radius: float, rings: int = 8, around: int = 24) -> tuple[NDArray, NDArray, NDArray]:
    """A spherical cap of 60° half opening, triangles at its pole and quadrilaterals around: points, counts, indices."""
    angle = np.radians(60.0) * np.arange(1, rings + 1) / rings
    turn = 2.0 * np.pi * np.arange(around) / around
    ring = [
        np.stack([np.sin(a) * np.cos(turn), np.sin(a) * np.sin(turn), np.full(around, np.cos(a))], 1) for a in angle
    ]
    points = radius * np.concatenate([[[0.0, 0.0, 1.0]], *ring])
    k = np.arange(around)
    following = (k + 1) % around
    faces = [np.stack([np.zeros(around, int), 1 + k, 1 + following], 1).reshape(-1)]
    for r in range(rings - 1):
        low, high = 1 + r * around, 1 + (r + 1) * around
        faces.append(np.stack([low + k, high + k, high + following, low + following], 1).reshape(-1))
    counts = np.concatenate([np.full(around, 3), np.full(around * (rings - 1), 4)])
    return points, counts, np.concatenate(faces)


def test_the_sheet_below_a_spherical_cap_has_the_volume_of_the_shell() -> None:
    tissue = sheet_tissue(*cap(40.0, 24, 96), THICKNESS)
    surface = tissue_surface(tissue)
    shell = 2.0 * np.pi / 3.0 * (1.0 - np.cos(np.radians(60.0))) * (40.0**3 - 37.0**3)
    assert signed_volume(surface.points, surface.triangles) == pytest.approx(shell, rel=0.01)


def test_skin_comes_first_the_underside_turned_in_the_same_order_then_the_rim() -> None:
    points, counts, indices = cap(40.0)
    tissue = sheet_tissue(points, counts, indices, THICKNESS)
    m, k, n = len(counts), len(indices), len(points)
    np.testing.assert_array_equal(tissue.face_vertex_counts[: 2 * m], [*counts, *counts])
    np.testing.assert_array_equal(tissue.face_vertex_indices[:k], indices)
    starts = np.cumsum(counts) - counts
    for face in (0, 30, m - 1):
        corners = indices[starts[face] : starts[face] + counts[face]]
        below = tissue.face_vertex_indices[k + starts[face] : k + starts[face] + counts[face]]
        np.testing.assert_array_equal(below, corners[::-1] + n)
    assert (tissue.face_vertex_counts[2 * m :] == 4).all()
    assert tissue.subsets["fixed"].tolist() == list(range(2 * m, len(tissue.face_vertex_counts)))


@pytest.mark.parametrize("hand", [1.0, -1.0])
def test_the_texture_goes_on_outwards_over_the_rim_at_its_own_scale_also_where_it_is_mirrored(hand: float) -> None:
    points, counts, indices = cap(40.0)
    flat = 0.02 * points[:, :2] * (hand, 1.0)
    tissue = sheet_tissue(points, counts, indices, THICKNESS, flat[indices].astype(np.float32))
    rim = tissue.subsets["fixed"]
    uv = tissue.uv[4 * (len(tissue.face_vertex_counts) - len(rim)) - 2 * 24 :]
    border = 0.02 * 40.0 * np.sin(np.radians(60.0))
    assert np.linalg.norm(uv, axis=1).min() == pytest.approx(border, rel=1e-5)
    # A row of the rim begins on the skin and ends at the underside, a thickness further out.
    assert np.linalg.norm(uv, axis=1).max() == pytest.approx(border + 0.02 * THICKNESS, rel=0.01)


def test_points_without_a_face_are_left_out() -> None:
    points, counts, indices = cap(40.0)
    with_loose = np.concatenate([[[0.0, 0.0, 99.0]], points, [[1.0, 2.0, 3.0]]])
    assert sheet_tissue(with_loose, counts, indices + 1, THICKNESS) == sheet_tissue(points, counts, indices, THICKNESS)


def test_faces_that_look_opposite_ways_are_refused_with_the_place() -> None:
    points, counts, indices = cap(40.0)
    indices = indices.copy()
    indices[72:76] = indices[72:76][::-1]
    with refuses(ProblemCode.MESH_NOT_ORIENTED, "skin") as problems:
        sheet_tissue(points, counts, indices, THICKNESS, name="skin")
    assert problems[0].place is not None
    assert problems[0].place.faces
    assert problems[0].place.points
