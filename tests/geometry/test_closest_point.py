"""`lappet.geometry.closest_point` against trimesh's own search and against cases with known answers."""

from __future__ import annotations

import time

import numpy as np
import pytest
import trimesh

from lappet.geometry.closest_point import ClosestPoint, closest_points
from lappet.geometry.remembered_closest_point import remembered_closest_point


def test_closest_points_agree_with_trimesh_on_a_bumpy_sphere() -> None:
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=10.0)
    generator = np.random.default_rng(1)
    vertices = np.asarray(mesh.vertices) * (1.0 + 0.1 * generator.random((len(mesh.vertices), 1)))
    queries = generator.normal(0.0, 8.0, (60, 3))
    triangle, point, distance = closest_points(queries, vertices, mesh.faces)
    corners = vertices[mesh.faces]
    for i, query in enumerate(queries):
        candidates = trimesh.triangles.closest_point(corners, np.repeat(query[None], len(corners), axis=0))
        expected = np.linalg.norm(candidates - query, axis=1)
        assert distance[i] == pytest.approx(expected.min(), abs=1e-12)
        assert expected[triangle[i]] == pytest.approx(expected.min(), abs=1e-12)
        assert np.linalg.norm(point[i] - query) == pytest.approx(distance[i], abs=1e-12)


def test_face_edge_and_corner_answers_are_exact() -> None:
    square = np.array([[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], float)
    triangles = [[0, 1, 2], [0, 2, 3]]
    index, point, distance = closest_points([[3, 1, 2], [2, -3, 0], [6, 6, 1], [1, 3, -0.5]], square, triangles)
    assert index.tolist() == [0, 0, 0, 1]
    assert point.tolist() == [[3, 1, 0], [2, 0, 0], [4, 4, 0], [1, 3, 0]]
    assert distance.tolist() == [2.0, 3.0, 3.0, 0.5]


def test_degenerate_triangles_count_as_segments_and_points() -> None:
    points = [[0, 0, 0], [2, 0, 0], [4, 0, 0], [9, 9, 9]]
    index, point, distance = closest_points([[3, 1, 0], [9, 9, 8]], points, [[0, 1, 2], [3, 3, 3]])
    assert index.tolist() == [0, 1]
    assert point.tolist() == [[3, 0, 0], [9, 9, 9]]
    assert distance.tolist() == [1.0, 1.0]


def test_a_point_that_is_not_finite_has_no_closest_triangle() -> None:
    index, _, distance = closest_points([[np.nan, 0, 0]], np.eye(3), [[0, 1, 2]])
    assert index.tolist() == [-1]
    assert np.isnan(distance).all()


def test_a_surface_without_triangles_is_refused() -> None:
    with pytest.raises(ValueError, match="at least one triangle"):
        ClosestPoint(np.eye(3), np.zeros((0, 3), int))


def test_a_hundred_points_on_a_hundred_thousand_triangles_take_less_than_two_seconds() -> None:
    n = 224
    x, y = np.meshgrid(np.linspace(0, 100, n), np.linspace(0, 100, n), indexing="ij")
    vertices = np.stack([x, y, np.sin(x / 5)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    lower = np.stack([corner, corner + n, corner + n + 1], axis=1)
    upper = np.stack([corner, corner + n + 1, corner + 1], axis=1)
    queries = np.random.default_rng(2).random((100, 3)) * [100, 100, 2]
    start = time.process_time()
    _, _, distance = closest_points(queries, vertices, np.concatenate([lower, upper]))
    assert time.process_time() - start < 2.0
    assert (distance < 3.1).all()


def test_a_remembered_surface_answers_as_a_new_one_and_only_its_own_contents_find_it() -> None:
    random = np.random.default_rng(3)
    points, triangles = random.normal(size=(40, 3)), random.integers(0, 40, (60, 3))
    queries = random.normal(size=(30, 3))
    remembered = remembered_closest_point(points, triangles)
    expected = ClosestPoint(points, triangles).query(queries)
    for _ in range(2):
        again = remembered_closest_point(points.copy(), triangles.copy())
        assert again is remembered
        for got, wanted in zip(again.query(queries), expected, strict=True):
            np.testing.assert_array_equal(got, wanted)
    moved = points.copy()
    moved[7, 1] += 1e-12
    assert remembered_closest_point(moved, triangles) is not remembered
    assert remembered_closest_point(points, triangles[:-1]) is not remembered
    # What is asked may be changed by whoever asked.
    first = remembered.query(queries)[1]
    first[:] = np.nan
    np.testing.assert_array_equal(remembered.query(queries)[1], expected[1])
