"""Weights of bones at vertices: at most four each, none negative, together 1, nearest to where the vertices are.

A vertex i at p_i in the bind pose goes, in a frame, to the sum of w_ib (R_b p_i + t_b). With weights that sum to 1 its
squared error is w^T Q_i w, where Q_i holds the products of x_b - v over the frames, x_b being where bone b alone would
take the vertex and v where it is: a small quadratic program on a simplex for each vertex, all solved at once.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

INFLUENCES = 4
CANDIDATES = 10
_STEPS = 60


def closest_bones(errors: NDArray[np.float64], count: int = CANDIDATES) -> NDArray[np.int64]:
    """Choose the bones that may move each vertex: those that alone would leave it nearest to where it is.

    Parameters
    ----------
    errors
        Squared error of each bone alone, shape (n, b).
    count
        How many to choose.

    Returns
    -------
    NDArray[np.int64]
        Bones of each vertex, shape (n, k), k at most `count`.
    """
    if errors.shape[1] <= count:
        return np.tile(np.arange(errors.shape[1]), (len(errors), 1))
    return np.argpartition(errors, count, axis=1)[:, :count]


def fitted_weights(
    targets: NDArray[np.float64],
    placed: NDArray[np.float64],
    wanted: NDArray[np.float64],
    stiffness: float,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Solve the quadratic programs of some vertices.

    Parameters
    ----------
    targets
        Where the vertices are in each frame, shape (f, n, 3).
    placed
        Where each of their candidate bones would take them, shape (f, n, k, 3).
    wanted
        Weights of the candidates that they should be near, for smoothness, shape (n, k).
    stiffness
        Price of a squared difference from these, in mm^2 summed over the frames.

    Returns
    -------
    tuple[NDArray[np.int64], NDArray[np.float64]]
        Which candidates have weight, shape (n, `INFLUENCES`), and their weights, which sum to 1, of the same shape;
        where there are fewer, weight 0 of the first one.
    """
    away = (placed - targets[:, :, None]).transpose(1, 2, 0, 3)
    count, candidates = away.shape[:2]
    rows = away.reshape(count, candidates, -1)
    matrix = rows @ rows.transpose(0, 2, 1)
    matrix += stiffness * np.eye(candidates)
    linear = stiffness * wanted
    rough = _projected_descent(matrix, linear, wanted)
    kept = np.argsort(-rough, axis=1, kind="stable")[:, :INFLUENCES]
    small = np.take_along_axis(np.take_along_axis(matrix, kept[:, :, None], 1), kept[:, None, :], 2)
    weights = _best_support(small, np.take_along_axis(linear, kept, 1))
    if candidates < INFLUENCES:
        fill = ((0, 0), (0, INFLUENCES - candidates))
        kept, weights = np.pad(kept, fill), np.pad(weights, fill)
    return kept, weights


def _projected_descent(
    matrix: NDArray[np.float64], linear: NDArray[np.float64], start: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Descend to the minimum on the simplex, with momentum (Beck & Teboulle 2009)."""
    bound = np.abs(matrix).sum(axis=2).max(axis=1)[:, None] + 1e-12
    weights = ahead = _on_simplex(start)
    momentum = 1.0
    for _ in range(_STEPS):
        slope = (matrix @ ahead[:, :, None])[:, :, 0] - linear
        fresh = _on_simplex(ahead - slope / bound)
        faster = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum * momentum))
        ahead = fresh + (momentum - 1.0) / faster * (fresh - weights)
        weights, momentum = fresh, faster
    return weights


def _on_simplex(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The nearest points of which no coordinate is negative and all sum to 1."""
    falling = -np.sort(-values, axis=1)
    over = np.cumsum(falling, axis=1) - 1.0
    number = np.arange(1, values.shape[1] + 1)
    last = (falling - over / number > 0.0).sum(axis=1) - 1
    shift = over[np.arange(len(values)), last] / (last + 1)
    return np.maximum(values - shift[:, None], 0.0)


def _best_support(matrix: NDArray[np.float64], linear: NDArray[np.float64]) -> NDArray[np.float64]:
    """The minimum on the simplex of few coordinates, exactly: the best of the stationary points of all its faces."""
    count, size = linear.shape
    best = np.full(count, np.inf)
    found = np.zeros((count, size))
    for chosen in range(1, size + 1):
        for support in combinations(range(size), chosen):
            own = list(support)
            system = np.zeros((count, chosen + 1, chosen + 1))
            system[:, :chosen, :chosen] = matrix[:, own][:, :, own]
            system[:, range(chosen), range(chosen)] += 1e-9 * (1.0 + matrix[:, own, own])
            system[:, chosen, :chosen] = system[:, :chosen, chosen] = 1.0
            right = np.concatenate([linear[:, own], np.ones((count, 1))], axis=1)
            weights = np.zeros((count, size))
            weights[:, own] = np.linalg.solve(system, right[:, :, None])[:, :chosen, 0]
            cost = np.einsum("ni,nij,nj->n", weights, matrix, weights) - 2.0 * (linear * weights).sum(axis=1)
            better = (weights >= 0.0).all(axis=1) & (cost < best)
            best[better], found[better] = cost[better], weights[better]
    return found / found.sum(axis=1, keepdims=True)
