"""Corners of cuts have letters, and their angles are those of the plan."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.plates.letter_anchors import cut_corners, legs

UP = np.array([0.0, 0.0, 1.0])


def dense(*corners: tuple[float, float]) -> NDArray[np.float64]:
    """A polygon line with a point every quarter of a millimeter."""
    points = np.array([(*each, 0.0) for each in corners])
    parts = [points[:1]]
    for a, b in pairwise(points):
        share = np.linspace(0.0, 1.0, int(np.linalg.norm(b - a) / 0.25) + 1)[1:, None]
        parts.append(a + share * (b - a))
    return np.vstack(parts)


def at(degrees: float, length: float) -> tuple[float, float]:
    return (length * float(np.cos(np.radians(degrees))), length * float(np.sin(np.radians(degrees))))


@pytest.mark.parametrize("angle", [30.0, 45.0, 60.0, 90.0])
def test_a_z_has_four_corners_and_two_angles_of_the_design(angle: float) -> None:
    top, bottom = at(180.0 - angle, 10.0), at(-angle, 10.0)
    z = dense((5.0 + top[0], top[1]), (5.0, 0.0), (-5.0, 0.0), (-5.0 + bottom[0], bottom[1]))
    corners = cut_corners([z], UP)
    assert [corner.letter for corner in corners] == ["a", "b", "c", "d"]
    angles = [np.degrees(corner.sectors[0].angle) for corner in corners]
    assert angles == pytest.approx([360.0, angle, angle, 360.0], abs=1.0)


def test_where_three_cuts_meet_there_is_one_corner_with_three_sectors() -> None:
    tip = at(60.0, 12.0)
    rhombus = dense((0.0, 0.0), (12.0, 0.0), (12.0 + tip[0], tip[1]), tip, (0.0, 0.0))
    flap = dense((12.0, 0.0), (24.0, -6.0))
    corners = cut_corners([rhombus, flap], UP)
    assert len(corners) == 5
    (junction,) = [each for each in corners if np.allclose(each.at[:2], (12.0, 0.0), atol=0.3)]
    assert len(junction.sectors) == 3
    assert sum(sector.angle for sector in junction.sectors) == pytest.approx(2.0 * np.pi)


def test_a_small_circle_has_no_corner() -> None:
    turns = np.linspace(0.0, 2.0 * np.pi, 101)
    circle = 4.0 * np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=1)
    circle[-1] = circle[0]
    assert cut_corners([circle], UP) == []
    assert len(legs(circle)) == 1


def test_a_corner_is_inset_into_its_own_tissue() -> None:
    wedge = dense((10.0, 0.0), (0.0, 0.0), at(40.0, 10.0))
    corner = cut_corners([wedge], UP)[1]
    assert corner.inset(2.0)[:2] == pytest.approx(at(20.0, 2.0), abs=0.02)


def test_of_crowded_corners_the_sharpest_keeps_its_letter() -> None:
    line = dense((-10.0, 0.0), (0.0, 0.0), (2.0, 2.0), (-8.0, 3.0))
    places = [corner.at for corner in cut_corners([line], UP, apart=4.0)]
    assert any(np.allclose(place[:2], (2.0, 2.0), atol=0.3) for place in places)
    assert not any(np.allclose(place[:2], (0.0, 0.0), atol=0.3) for place in places)


def test_legs_run_from_corner_to_corner() -> None:
    line = dense((0.0, 0.0), (10.0, 0.0), (10.0, 7.0))
    lengths = [float(np.linalg.norm(np.diff(leg, axis=0), axis=1).sum()) for leg in legs(line)]
    assert lengths == pytest.approx([10.0, 7.0], abs=0.3)
