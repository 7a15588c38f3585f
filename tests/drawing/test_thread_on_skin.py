"""A thread with many bites lies on the skin and does not run through it."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.drawing.thread_on_skin import laid_on_skin


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
