"""The course of a stitch over the skin and its knot."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.drawing.suture_bites import BITE
from lappet.drawing.suture_path import THREAD_RADIUS, stitch_path

UP = np.array([0.0, 0.0, 1.0])


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
