"""Where the camera stands: it holds the surgical field, with the patient's head up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.drawing.framing import (
    FIELD_FILL,
    NEARER,
    STEEPEST,
    WIDEST,
    Viewpoint,
    half_angles,
    surgical_field,
    viewpoint,
    viewpoint_on_skin,
    widened,
)
from lappet.drawing.skin_read import SkinCache

UP = np.array([0.0, 0.0, 1.0])


def test_the_lens_of_90_mm_sees_36_mm_along_the_longer_side_at_that_distance() -> None:
    assert half_angles((1280, 960)) == pytest.approx((0.2, 0.15))
    assert half_angles((960, 1280)) == pytest.approx((0.15, 0.2))


@pytest.mark.parametrize("view", ["oblique", "top", "low"])
@pytest.mark.parametrize("halves", [(0.2, 0.15), (0.1, 0.2)])
def test_the_camera_holds_the_whole_region_and_not_much_more(
    cache: SkinCache, view: str, halves: tuple[float, float]
) -> None:
    field = surgical_field(cache, cache.frames)
    np.testing.assert_allclose(field.normal, UP, atol=1e-6)
    assert np.abs(field.points[:, 0]).max() < 35
    seen = viewpoint(field, view, halves)
    np.testing.assert_allclose(seen.axes @ seen.axes.T, np.eye(3), atol=1e-9)
    local = (field.points - seen.position) @ seen.axes.T
    assert (local[:, 2] < 0).all()
    ends = local[:, :2] / -local[:, 2:] / halves
    filled = np.abs(ends).max(axis=0) / FIELD_FILL
    assert filled.max() <= 1.0 + 1e-6
    assert filled.max() > 0.97
    np.testing.assert_allclose(ends.max(axis=0), -ends.min(axis=0), atol=0.02)  # in the middle of the picture


def test_a_body_around_a_wound_is_shown_with_its_top_up_and_the_wound_stays_in_sight(cache: SkinCache) -> None:
    field = surgical_field(cache, cache.frames)
    own = float(np.linalg.norm(np.ptp(field.points, axis=0)))
    on_side = replace(field, normal=np.array([1.0, 0.0, 0.0]))
    tissue = np.array([[0.0, 0.0, 0.0], [0.0, 2.0 * own, 0.0]])
    wide = widened(on_side, tissue)
    np.testing.assert_allclose(wide.up, (0.0, 0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(np.cross(wide.up, wide.normal), wide.right, atol=1e-12)
    twice = 2.0**NEARER
    assert wide.context == pytest.approx(twice)
    assert wide.fill == pytest.approx((FIELD_FILL[0] / twice, FIELD_FILL[1] / twice))
    assert widened(field, 100.0 * tissue).context == pytest.approx(WIDEST**NEARER)
    assert widened(field, 0.1 * tissue).context == 1.0
    np.testing.assert_allclose(widened(field, tissue).up, (0.0, 1.0, 0.0), atol=1e-12)  # seen from above


def test_skin_of_a_body_that_faces_down_is_drawn_from_above(cache: SkinCache) -> None:
    field = surgical_field(cache, cache.frames)
    for normal, up, above in (((0.0, 0.8, -0.6), (0.0, 0.6, 0.8), True), ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), False)):
        lid = replace(field, context=2.0, normal=np.array(normal), up=np.array(up), right=np.array([-1.0, 0.0, 0.0]))
        view = viewpoint(lid, "oblique", (0.2, 0.15))
        assert (view.axes[2][2] > normal[2]) == above  # the camera stands higher, or lower, than along the normal
        assert view.axes[1][2] > 0.5  # the patient's head is up


def steepness(back: np.ndarray) -> float:
    """Degrees of a camera above a skin that faces up."""
    return float(np.degrees(np.arcsin(back[2])))


def test_an_oblique_view_is_steeper_where_it_would_show_the_border_of_a_patch(cache: SkinCache) -> None:
    field, halves = surgical_field(cache, cache.frames), (0.2, 0.15)
    usual = viewpoint(field, "oblique", halves)

    def patch(half: float) -> np.ndarray:
        return field.center + half * np.array([(x, y, 0.0) for x in (-1, 1) for y in (-1, 1)])

    rays = np.array([(x * halves[0], y * halves[1], -1.0) for x in (-1, 1) for y in (-1, 1)])

    def farthest(seen: Viewpoint) -> float:
        to = rays @ seen.axes
        hits = seen.position + ((field.center[2] - seen.position[2]) / to[:, 2])[:, None] * to
        return float(np.abs(hits - field.center)[:, :2].max())

    reach = farthest(usual)
    wide = viewpoint_on_skin(field, "oblique", halves, patch(1.01 * reach))
    np.testing.assert_allclose(wide.position, usual.position)
    small = viewpoint_on_skin(field, "oblique", halves, patch(0.97 * reach))
    assert 0.0 < steepness(small.axes[2]) - steepness(usual.axes[2]) <= STEEPEST + 1e-6
    assert farthest(small) <= 0.97 * reach
    too_small = viewpoint_on_skin(field, "oblique", halves, patch(0.3 * reach))
    np.testing.assert_allclose(too_small.position, usual.position)
    body = replace(field, context=2.0)
    on_body = viewpoint_on_skin(body, "oblique", halves, patch(0.97 * reach))
    np.testing.assert_allclose(on_body.position, viewpoint(body, "oblique", halves).position)
