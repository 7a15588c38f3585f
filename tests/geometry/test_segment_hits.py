"""Where segments meet a surface first, against a ball's formula and against every triangle one by one."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from lappet.geometry.segment_hits import first_hits


@pytest.fixture(scope="module")
def ball() -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=10.0)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces, np.int64)


def test_a_segment_into_a_ball_meets_its_near_side_and_one_out_of_it_its_wall(ball) -> None:
    points, triangles = ball
    way = trimesh.unitize(np.random.default_rng(1).standard_normal((300, 3)))
    inwards = first_hits(25.0 * way, -25.0 * way, points, triangles)
    outwards = first_hits(0.0 * way, 25.0 * way, points, triangles)
    assert inwards.fraction * 50.0 == pytest.approx(np.full(300, 15.0), abs=0.03)
    assert outwards.fraction * 25.0 == pytest.approx(np.full(300, 10.0), abs=0.03)
    np.testing.assert_array_equal(inwards.triangle, outwards.triangle)


def test_what_is_met_beyond_the_end_or_beside_does_not_count(ball) -> None:
    points, triangles = ball
    starts = np.array([[0.0, 0.0, 20.0], [0.0, 0.0, 20.0], [11.0, 0.0, 20.0]])
    ends = np.array([[0.0, 0.0, 10.5], [0.0, 0.0, 9.0], [11.0, 0.0, -20.0]])
    hits = first_hits(starts, ends, points, triangles)
    assert (hits.triangle >= 0).tolist() == [False, True, False]
    assert np.isinf(hits.fraction[[0, 2]]).all()


def test_the_first_of_many_is_found_as_by_looking_at_every_triangle() -> None:
    rng = np.random.default_rng(2)
    corners = rng.uniform(-1.0, 1.0, (200, 1, 3)) + rng.uniform(-0.3, 0.3, (200, 3, 3))
    starts, ends = rng.uniform(-1.5, 1.5, (2, 100, 3))
    hits = first_hits(starts, ends, corners.reshape(-1, 3), np.arange(600).reshape(-1, 3))
    for k in range(100):
        system = np.stack(
            [corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], np.tile(starts[k] - ends[k], (200, 1))],
            axis=2,
        )
        u, v, at = np.linalg.solve(system, (starts[k] - corners[:, 0])[:, :, None])[:, :, 0].T
        met = np.flatnonzero((u >= 0) & (v >= 0) & (u + v <= 1) & (at >= 0) & (at <= 1))
        expected = met[at[met].argmin()] if len(met) else -1
        assert hits.triangle[k] == expected
