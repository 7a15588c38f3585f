"""Where a stitch enters the skin, and which sutures lie in the depth."""

from __future__ import annotations

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.suture_bites import (
    BITE,
    Bite,
    Lip,
    TrianglesNear,
    _reachable,
    bites_at,
    buried,
    find_bites,
    find_lip,
    inward,
)
from lappet.geometry.skin_shape import depth_below_skin


def test_the_nearest_points_of_the_skin_to_points_above_it_are_below_them() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    points = rest.astype(np.float32)
    above = np.array([[3.3, -7.1, 2.0], [-20.0, 11.0, 0.5]])
    for bite, point in zip(bites_at(points, triangles[origin == SKIN], above), above, strict=True):
        np.testing.assert_allclose(bite.carried(points), [*point[:2], 0.0], atol=1e-5)


def test_the_triangles_about_a_point_are_those_that_a_search_of_all_finds() -> None:
    generator = np.random.default_rng(5)
    points = generator.uniform(-10.0, 10.0, (300, 3)).astype(np.float32)
    triangles = np.stack([np.arange(k, 300 + k) % 300 for k in (0, 1, 7)], axis=-1).astype(np.int32)
    near = TrianglesNear(points, triangles)
    for query in generator.uniform(-25.0, 25.0, (20, 3)):
        away = np.linalg.norm(points[triangles[:, 0]] - query.astype(np.float32), axis=1)
        expected = np.flatnonzero(away <= away.min() + 3.0)
        np.testing.assert_array_equal(near.around(query, 3.0), expected)


def stitch_across(x: float, opened: float, closed: float) -> tuple[tuple[Bite, Bite], np.ndarray]:
    """Bites of a suture at x across the slit, told apart while it gapes `opened` mm and placed at `closed` mm."""
    rest, triangles, origin = synthetic.patch(1.0, True)

    def ends(gape: float) -> np.ndarray:
        return np.array([[x, -gape / 2 - 0.1, 0.0], [x, gape / 2 + 0.1, 0.0]], np.float32)

    lips = tuple(find_lip(synthetic.lips_apart(rest, opened), triangles, origin, end) for end in ends(opened))
    points = synthetic.lips_apart(rest, closed)
    bites = find_bites(points, (lips[0], lips[1]), ends(closed))
    return bites, np.stack([bite.carried(points) for bite in bites])


@pytest.mark.parametrize("x", [-12.0, 0.3, 7.7])
def test_the_bites_of_a_closed_suture_lie_at_right_angles_across_the_wound_each_on_its_side(x: float) -> None:
    bites, places = stitch_across(x, 4.0, 0.02)
    np.testing.assert_allclose(places, [[x, -BITE, 0.0], [x, BITE, 0.0]], atol=0.06)
    for bite in bites:
        assert bite.weights.sum() == pytest.approx(1.0)
        assert (bite.weights >= 0).all()


def test_the_bites_of_a_suture_that_never_closes_keep_their_distance_from_each_lip() -> None:
    _, places = stitch_across(4.0, 6.0, 5.0)
    np.testing.assert_allclose(places, [[4.0, -2.6 - BITE, 0.0], [4.0, 2.6 + BITE, 0.0]], atol=0.06)


@pytest.mark.parametrize("angle", [40.0, 60.0, 90.0])
def test_a_stitch_at_a_flaps_tip_halves_the_tips_angle(angle: float) -> None:
    half = np.radians(angle / 2)
    rows = np.linspace(0.0, 5.0, 11)
    points = np.array([[r * np.sin(t), r * np.cos(t), 0.0] for r in rows for t in (-half, 0.0, half)], np.float32)
    quads = [(3 * k + j, 3 * k + j + 1, 3 * k + j + 4, 3 * k + j + 3) for k in range(10) for j in (0, 1)]
    disk = np.array([t for a, b, c, d in quads for t in ((a, c, b), (a, d, c))], np.int32)
    edges = np.array([(3 * k + j, 3 * k + j + 3) for k in range(10) for j in (0, 2)], np.int32)
    tip = Lip(disk, edges)
    into = inward(points, tip, np.zeros(3), BITE)
    np.testing.assert_allclose(into, [0.0, 1.0, 0.0], atol=1e-6)
    far = 4.0 * np.array([np.sin(half), np.cos(half), 0.0])
    across = inward(points, tip, far, 0.4)
    np.testing.assert_allclose(across, [-np.cos(half), np.sin(half), 0.0], atol=1e-3)


def test_a_suture_is_buried_where_an_end_lies_on_the_wall_in_the_depth_even_under_the_other_lip() -> None:
    rest, triangles, origin = synthetic.patch(1.0, True)
    depth = depth_below_skin(rest.astype(np.float32), triangles, origin)
    for gape in (4.0, 0.05):
        points = synthetic.lips_apart(rest, gape)

        def ends(z: float, gape: float = gape) -> np.ndarray:
            return np.array([[3.0, -gape / 2, z], [3.0, gape / 2, z]], np.float32)

        assert buried(points, triangles, depth, ends(-2.8))
        assert not buried(points, triangles, depth, ends(0.0))
        assert not buried(points, triangles, depth, ends(-0.3))
    folded = synthetic.lips_apart(rest, 4.0)
    folded[:, 2] += np.where(rest[:, 1] > 0, -2.8, 0.0).astype(np.float32)  # one lip's skin beside the other's wall
    deep = np.array([[3.0, -2.0, -2.8], [3.0, 2.0, -5.6]], np.float32)
    assert buried(folded, triangles, depth, deep)


def test_a_lip_is_what_rings_of_triangles_around_its_seed_reach() -> None:
    random = np.random.default_rng(5)
    x, y = np.meshgrid(np.linspace(0, 20, 24), np.linspace(0, 20, 24))
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3).astype(np.float32)
    at = np.arange(x.size).reshape(x.shape)
    halves = [(at[:-1, :-1], at[:-1, 1:], at[1:, 1:]), (at[:-1, :-1], at[1:, 1:], at[1:, :-1])]
    every = np.concatenate([np.stack(half, axis=-1).reshape(-1, 3) for half in halves]).astype(np.int32)
    for radius in (1.0, 3.0, 7.0):
        triangles = every[random.random(len(every)) < 0.6]  # holes, so that some of what is near is not joined
        seed = triangles[random.integers(len(triangles))]
        near = np.linalg.norm(points - points[seed].mean(axis=0), axis=1) <= radius
        near[seed] = True
        member, taken = np.isin(np.arange(len(points)), seed), np.zeros(len(triangles), bool)
        while (grown := ~taken & (member & near)[triangles].any(axis=1)).any():
            taken |= grown
            member[triangles[grown]] = True
        assert (_reachable(points, triangles, seed, radius) == taken).all()
