"""Stitches with a bite in tissue that a thinning takes away: they come out with it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.procedure import Suture
from lappet.procedure.prim_paths import TIMELINE
from lappet.tissue.rest_space import RestSpace

_SHOWN = 20  # places of a warning


def out_from(epochs: Sequence[Epoch], sutures: Sequence[Suture]) -> tuple[NDArray[np.float64], list[Problem]]:
    """Find when sutures come out because the tissue at one of their bites is thinned away.

    Parameters
    ----------
    epochs
        The epochs, in order.
    sutures
        The sutures.

    Returns
    -------
    tuple[NDArray[np.float64], list[Problem]]
        Time code from which each is out, shape (n,), infinite for those that stay; and a warning for each thinning that
        takes stitches along.
    """
    out = np.full(len(sutures), np.inf)
    said: list[Problem] = []
    for epoch in epochs:
        before = [k for k, suture in enumerate(sutures) if suture.start < epoch.start_time < out[k]]
        for gone in epoch.thinned if before else ():
            bites = [np.asarray(sutures[k].anchors, np.float64) for k in before]
            inside = RestSpace(gone.points, gone.triangles).outside(np.concatenate(bites)) <= 0.0
            ends = np.cumsum([len(each) for each in bites])[:-1]
            taken = [k for k, within in zip(before, np.split(inside, ends), strict=True) if within.any()]
            out[taken] = epoch.start_time
            if taken:
                place = Place.at(*(sutures[k].anchors[0] for k in taken[:_SHOWN]))
                code, prim = ProblemCode.PROGRAM_STITCHES_THINNED, f"{TIMELINE}/{gone.name}"
                said.append(problem(code, prim, len(taken), place=place, time=epoch.start_time))
    return out, said
