"""Frames whose estimated error is too large for them to be trusted, and where: as a warning, not as a number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.surface_check import place
from lappet.program.program import Program
from lappet.solve.error_estimate import TRUSTED_SHARE, ErrorEstimate
from lappet.solve.frame_span import span_of
from lappet.solve.solve_frames import FrameResult


def untrusted(program: Program, frames: Sequence[FrameResult], errors: ErrorEstimate) -> list[Problem]:
    """Find the frames that are not to be trusted (`FrameErrorEstimate.is_trusted`).

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.
    errors
        Their estimated errors.

    Returns
    -------
    list[Problem]
        One warning that names the frames, and the place, at rest, and size of their greatest error; none where all are
        to be trusted.
    """
    doubted = [
        (frame.constraints.time, error)
        for frame, error in zip(frames, errors.frames, strict=True)
        if error is not None and not error.is_trusted
    ]
    if not doubted:
        return []
    time, worst = max(doubted, key=lambda each: each[1].greatest)
    spacing, share = program.settings.spacing, TRUSTED_SHARE * worst.largest_displacement
    most, of = (spacing, "the lattice spacing") if worst.greatest > spacing else (share, "of the largest displacement")
    if worst.greatest <= spacing:
        of = f"{TRUSTED_SHARE:.0%} {of}"
    where = "" if worst.place is None else f" near {place(np.round(worst.place, 2))} mm"
    return [
        problem(
            ProblemCode.ERROR_LARGE,
            span_of([each for each, _ in doubted]),
            f"{worst.greatest:.2g}",
            place=None if worst.place is None else Place.at(worst.place),
            where=where,
            time=time,
            most=most,
            of=of,
        )
    ]
