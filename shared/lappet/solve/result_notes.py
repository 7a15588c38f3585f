"""What is said of solved frames besides their measures: how they were found, and what is suspicious in them."""

from __future__ import annotations

from collections.abc import Sequence

from lappet.core.problem import Problem
from lappet.program.program import Program
from lappet.solve.fallbacks import fallbacks
from lappet.solve.held_apart import held_apart_notes
from lappet.solve.held_back import held_back_notes
from lappet.solve.overlaps import overlap_notes
from lappet.solve.sensitive import stability_notes
from lappet.solve.solve_frames import FrameResult


def result_notes(program: Program, frames: Sequence[FrameResult]) -> list[Problem]:
    """Say what is to be said of frames.

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.

    Returns
    -------
    list[Problem]
        Warnings and notes.
    """
    return [
        *fallbacks(program, frames),
        *stability_notes(frames),
        *overlap_notes(program, frames),
        *held_back_notes(program, frames),
        *held_apart_notes(program, frames),
    ]
