"""Sutures whose ends stay apart where tissue touches tissue: with self-contact walls that do not fit hold them so."""

from __future__ import annotations

from collections.abc import Sequence

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.program.program import Program
from lappet.solve.contact_reach import contact_reach
from lappet.solve.solve_frames import FrameResult

# Of the distance from which on surfaces press on each other: so far apart a suture has closed, as the daemon has it.
_CLOSED = 1.25


def held_apart_notes(program: Program, frames: Sequence[FrameResult]) -> list[Problem]:
    """Find the suture that tissue between its ends holds open the farthest.

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.

    Returns
    -------
    list[Problem]
        With self-contact a note of the suture with the largest gap in a converged frame in which tissue touches, if
        that is more than sutures leave where walls touch: how large it is, and how many sutures more are held open
        so. Else none.
    """
    if not program.settings.self_contact:
        return []
    settings = program.settings
    closed = _CLOSED * contact_reach(settings.spacing) + settings.gap_tolerance * settings.spacing
    largest: dict[int, tuple[float, float]] = {}  # gap and time, by suture
    for frame in frames:
        if not frame.solved.converged or not frame.solved.diagnostics.self_contacts:
            continue
        for index, gap in zip(frame.solved.suture_index.tolist(), frame.solved.suture_gaps.tolist(), strict=True):
            if gap > largest.get(index, (closed, 0.0))[0]:
                largest[index] = (gap, frame.constraints.time)
    if not largest:
        return []
    index, (gap, time) = max(largest.items(), key=lambda each: each[1][0])
    return [
        problem(
            ProblemCode.SUTURE_HELD_APART,
            f"/Procedure/Timeline/{program.sutures[index]}",
            f"{gap:.2g}",
            time=time,
            others=f"; so are {len(largest) - 1} more" if len(largest) > 1 else "",
        )
    ]
