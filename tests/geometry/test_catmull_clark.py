from __future__ import annotations

import numpy as np

from lappet.geometry.border_loops import border_loops
from lappet.geometry.catmull_clark import catmull_clark


def grid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """A grid of n by n unit squares."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=2).reshape(-1, 4)
    return np.stack([x.ravel(), y.ravel()], axis=1), quads


CUBE = np.array([[x, y, z] for z in (-1.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
CUBE_QUADS = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])


def test_a_linear_function_of_a_regular_grid_is_kept() -> None:
    points, quads = grid(4)
    values, fine = catmull_clark(np.hstack([points, points @ [[2.0], [-3.0]]]), quads)
    assert np.allclose(values[:, 2], values[:, :2] @ [2.0, -3.0])
    assert len(fine) == 4 * len(quads)


def test_the_smooth_rule_inside_a_regular_grid_is_that_of_the_bicubic_spline() -> None:
    points, quads = grid(4)
    spike = np.zeros((len(points), 1))
    spike[12] = 1.0  # the middle
    values, _ = catmull_clark(spike, quads)
    assert values[12, 0] == 36.0 / 64.0
    assert sorted(set(np.round(values[:25, 0], 12)) - {0.0}) == [1.0 / 64.0, 6.0 / 64.0, 36.0 / 64.0]


def test_a_border_is_a_cubic_spline_whatever_lies_inside() -> None:
    points, quads = grid(4)
    bent, straight = np.zeros((len(points), 1)), np.zeros((len(points), 1))
    bent[12] = 5.0
    border = np.unique(np.concatenate(border_loops(quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))))
    assert np.allclose(catmull_clark(bent, quads)[0][border], catmull_clark(straight, quads)[0][border])
    along = np.zeros((len(points), 1))
    along[2] = 1.0  # the middle of one side
    assert catmull_clark(along, quads)[0][2, 0] == 0.75


def test_a_cube_stays_closed_and_nears_a_ball() -> None:
    values, quads = CUBE, CUBE_QUADS
    for _ in range(4):
        values, quads = catmull_clark(values, quads)
    edges = {frozenset(pair) for quad in quads.tolist() for pair in zip(quad, quad[1:] + quad[:1], strict=True)}
    assert len(values) - len(edges) + len(quads) == 2
    radius = np.linalg.norm(values, axis=1)
    assert radius.max() / radius.min() < 1.2
    assert np.ptp(values, axis=0).min() > 0.9
