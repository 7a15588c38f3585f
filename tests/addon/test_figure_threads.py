"""The thread of a figure: where its bites lie, its course over the skin and its knot."""

from __future__ import annotations

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet_blender.look.skin_fields import depth_below_skin
from lappet_blender.look.suture_bites import BITE, Bite, Lip, buried, find_bites, find_lip, inward
from lappet_blender.look.suture_path import THREAD_RADIUS, stitch_path
from lappet_blender.look.thread_on_skin import laid_on_skin

UP = np.array([0.0, 0.0, 1.0])


def test_a_thread_with_many_bites_lies_on_the_skin_outside_and_runs_straight_inside() -> None:
    """Over a ridge along y, 0.5 mm high and 4 mm wide: down, across, up, and back over it."""
    x, y = np.meshgrid(np.linspace(-8.0, 8.0, 65), np.linspace(-8.0, 8.0, 17), indexing="ij")
    points = np.stack([x, y, 0.5 * np.maximum(1.0 - np.abs(x) / 2.0, 0.0)], axis=-1).reshape(-1, 3)
    at = np.arange(65 * 17).reshape(65, 17)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    bites = np.array([(-4.0, 0.3, 0.0), (-4.0, 0.3, -2.0), (4.0, 0.3, -2.0), (4.0, 0.3, 0.0), (-4.0, 0.3, 0.0)])
    line = laid_on_skin(bites, points, triangles, 0.05)
    assert line[:4] == pytest.approx(bites[:4])  # nothing between them: they are inside
    over = line[4:-1]
    assert over[:, 1] == pytest.approx(0.3)
    assert over[:, 2] == pytest.approx(0.5 * np.maximum(1.0 - np.abs(over[:, 0]) / 2.0, 0.0) + 0.05, abs=0.01)
    assert (np.diff(line[3:, 0]) < 0.0).all()
    assert line[-1] == pytest.approx(bites[-1])


def test_a_thread_over_an_open_wound_runs_straight_from_edge_to_edge() -> None:
    points = np.array([(-6.0, -3.0, 0.0), (-1.0, -3.0, 0.0), (-1.0, 3.0, 0.0), (-6.0, 3.0, 0.0)])
    points = np.concatenate([points, points + np.array([7.0, 0.0, 0.0])])
    triangles = np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)])
    line = laid_on_skin(np.array([(-2.0, 0.0, 0.0), (2.0, 0.0, 0.0), (-2.0, 1.0, 0.0)]), points, triangles, 0.05)
    gap = np.abs(line[:, 0]) < 0.99
    assert gap.any()
    assert np.abs(line[gap, 2]).max() == 0.0
    assert line[(np.abs(line[:, 0]) > 1.01) & (np.abs(line[:, 0]) < 1.99), 2] == pytest.approx(0.05)


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


@pytest.mark.parametrize("scale", [0.8, 1.6])
def test_a_tied_stitch_lies_on_the_skin_with_a_small_knot_on_one_side(scale: float) -> None:
    bites = scale * np.array([[0.0, -BITE, 0.0], [0.0, BITE, 0.0]])
    stitch = stitch_path(bites, np.zeros((2, 3)), np.stack([UP, UP]), True, scale)
    assert stitch.thread[0, 2] < 0
    assert stitch.thread[-1, 2] < 0
    assert (stitch.thread[1:-1, 2] >= THREAD_RADIUS * scale - 1e-9).all()
    assert stitch.thread[:, 2].max() < 2.2 * THREAD_RADIUS * scale  # no arc through the air
    np.testing.assert_allclose(stitch.thread[:, 0], 0.0, atol=1e-9)
    assert len(stitch.knot) == 3
    for line in stitch.knot:
        assert np.isfinite(line).all()
        assert line[:, 1].max() < 0  # beside the wound, not on it
        assert np.abs(line - bites[0]).max() < 1.6 * scale


def test_the_thread_rises_with_the_edge_of_the_wound_and_spans_an_open_gap_straight_without_a_knot() -> None:
    bites = np.array([[0.0, -BITE, 0.0], [0.0, BITE, 0.0]])
    everted = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.5]])
    assert stitch_path(bites, everted, np.stack([UP, UP]), True).thread[:, 2].max() > 0.5 + THREAD_RADIUS
    lips = np.array([[0.0, -3.0, 0.0], [0.0, 4.0, 6.0]])
    apart = stitch_path(lips + bites, lips, np.stack([UP, UP]), False)
    assert apart.knot == ()
    np.testing.assert_allclose(apart.thread[[2, 3]], lips + THREAD_RADIUS * UP)
