"""A thread with many bites lies on the skin and does not run through it."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SkinEpoch
from lappet.drawing.suture_path import THREAD_RADIUS
from lappet.drawing.suture_thread import SutureThread
from lappet.drawing.thread_on_skin import laid_on_skin, rises_over_skin


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


def test_a_thread_rises_over_skin_that_bulges_below_it_but_not_over_a_fold_that_hangs_above_it() -> None:
    line = np.array([[(-1.0, 0.0, 0.1), (0.0, 0.0, 0.1), (1.0, 0.0, 0.1), (3.0, 0.0, 0.1)]])
    ridge = np.array(
        [[(-1.0, -9.0, 0.0), (0.0, 0.0, 0.5), (-1.0, 9.0, 0.0)], [(0.0, 0.0, 0.5), (1.0, -9.0, 0.0), (1.0, 9.0, 0.0)]]
    )
    up = np.array([[0.0, 0.0, 1.0]])
    rises = rises_over_skin(line, ridge[None], up, 0.1, 1.0)
    assert rises[0] == pytest.approx([0.0, 0.5, 0.0, 0.0])  # the last has no skin below it
    assert rises_over_skin(line, ridge[None], up, 0.1, 0.4).max() == 0.0
    without_area = np.concatenate([ridge, np.zeros((3, 3, 3))])
    assert rises_over_skin(line, without_area[None], up, 0.1, 1.0) == pytest.approx(rises)
    turned = np.array(
        [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]
    ).T  # many threads at once, each with its own up
    both = rises_over_skin(
        np.concatenate([line, line @ turned]),
        np.stack([ridge, ridge @ turned]),
        np.concatenate([up, up @ turned]),
        0.1,
        1.0,
    )
    assert both == pytest.approx(np.concatenate([rises, rises]))


def test_the_stitches_of_a_closed_wound_lie_on_the_skin_where_it_bulges_beside_the_wound(
    cache: SkinCache, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As an upper lid does: a thread from bite to bite would be hidden in it and show as two dots."""
    flat, scale = SkinCache.positions, 2.0

    def height(y: NDArray[np.floating]) -> NDArray[np.floating]:
        return 1.5 * np.maximum(1.0 - np.abs(np.abs(y) - 2.0) / 2.0, 0.0)

    def bulging(self: SkinCache, epoch: SkinEpoch, time: float) -> NDArray[np.float32]:
        points = flat(self, epoch, time).copy()
        points[:, 2] += height(points[:, 1])
        return points

    monkeypatch.setattr(SkinCache, "positions", bulging)
    lines = SutureThread(cache, np.array([0.0, 1.0, 0.0]), scale, hidden=frozenset()).named_lines(12.0)
    threads = [line[1:-1] for (_, part), line in lines.items() if part == 0]
    assert len(threads) == 4
    for line in threads:
        assert np.ptp(line[:, 1]) > 4.0  # its bites lie beyond the bulges
        assert (line[:, 2] - height(line[:, 1])).min() > 0.9 * THREAD_RADIUS * scale
    for knot in (line for (_, part), line in lines.items() if part == 1):
        assert knot[:, 2].max() > height(knot[:, 1]).max()
