"""Frames whose equilibrium is not the only one, or nearly not one: what a solve says about their stability."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.surface_check import place
from lappet.solve.frame_span import span_of
from lappet.solve.solve_frames import FrameResult

if TYPE_CHECKING:
    from lappet.solve.error_estimate import FrameErrorEstimate

SENSITIVE = 0.05
"""Chosen: an equilibrium is sensitive where compression leaves a displacement less than this share of its stiffness."""


UNSTABLE = -1e-3
"""Chosen, as in the daemon: an equilibrium is unstable where less is left; more may be the rounding of float."""


def is_sensitive(frame: SolvedFrame) -> bool:
    """Tell whether a small change of the procedure may move the tissue of a frame a long way.

    Parameters
    ----------
    frame
        The frame.

    Returns
    -------
    bool
        Whether its softest displacement keeps less than `SENSITIVE` of its stiffness; false where it is not known.
    """
    return frame.converged and frame.diagnostics.lowest_stiffness < SENSITIVE


def stability_notes(frames: Sequence[FrameResult]) -> list[Problem]:
    """Say which frames are unstable, sensitive, or one of several that the same constraints allow.

    Parameters
    ----------
    frames
        Solved frames.

    Returns
    -------
    list[Problem]
        A warning of unstable frames, a note of sensitive ones, each with the place that moves most, and a note of
        those that were found by leaving an unstable equilibrium.
    """
    solved = [frame.solved for frame in frames if frame.solved.converged]
    unstable = [frame for frame in solved if frame.diagnostics.lowest_stiffness < UNSTABLE]
    sensitive = [frame for frame in solved if is_sensitive(frame) and not frame.diagnostics.lowest_stiffness < UNSTABLE]
    left = [frame for frame in solved if frame.diagnostics.saddles_left > 0]
    found = [_softest(code, of) for code, of in ((ProblemCode.FRAMES_UNSTABLE, unstable),
             (ProblemCode.FRAMES_SENSITIVE, sensitive)) if of]  # fmt: skip
    if left:
        count = sum(frame.diagnostics.saddles_left for frame in left)
        found.append(problem(ProblemCode.FRAMES_LEFT_SADDLES, span_of([frame.time for frame in left]), count))
    return found


def several_notes(frames: Sequence[FrameResult], errors: Sequence[FrameErrorEstimate | None]) -> list[Problem]:
    """Say which frames are one of several equilibria, as a coarser lattice shows.

    Parameters
    ----------
    frames
        Solved frames.
    errors
        Their estimated errors.

    Returns
    -------
    list[Problem]
        A warning that names the frames, and the greatest distance between two equilibria with its place; or nothing.
    """
    several = [
        (frame.constraints.time, error.other_branch)
        for frame, error in zip(frames, errors, strict=True)
        if error is not None and error.other_branch is not None
    ]
    if not several:
        return []
    time, farthest = max(several, key=lambda each: each[1].distance)
    return [
        problem(
            ProblemCode.FRAMES_ONE_OF_SEVERAL,
            span_of([each for each, _ in several]),
            f"{farthest.distance:.2g}",
            place=Place.at(farthest.place),
            where=f" near {place(np.round(farthest.place, 2))} mm",
            time=time,
        )
    ]


def _softest(code: ProblemCode, frames: Sequence[SolvedFrame]) -> Problem:
    softest = min(frames, key=lambda frame: frame.diagnostics.lowest_stiffness)
    points = softest.softest_point
    return problem(
        code,
        span_of([frame.time for frame in frames]),
        f"{softest.diagnostics.lowest_stiffness:.1%}",
        place=Place.at(points[0]) if len(points) else None,
        where=f" near {place(np.round(points[0], 2))} mm" if len(points) else "",
        time=softest.time,
    )
