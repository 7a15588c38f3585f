"""The motion of a bone is the rigid one that fits best."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lappet.geometry.skinning_bones import moved, rigid_fit


def test_a_rigid_motion_is_found_again() -> None:
    random = np.random.default_rng(2)
    points, weights = random.normal(size=(30, 3)), random.uniform(0.1, 1.0, 30)
    rotation, shift = Rotation.random(5, random_state=4).as_matrix(), random.normal(size=(5, 3))
    targets = weights[:, None] * moved(points, rotation, shift)
    found, placed = rigid_fit(points, weights, targets)
    assert np.allclose(found, rotation, atol=1e-4)
    assert np.allclose(placed, shift, atol=1e-4)


def test_the_rotation_is_that_of_another_solver_where_none_fits_exactly() -> None:
    random = np.random.default_rng(6)
    points, weights = random.normal(size=(40, 3)), random.uniform(0.1, 1.0, 40)
    goal = random.normal(size=(1, 40, 3)) + points
    found, _ = rigid_fit(points, weights, weights[:, None] * goal)
    center, other = np.average(points, axis=0, weights=weights**2), np.average(goal[0], axis=0, weights=weights**2)
    expected = Rotation.align_vectors(goal[0] - other, points - center, weights**2)[0].as_matrix()
    assert np.allclose(found[0], expected, atol=1e-4)


def test_points_in_a_line_or_mirrored_still_give_a_rotation() -> None:
    line = np.outer(np.linspace(-1, 1, 9), [1.0, 0, 0])
    cloud = np.random.default_rng(8).normal(size=(9, 3))
    for points, targets in ((line, line[None]), (cloud, (cloud * (1, 1, -1))[None]), (0 * line, line[None])):
        found, _ = rigid_fit(points, np.ones(9), targets)
        assert np.allclose(found[0] @ found[0].T, np.eye(3), atol=1e-9)
        assert np.linalg.det(found[0]) > 0.0
