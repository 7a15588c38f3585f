"""What live mode drags: a hook or a retractor of a program, and a frame with it elsewhere."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import Pose, Procedure, Retractor, matrix_pose, place_of, pose_at, pose_matrix
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.program import FrameConstraints, Program
from lappet.program.timed_events import event_path


class Held(Protocol):
    """What is dragged."""

    def pulls(self, frame: FrameConstraints) -> bool:
        """Tell whether it acts in a frame.

        Parameters
        ----------
        frame
            The frame.

        Returns
        -------
        bool
            Whether it does.
        """

    def own_target(self, frame: FrameConstraints) -> Pose:
        """Return where the program has it in a frame.

        Parameters
        ----------
        frame
            A frame in which it pulls.

        Returns
        -------
        Pose
            Where it is.
        """

    def moved(self, frame: FrameConstraints, target: Pose) -> FrameConstraints:
        """Have it elsewhere.

        Parameters
        ----------
        frame
            A frame in which it pulls.
        target
            Where to.

        Returns
        -------
        FrameConstraints
            The frame.
        """


@dataclass(frozen=True)
class HeldHook:
    """A hook; how its target is turned does not matter.

    Parameters
    ----------
    number
        Its number in `Program.hooks`.
    """

    number: int

    def pulls(self, frame: FrameConstraints) -> bool:
        """Tell whether it pulls in a frame.

        Parameters
        ----------
        frame
            The frame.

        Returns
        -------
        bool
            Whether it does.
        """
        return bool((frame.hook_index == self.number).any())

    def own_target(self, frame: FrameConstraints) -> Pose:
        """Return where the program has it.

        Parameters
        ----------
        frame
            A frame in which it pulls.

        Returns
        -------
        Pose
            Its target.
        """
        x, y, z = (float(value) for value in frame.hook_targets[frame.hook_index == self.number][0])
        return pose_at((x, y, z))

    def moved(self, frame: FrameConstraints, target: Pose) -> FrameConstraints:
        """Have it pull elsewhere.

        Parameters
        ----------
        frame
            A frame in which it pulls.
        target
            Where to.

        Returns
        -------
        FrameConstraints
            The frame.
        """
        targets = frame.hook_targets.copy()
        targets[frame.hook_index == self.number] = place_of(target)
        return replace(frame, hook_targets=targets)


@dataclass(frozen=True)
class HeldRetractor:
    """A retractor.

    Parameters
    ----------
    number
        Its number in `Program.retractors`.
    start
        Where it is when it takes hold.
    """

    number: int
    start: Pose

    def pulls(self, frame: FrameConstraints) -> bool:
        """Tell whether it holds in a frame.

        Parameters
        ----------
        frame
            The frame.

        Returns
        -------
        bool
            Whether it does.
        """
        return bool((frame.retractor_index == self.number).any())

    def own_target(self, frame: FrameConstraints) -> Pose:
        """Return where the program has it.

        Parameters
        ----------
        frame
            A frame in which it holds.

        Returns
        -------
        Pose
            Where it is.
        """
        motion = frame.retractor_motion[frame.retractor_index == self.number][0]
        return matrix_pose(motion @ pose_matrix(self.start))

    def moved(self, frame: FrameConstraints, target: Pose) -> FrameConstraints:
        """Have it elsewhere.

        Parameters
        ----------
        frame
            A frame in which it holds.
        target
            Where to.

        Returns
        -------
        FrameConstraints
            The frame.
        """
        motions = frame.retractor_motion.copy()
        motions[frame.retractor_index == self.number] = pose_matrix(target) @ np.linalg.inv(pose_matrix(self.start))
        return replace(frame, retractor_motion=motions)


def held_in(program: Program, procedure: Procedure, name: str) -> Held:
    """Find what is to be dragged.

    Parameters
    ----------
    program
        The program.
    procedure
        What it was made of.
    name
        Name of the event.

    Returns
    -------
    Held
        The hook or retractor.

    Raises
    ------
    RefusedError
        If there is none of that name.
    """
    if name in program.hooks:
        return HeldHook(program.hooks.index(name))
    if name in program.retractors:
        event = next(each for each in procedure.events if isinstance(each, Retractor) and each.name == name)
        start = RigidMotion(event.motion, event_path(event)).pose(event.start)
        return HeldRetractor(program.retractors.index(name), matrix_pose(start))
    raise refused(ProblemCode.LIVE_NO_HOOK, f"{TIMELINE}/{name}", name)
