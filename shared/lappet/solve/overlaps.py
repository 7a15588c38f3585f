"""Tissue that lies in other tissue: without self-contact nothing keeps it apart, and with it only what begins apart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.self_overlap import self_overlap
from lappet.geometry.surface_check import place
from lappet.program.program import Program
from lappet.solve.solve_frames import FrameResult

SHALLOW = 0.25
"""Chosen: overlaps of at most this share of the lattice spacing are not warned about.

The walls of any closed wound lie that deep in each other: the lattice holds them together between its nodes only.
"""


def overlap_notes(program: Program, frames: Sequence[FrameResult]) -> list[Problem]:
    """Find tissue that lies in other tissue in the last frame, or lay in it where frames began.

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.

    Returns
    -------
    list[Problem]
        With self-contact a warning where frames started from a surface that passes through itself, with the first of
        them and the number of places, and a note where it was taken apart first. A warning that counts the vertices
        that lie deeper than `SHALLOW` in tissue, with the place of the deepest, at rest and in the frame. None where
        there are none.
    """
    if not frames:
        return []
    return _pierced(frames) + _deep(program, frames[-1])


def _pierced(frames: Sequence[FrameResult]) -> list[Problem]:
    said = [(frame.constraints.time, frame.solved.diagnostics) for frame in frames]
    starts = {
        ProblemCode.FRAMES_START_PIERCED: [
            (time, left) for time, each in said if (left := each.piercings_before - each.untangled) > 0
        ],
        ProblemCode.FRAMES_UNTANGLED: [(time, each.untangled) for time, each in said if each.untangled > 0],
    }
    result = []
    for code, found in starts.items():
        if not found:
            continue
        (time, count), more = found[0], len(found) - 1
        others = f", and likewise in {more} other frames" if more else ""
        result.append(problem(code, "", count, time=time, count=count, others=others))
    return result


def _deep(program: Program, last: FrameResult) -> list[Problem]:
    epoch = next(each for each in program.epochs if each.index == last.constraints.epoch)
    found = self_overlap(last.solved.points, epoch.surface.triangles)
    deep = found.depth > SHALLOW * program.settings.spacing
    if not deep.any():
        return []
    deepest = found.vertices[np.argmax(found.depth)]
    rest = np.asarray(epoch.surface.points[deepest], float)
    return [
        problem(
            ProblemCode.TISSUE_IN_TISSUE,
            "",
            f"{found.depth.max():.2g}",
            place=Place.at(rest),
            time=last.constraints.time,
            count=int(np.count_nonzero(deep)),
            where=place(np.round(rest, 2)),
            now=place(np.round(np.asarray(last.solved.points[deepest], float), 2)),
        )
    ]
