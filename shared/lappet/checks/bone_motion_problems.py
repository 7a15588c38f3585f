"""What is wrong with how a bone moves."""

from __future__ import annotations

import math

import numpy as np

from lappet.core.problem import Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RIGID_TOLERANCE, RigidMotion
from lappet.procedure import Bone


def bone_motion_problems(bone: Bone, path: str, start: float) -> list[Problem]:
    """Find every problem of a bone's motion.

    Parameters
    ----------
    bone
        The bone.
    path
        Path of its prim.
    start
        Time code of the procedure's start, at which the bone is where its points are.

    Returns
    -------
    list[Problem]
        The problems; none for a bone that stays.
    """
    if not bone.motion:
        return []
    times = [time for time, _ in bone.motion]
    twice = [time for time in times if times.count(time) > 1]
    if twice:
        return [problem(ProblemCode.BONE_MOTION_TWICE, path, f"{twice[0]:g}")]
    wrong = [len(matrix) for _, matrix in bone.motion if len(matrix) != 16]
    if wrong:
        return [problem(ProblemCode.BONE_MOTION_SIZE, path, wrong[0])]
    try:
        RigidMotion(bone.motion, path)
    except RefusedError as error:
        return list(error.problems)
    if not math.isfinite(start):  # which is said of the timeline
        return []
    order = np.argsort(times)
    entries = np.array([matrix for _, matrix in bone.motion], np.float64)[order]
    at_start = np.array([np.interp(start, np.array(times)[order], entries[:, k]) for k in range(16)])
    off = float(np.abs(at_start - np.eye(4).ravel()).max())
    if off > RIGID_TOLERANCE:
        return [problem(ProblemCode.BONE_MOTION_START, path, f"{off:.3g}", start=start)]
    return []
