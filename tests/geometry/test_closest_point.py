"""`lappet.geometry.closest_point` against trimesh's own search and against cases with known answers."""

from __future__ import annotations

import time

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lappet.geometry.closest_point import ClosestPoint, closest_points


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


def bumpy_grid(n: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A sheet of 100 x 100 mm with waves, 2 (n - 1)² triangles."""
    x, y = np.meshgrid(np.linspace(0, 100, n), np.linspace(0, 100, n), indexing="ij")
    vertices = np.stack([x, y, np.sin(x / 5)], axis=-1).reshape(-1, 3)
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    lower = np.stack([corner, corner + n, corner + n + 1], axis=1)
    upper = np.stack([corner, corner + n + 1, corner + 1], axis=1)
    return vertices, np.concatenate([lower, upper])


def brute_force(query: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The distance (m,) of a point to every triangle (m, 3, 3), by solving for barycentric coordinates."""
    best = np.full(len(corners), np.inf)
    for i in range(3):
        a, edge = corners[:, i], corners[:, (i + 1) % 3] - corners[:, i]
        length = np.maximum((edge**2).sum(axis=1), 1e-300)
        t = np.clip(((query - a) * edge).sum(axis=1) / length, 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(a + t[:, None] * edge - query, axis=1))
    for k, (a, b, c) in enumerate(corners):
        plane = np.stack([b - a, c - a], axis=1)
        (u, v), _, rank, _ = np.linalg.lstsq(plane, query - a, rcond=None)
        if rank == 2 and u >= 0.0 and v >= 0.0 and u + v <= 1.0:
            best[k] = min(best[k], float(np.linalg.norm(a + plane @ [u, v] - query)))
    return best


# Few different values, so that triangles share corners, edges and planes, and some are segments or points.
on_grid = st.tuples(*[st.integers(-2, 2).map(float)] * 3)
anywhere = st.tuples(*[st.floats(-3.0, 3.0)] * 3)


@given(
    st.lists(st.tuples(on_grid, on_grid, on_grid) | st.tuples(anywhere, anywhere, anywhere), min_size=1, max_size=40),
    st.lists(on_grid | anywhere | st.tuples(*[st.floats(-1e5, 1e5)] * 3), min_size=1, max_size=8),
)
@settings(max_examples=40, deadline=None)
def test_answers_are_those_of_brute_force_also_where_triangles_tie_or_vanish(
    triangles: list[tuple[tuple[float, float, float], ...]], queries: list[tuple[float, float, float]]
) -> None:
    corners = np.array(triangles, np.float64)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    surface = ClosestPoint(corners.reshape(-1, 3), faces)
    index, point, distance = surface.query(queries)
    for i, query in enumerate(np.array(queries, np.float64)):
        expected = brute_force(query, corners)
        # A triangle as good as flat has no plane to speak of: its corners decide up to its own height.
        close = 1e-7 * (1.0 + np.abs(query).max())
        assert distance[i] == pytest.approx(expected.min(), abs=close)
        assert expected[index[i]] == pytest.approx(expected.min(), abs=close)
        assert np.linalg.norm(point[i] - query) == pytest.approx(distance[i], abs=close)
        # Each triangle by itself is measured as among the others, to the bit.
        alone = [ClosestPoint(corners[k], [[0, 1, 2]]).query(query)[2][0] for k in range(len(corners))]
        assert distance[i] == alone[index[i]] == min(alone)
    twice = ClosestPoint(np.concatenate([corners, corners]).reshape(-1, 3), np.arange(6 * len(corners)).reshape(-1, 3))
    np.testing.assert_array_equal(twice.query(queries)[0], index)


def test_of_triangles_that_share_the_closest_corner_or_edge_the_first_is_reported() -> None:
    vertices, triangles = bumpy_grid(24)
    shuffled = triangles[np.random.default_rng(5).permutation(len(triangles))]
    surface = ClosestPoint(vertices, shuffled)
    index, point, distance = surface.query(vertices)
    assert (distance == 0.0).all()
    np.testing.assert_array_equal(point, vertices)
    first = [int(np.flatnonzero((shuffled == v).any(axis=1))[0]) for v in range(len(vertices))]
    assert index.tolist() == first
    above = 0.5 * (vertices[shuffled[:, 0]] + vertices[shuffled[:, 1]])
    index, _, distance = surface.query(above)
    for i in range(0, len(shuffled), 7):
        alone = ClosestPoint(vertices, shuffled[index[i] : index[i] + 1]).query(above[i])[2]
        sharing = np.flatnonzero(np.isin(shuffled, shuffled[i, :2]).sum(axis=1) == 2)
        assert alone[0] == distance[i]
        assert index[i] in sharing


def test_an_answer_does_not_depend_on_the_batch_it_is_asked_in() -> None:
    vertices, triangles = bumpy_grid(40)
    random = np.random.default_rng(6)
    queries = np.concatenate([random.uniform(-5, 105, (5000, 3)), 1e4 * random.normal(size=(50, 3)), [[np.nan, 0, 0]]])
    surface = ClosestPoint(vertices, triangles)
    together = surface.query(queries)
    for rows in (slice(0, 1), slice(4090, 4100), slice(5049, 5051), slice(None, None, 3)):
        for alone, all_of_them in zip(surface.query(queries[rows]), together, strict=True):
            np.testing.assert_array_equal(alone, all_of_them[rows])


def test_a_point_as_far_from_all_triangles_still_finds_the_nearest() -> None:
    mesh = trimesh.creation.icosphere(subdivisions=3)
    vertices = np.asarray(mesh.vertices, np.float64)
    index, _, distance = closest_points(np.zeros((300, 3)), vertices, mesh.faces)
    alone = np.array([closest_points([[0, 0, 0]], vertices, face[None])[2][0] for face in mesh.faces])
    assert (distance == alone.min()).all()
    assert (alone[index] == alone.min()).all()
    assert (index == index[0]).all()


def test_within_leaves_out_what_is_farther_and_changes_nothing_else() -> None:
    vertices, triangles = bumpy_grid(30)
    queries = np.random.default_rng(7).uniform([-5, -5, -6], [105, 105, 6], (400, 3))
    surface = ClosestPoint(vertices, triangles)
    index, point, distance = surface.query(queries)
    near = distance <= 2.0
    assert 0 < near.sum() < len(near)
    within = surface.query(queries, within=2.0)
    assert (within[0] == np.where(near, index, -1)).all()
    np.testing.assert_array_equal(within[1], np.where(near[:, None], point, np.nan))
    np.testing.assert_array_equal(within[2], np.where(near, distance, np.nan))


def test_triangles_that_are_not_finite_are_never_closest() -> None:
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0]]
    index, _, distance = closest_points([[0, 0, 3]], points, [[0, 1, 3], [0, 1, 2]])
    assert (index.tolist(), distance.tolist()) == ([1], [3.0])
    assert closest_points([[0, 0, 3]], points, [[0, 1, 3]])[0].tolist() == [-1]


