"""Tubes keep their triangles while lines come and go."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.drawing.surface_look import THREAD_LOOK
from lappet.export.moving_tubes import tube_shape

STRAIGHT = np.linspace([0.0, 0.0, 0.0], [10.0, 0.0, 0.0], 5)
BENT = np.array([[0.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 10.0, 1.0]])


def around(points: np.ndarray, sides: int) -> np.ndarray:
    """Distance of each point from the middle of its ring."""
    rings = points.reshape(-1, sides, 3)
    return np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=-1)


def test_a_line_that_is_not_drawn_has_no_thickness_and_lies_where_it_is_drawn_next() -> None:
    frames = [{"a": (STRAIGHT, 0.2)}, {"a": (STRAIGHT, 0.2), "b": (STRAIGHT + 3.0, 0.1)}, {"b": (STRAIGHT + 4.0, 0.1)}]
    shape = tube_shape("tubes", THREAD_LOOK, 6, (1.0, 2.0, 3.0), frames)
    assert shape is not None
    assert shape.positions.shape == shape.normals.shape == (3, 2 * 5 * 6, 3)
    first, second = shape.positions[:, :30], shape.positions[:, 30:]
    assert [around(each, 6).max() for each in first] == pytest.approx([0.2, 0.2, 0.0], abs=1e-5)
    assert [around(each, 6).max() for each in second] == pytest.approx([0.0, 0.1, 0.1], abs=1e-5)
    assert np.allclose(second[0].reshape(-1, 6, 3).mean(axis=1), STRAIGHT + 3.0, atol=1e-5)
    assert np.allclose(first[2].reshape(-1, 6, 3).mean(axis=1), STRAIGHT, atol=1e-5)


def test_a_line_of_fewer_points_keeps_its_course() -> None:
    shape = tube_shape("tubes", THREAD_LOOK, 6, (1.0, 2.0), [{"a": (BENT, 0.2)}, {"a": (STRAIGHT, 0.2)}])
    assert shape is not None
    middles = shape.positions[0].reshape(-1, 6, 3).mean(axis=1)
    assert len(middles) == len(STRAIGHT)
    for corner in BENT:
        assert np.linalg.norm(middles - corner, axis=1).min() < 1e-5
    assert np.allclose(middles[(middles[:, 2] < 0.1)][:, [0, 2]], 0.0, atol=1e-5)


def test_a_tube_that_turns_a_little_is_not_wrung() -> None:
    lines = []
    for turn in np.linspace(0.0, 0.6, 7):
        c, s = np.cos(turn), np.sin(turn)
        lines.append({"a": (STRAIGHT @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]), 0.2)})
    shape = tube_shape("tubes", THREAD_LOOK, 8, tuple(range(7)), lines)
    assert shape is not None
    alike = (shape.normals[1:] * shape.normals[:-1]).sum(axis=-1)
    assert alike.min() > 0.8
    assert np.allclose(np.linalg.norm(shape.normals, axis=-1), 1.0, atol=1e-5)


def test_frames_before_the_first_line_and_after_the_last_are_left_out() -> None:
    line = {"a": (STRAIGHT, 0.2)}
    shape = tube_shape("tubes", THREAD_LOOK, 6, (1.0, 2.0, 3.0, 4.0, 5.0), [{}, line, {}, line, {}])
    assert shape is not None
    assert shape.frames == (2.0, 3.0, 4.0)
    assert around(shape.positions[1], 6).max() == pytest.approx(0.0, abs=1e-6)
    assert tube_shape("tubes", THREAD_LOOK, 6, (1.0,), [{}]) is None
