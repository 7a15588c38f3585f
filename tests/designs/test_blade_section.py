"""The way of a cut over a rolled border: it lies in the blade's plane and on the skin, and ends at its border."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.designs.blade_section import blade_section
from lappet.geometry.closest_point import ClosestPoint

RADIUS, STEPS = 4.0, 24


def half_pipe() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A lip: half of a cylinder along x, from straight up over the front to straight down."""
    angle = np.linspace(0.0, np.pi, STEPS + 1)
    x = np.linspace(0.0, 10.0, 11)
    points = np.array([(each, RADIUS * np.sin(turn), RADIUS * np.cos(turn)) for turn in angle for each in x])
    quads = [(k * 11 + j, k * 11 + j + 1, k * 11 + j + 12, k * 11 + j + 11) for k in range(STEPS) for j in range(10)]
    return points, np.array([(a, b, c, a, c, d) for a, b, c, d in quads]).reshape(-1, 3)


@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_a_way_over_a_lip_is_as_long_as_the_section_of_a_cylinder_and_ends_at_its_border(tilt: float) -> None:
    points, triangles = half_pipe()
    begin = np.array([4.2, 0.0, 0.0]) + RADIUS * np.array([0.0, np.sin(1.0), np.cos(1.0)])
    (start,), (begin,), _ = ClosestPoint(points, triangles).query(begin[None])
    normal = np.array([1.0, 0.0, tilt])
    way = blade_section(points, triangles, int(start), begin, normal, (0.0, 0.0, -1.0))
    np.testing.assert_allclose((way - begin) @ normal, 0.0, atol=1e-9)
    np.testing.assert_allclose(ClosestPoint(points, triangles).query(way)[2], 0.0, atol=1e-9)
    assert way[-1][1:] == pytest.approx((0.0, -RADIUS), abs=1e-9)
    turn = np.linspace(1.0, np.pi, 4001)
    line = np.stack([-tilt * RADIUS * np.cos(turn), RADIUS * np.sin(turn), RADIUS * np.cos(turn)], axis=1)
    exact = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).sum() == pytest.approx(exact, rel=0.01)


def test_the_other_way_leads_to_the_other_border() -> None:
    points, triangles = half_pipe()
    begin = np.array([[4.2, RADIUS, 0.0]])
    (start,), (begin,), _ = ClosestPoint(points, triangles).query(begin)
    way = blade_section(points, triangles, int(start), begin, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    assert way[-1][1:] == pytest.approx((0.0, RADIUS), abs=1e-9)
