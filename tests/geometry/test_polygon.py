"""Polygons in the plane: crossings and signed distances."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.geometry.polygon import crosses_itself, signed_distance

SQUARE = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])


@pytest.mark.parametrize("polygon", [SQUARE, SQUARE[::-1]], ids=["counterclockwise", "clockwise"])
def test_the_distance_is_negative_inside_and_measured_to_the_nearest_side_or_corner(polygon) -> None:
    points = np.array([[0.0, 0.0], [1.5, 0.3], [3.0, 0.0], [5.0, 6.0]])
    assert signed_distance(points, polygon) == pytest.approx([-2.0, -0.5, 1.0, 5.0])


def test_a_bow_tie_crosses_itself_and_a_square_and_an_arrow_do_not() -> None:
    assert crosses_itself(SQUARE[[0, 2, 1, 3]])
    assert not crosses_itself(SQUARE)
    assert not crosses_itself(np.array([[-2.0, -2.0], [0.0, -1.0], [2.0, -2.0], [0.0, 3.0]]))
