"""What a skeleton is written with."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from lappet.export.skeleton_stage import quaternions


def test_quaternions_are_those_of_another_library_half_turns_among_them() -> None:
    turns = Rotation.concatenate(
        [Rotation.random(200, random_state=1), Rotation.from_euler("xyz", [[np.pi, 0, 0], [0, np.pi, 0], [0, 0, 0]])]
    )
    found = quaternions(turns.as_matrix())
    same = np.abs((found * turns.as_quat()[:, [3, 0, 1, 2]]).sum(axis=1))
    assert np.allclose(same, 1.0, atol=1e-9)
