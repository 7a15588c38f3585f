"""What is measured at the frames of a solve: forces of sutures and hooks, seams, and the tension of the skin."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program
from lappet.solve.force_sums import ForceSums, force_sums
from lappet.solve.hook_forces import HookForce, hook_forces
from lappet.solve.mean_tension import MeanTension, greatest_mean_tension
from lappet.solve.seam_measures import SeamGauges, SeamState
from lappet.solve.suture_forces import SutureForce, suture_forces


@dataclass(frozen=True, eq=False)
class FrameMeasures:
    """What is measured at a frame.

    Parameters
    ----------
    sutures
        The force on each suture.
    sums
        These summed up; None where no suture is placed.
    hooks
        The force of each hook.
    seams
        The seams.
    mean_tension
        The greatest mean tension of the skin; None where it is not known or not wanted.
    """

    sutures: tuple[SutureForce, ...] = ()
    sums: ForceSums | None = None
    hooks: tuple[HookForce, ...] = ()
    seams: tuple[SeamState, ...] = ()
    mean_tension: MeanTension | None = None


class Gauges:
    """Measure frames of a program, or of another one of the same surfaces and constraints.

    Parameters
    ----------
    program
        The program.
    """

    def __init__(self, program: Program) -> None:
        self._program = program
        self._seams = SeamGauges(program)

    def measure(self, frame: SolvedFrame, *, tension: bool = False) -> FrameMeasures:
        """Measure a frame.

        Parameters
        ----------
        frame
            The frame.
        tension
            Whether the greatest mean tension is wanted.

        Returns
        -------
        FrameMeasures
            What is measured.
        """
        sutures = suture_forces(self._program, frame)
        seams = self._seams.measure(frame, sutures)
        found = None
        if tension:
            epoch = next(each.epoch for each in self._program.frames if each.time == frame.time)
            surface = next(each.surface for each in self._program.epochs if each.index == epoch)
            found = greatest_mean_tension(surface, frame.tension)
        return FrameMeasures(
            tuple(sutures),
            force_sums(sutures, seams) if sutures else None,
            tuple(hook_forces(self._program, frame)),
            tuple(seams),
            found,
        )
