"""The course of a hook and the directions of several."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.drawing.hook_path import ELEVATION, hook_directions, hook_path

UP = np.array([0.0, 0.0, 1.0])


def test_hooks_come_in_from_opposite_sides_and_rise_however_their_flaps_cross_over() -> None:
    left = np.array([[-9.0, 0.0, 0.0], [0.0, 5.0, 10.0], [0.5, 15.0, 0.0]])
    for courses in ([left, -left * [1, 1, -1]], [-left * [1, 1, -1], left]):
        directions = hook_directions(courses, np.zeros(3), np.eye(3))
        for course, direction in zip(courses, directions, strict=True):
            assert np.linalg.norm(direction) == pytest.approx(1.0)
            assert np.degrees(np.arcsin(direction[2])) == pytest.approx(np.degrees(ELEVATION))
            assert np.sign(direction[0]) == np.sign(course[0, 0])
            assert abs(direction[0]) > 0.35
            assert np.sign(direction[1]) == np.sign(course[:, 1].mean())
    assert 35 <= np.degrees(ELEVATION) <= 50
    (alone,) = hook_directions([left[:1]], np.zeros(3), np.eye(3))
    assert alone[0] < -0.6
    assert hook_directions([], np.zeros(3), np.eye(3)) == []


@pytest.mark.parametrize("edge", [np.array([1.0, 0.0, 0.0]), UP])
def test_a_hooks_point_comes_up_at_the_anchor_and_its_crook_runs_under_the_skin(edge: np.ndarray) -> None:
    (direction,) = hook_directions([np.array([[5.0, 0.0, 0.0]])], np.zeros(3), np.eye(3))
    anchor = np.array([5.0, 1.0, 2.0])
    line, radii = hook_path(anchor, direction, UP, edge)
    assert 0.2 < line[0, 2] - anchor[2] < 1.0
    assert np.linalg.norm(line - anchor, axis=1).min() < 0.1
    assert line[:, 2].min() < anchor[2] - 0.5
    assert line[-1, 2] > anchor[2] + 20
    assert len(line) == len(radii)
    assert radii[0] < 0.1 < radii.max()
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps[:26].max() < 0.6  # crook and bend are smooth
    turns = np.diff(line[:27], axis=0) / steps[:26, None]
    assert np.einsum("ij,ij->i", turns[1:], turns[:-1]).min() > np.cos(np.radians(50))
