"""Distances along a surface, against those of a plane, a cylinder and a ball."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from face_meshes import grid_triangles
from lappet.geometry.geodesic_distance import geodesic_distance


def test_in_a_plane_the_distance_is_the_straight_one_whatever_the_triangles() -> None:
    at = np.linspace(-10.0, 10.0, 41)
    x, y = (each.ravel() for each in np.meshgrid(at, at))
    off = np.random.default_rng(0).uniform(-0.15, 0.15, (len(x), 2))
    points = np.column_stack([x + off[:, 0], y + off[:, 1], np.zeros_like(x)])
    source = np.array([0.3, 0.2, 0.0])
    found = geodesic_distance(points, grid_triangles(41, 41), source)
    assert found == pytest.approx(np.linalg.norm(points - source, axis=1), abs=1e-9)


def test_around_a_cylinder_it_is_that_of_the_unrolled_plane() -> None:
    turn, height = np.linspace(0.0, 2.5, 101), np.linspace(0.0, 30.0, 101)
    u, v = (each.ravel() for each in np.meshgrid(turn, height))
    points = np.column_stack([12.0 * np.cos(u), 12.0 * np.sin(u), v])
    found = geodesic_distance(points, grid_triangles(101, 101), points[0])
    assert found == pytest.approx(np.hypot(12.0 * u, v), rel=2e-3, abs=0.02)


def test_on_a_ball_it_is_the_arc_within_one_percent_from_fifteen_edges_to_the_radius_on() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    points, triangles = np.asarray(ball.vertices), np.asarray(ball.faces, np.int64)
    found = geodesic_distance(points, triangles, np.array([0.0, 0.0, 10.0]))
    arc = 10.0 * np.arccos(np.clip(points[:, 2] / 10.0, -1.0, 1.0))
    far = (arc > 10.0) & (arc < 28.0)  # at the other pole ways from all sides meet
    assert np.abs(found[far] / arc[far] - 1.0).max() < 0.01


def test_beyond_the_reach_and_on_what_is_not_connected_it_is_infinite() -> None:
    near, far = (trimesh.creation.icosphere(subdivisions=3, radius=10.0) for _ in range(2))
    far.apply_translation([20.5, 0.0, 0.0])
    both = trimesh.util.concatenate([near, far])
    found = geodesic_distance(np.asarray(both.vertices), np.asarray(both.faces, np.int64), np.array([10.0, 0, 0]), 8.0)
    assert np.isinf(found[len(near.vertices) :]).all()
    assert found[np.isfinite(found)].max() <= 8.0
    assert np.isinf(found[: len(near.vertices)]).any()
