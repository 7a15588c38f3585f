"""Tissue that a solve has carried into other tissue: nothing keeps them apart yet, so it is said."""

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
    """Find tissue that lies in other tissue in the last frame.

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.

    Returns
    -------
    list[Problem]
        A warning that counts the vertices that lie deeper than `SHALLOW` in tissue, with the place of the deepest, at
        rest and in the frame; none where there are none.
    """
    if not frames:
        return []
    last = frames[-1]
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
