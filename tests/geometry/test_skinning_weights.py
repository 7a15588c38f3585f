"""Weights of bones are the least squares that another solver finds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from lappet.geometry.skinning_weights import closest_bones, fitted_weights


def cost(weights: np.ndarray, target: np.ndarray, placed: np.ndarray) -> float:
    return float(((np.einsum("k,fkc->fc", weights, placed) - target) ** 2).sum())


def test_weights_of_few_candidates_are_the_minimum_on_the_simplex() -> None:
    random = np.random.default_rng(3)
    placed, targets = random.normal(size=(6, 40, 4, 3)), 0.5 * random.normal(size=(6, 40, 3))
    kept, weights = fitted_weights(targets, placed, np.full((40, 4), 0.25), 0.0)
    assert weights.min() >= 0.0
    assert np.allclose(weights.sum(axis=1), 1.0)
    for n in range(40):
        own = np.zeros(4)
        np.add.at(own, kept[n], weights[n])
        other = minimize(
            cost,
            np.full(4, 0.25),
            (targets[:, n], placed[:, n]),
            "SLSQP",
            bounds=[(0.0, 1.0)] * 4,
            constraints={"type": "eq", "fun": lambda w: w.sum() - 1.0},
            options={"ftol": 1e-12},
        )
        assert cost(own, targets[:, n], placed[:, n]) <= other.fun * (1.0 + 1e-6) + 1e-9


def test_a_vertex_between_two_of_many_bones_gets_these_two() -> None:
    random = np.random.default_rng(5)
    placed = random.normal(size=(8, 1, 9, 3))
    targets = 0.3 * placed[:, :, 2] + 0.7 * placed[:, :, 6]
    kept, weights = fitted_weights(targets, placed, np.zeros((1, 9)), 0.0)
    own = np.zeros(9)
    np.add.at(own, kept[0], weights[0])
    assert own == pytest.approx([0, 0, 0.3, 0, 0, 0, 0.7, 0, 0], abs=1e-6)


def test_one_bone_has_the_whole_weight() -> None:
    placed = np.zeros((2, 3, 1, 3))
    kept, weights = fitted_weights(np.ones((2, 3, 3)), placed, np.ones((3, 1)), 0.0)
    assert kept.tolist() == [[0] * 4] * 3
    assert weights.tolist() == [[1.0, 0.0, 0.0, 0.0]] * 3


def test_the_closest_bones_are_those_with_the_least_errors() -> None:
    errors = np.random.default_rng(1).random((20, 30))
    chosen = closest_bones(errors, 5)
    assert all(set(own) == set(np.argsort(row)[:5]) for own, row in zip(chosen, errors, strict=True))
