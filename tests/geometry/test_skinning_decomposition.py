"""Bones and weights move a mesh as it moves."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lappet.geometry.skinning_decomposition import skinning_decomposition

SIDE = 16


def sheet() -> tuple[np.ndarray, np.ndarray]:
    """A flat sheet of 60 mm, and its edges."""
    x, y = np.meshgrid(np.linspace(-30, 30, SIDE), np.linspace(-30, 30, SIDE), indexing="ij")
    number = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
    edges = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in pairs])
    return np.stack([x.ravel(), y.ravel(), np.zeros(SIDE * SIDE)], axis=1), edges


def rolled(points: np.ndarray, angle: float) -> np.ndarray:
    """The sheet rolled about Y, by an angle in its whole width."""
    if angle == 0.0:
        return points.copy()
    radius = 60.0 / angle
    turn = points[:, 0] / radius
    return np.stack([radius * np.sin(turn), points[:, 1], radius * (1.0 - np.cos(turn))], axis=1)


def test_a_rigid_motion_takes_one_bone() -> None:
    points, edges = sheet()
    turns = Rotation.from_euler("xyz", [[0, 0, 0], [0.2, 0.4, 1.5], [2.0, 0.1, 0.3]])
    frames = np.stack([turn.apply(points) + k for k, turn in enumerate(turns)])
    found = skinning_decomposition(points, frames, edges, 0.01, 50)
    assert found.rotation.shape == (3, 1, 3, 3)
    assert np.abs(found.positions(points) - frames).max() < 0.01


def test_bones_are_added_until_a_rolled_sheet_is_within_the_tolerance() -> None:
    points, edges = sheet()
    frames = np.stack([rolled(points, angle) for angle in np.linspace(0.0, 2.5, 8)])
    counts = []
    for tolerance in (0.5, 0.05):
        found = skinning_decomposition(points, frames, edges, tolerance, 60)
        error = np.linalg.norm(found.positions(points) - frames, axis=2)
        assert error.max() <= tolerance
        assert found.weights.min() >= 0.0
        assert found.weights.sum(axis=1) == pytest.approx(np.ones(len(points)))
        turned = found.rotation @ found.rotation.transpose(0, 1, 3, 2)
        assert np.allclose(turned, np.eye(3), atol=1e-9)
        counts.append(found.rotation.shape[1])
    assert 1 < counts[0] < counts[1] <= 60


def test_neighbors_err_alike_so_that_no_crease_shows() -> None:
    points, edges = sheet()
    frames = np.stack([rolled(points, angle) for angle in np.linspace(0.0, 2.5, 8)])
    wrong = skinning_decomposition(points, frames, edges, 0.05, 60).positions(points) - frames
    step = np.linalg.norm(wrong[:, edges[:, 0]] - wrong[:, edges[:, 1]], axis=2)
    # By how much an edge of 4 mm turns: 1 degree at most, a tenth of the 9 between triangles of the rolled sheet.
    assert step.max() < 4.0 * np.deg2rad(1.0)
    assert np.sqrt((step**2).mean()) < 4.0 * np.deg2rad(0.2)


def test_no_more_bones_are_used_than_are_allowed() -> None:
    points, edges = sheet()
    frames = points + np.random.default_rng(0).normal(size=(4, len(points), 3))
    found = skinning_decomposition(points, frames, edges, 0.01, 5)
    assert found.rotation.shape[1] == 5
    assert found.bones.max() < 5