def test_many_points_at_once_take_less_than_a_quarter_of_the_time_of_one_by_one() -> None:
    surface = ClosestPoint(*bumpy_grid(150))
    queries = np.random.default_rng(2).random((2000, 3)) * [100, 100, 2]
    surface.query(queries[:100])
    start = time.process_time()
    for query in queries[:20]:
        surface.query(query)
    one_by_one = (time.process_time() - start) / 20
    start = time.process_time()
    _, _, distance = surface.query(queries)
    assert time.process_time() - start < 0.25 * len(queries) * one_by_one
    assert (distance < 3.1).all()


@pytest.mark.parametrize("within", [np.inf, 1.0])
def test_a_point_alone_gets_the_answer_that_it_gets_among_others_and_again_when_it_is_asked_again(
    within: float,
) -> None:
    generator = np.random.default_rng(7)
    vertices = np.round(generator.normal(0.0, 3.0, (200, 3)))  # many triangles are as far as each other, some are flat
    vertices[3] = np.nan
    surface = ClosestPoint(vertices, generator.integers(0, 200, (400, 3)))
    queries = np.concatenate([np.round(generator.normal(0.0, 4.0, (60, 3))), [[np.nan, 0.0, 0.0], [1e9, 0.0, 0.0]]])
    together = surface.query(queries, within)
    for k in range(len(queries)):
        for _ in range(2):
            for alone, all_of_them in zip(surface.query(queries[k], within), together, strict=True):
                np.testing.assert_array_equal(alone[0], all_of_them[k])
                alone += 1  # what is answered belongs to who asked
