"""What the report of a solve says of vessels: how long they are, how far they are stretched, where they are divided."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import FrameConstraints, Program


def vessel_summary(program: Program) -> list[dict[str, Any]]:
    """List the vessels with where incisions divide them.

    Parameters
    ----------
    program
        The program.

    Returns
    -------
    list[dict[str, Any]]
        For each vessel its name, label, kind, radius in mm, whether it is a typical course, and its crossings: the
        incision, its time code, how far along it and how deep below the skin in mm, and the place at rest.
    """
    return [
        {
            "name": vessel.name,
            "label": vessel.label,
            "kind": vessel.kind,
            "radius_mm": vessel.radius,
            "typical_course": vessel.typical_course,
            "crossings": [
                {
                    "incision": each.incision,
                    "time_code": each.time,
                    "along_mm": each.along,
                    "depth_mm": each.depth,
                    "point_mm": each.point,
                }
                for each in program.vessel_crossings
                if each.vessel == number
            ],
        }
        for number, vessel in enumerate(program.vessels)
    ]


def vessel_lengths(program: Program, constraints: FrameConstraints, frame: SolvedFrame) -> dict[str, dict[str, float]]:
    """Measure what a frame holds of each vessel.

    Parameters
    ----------
    program
        The program.
    constraints
        Those of the frame, which name its epoch.
    frame
        The solved frame.

    Returns
    -------
    dict[str, dict[str, float]]
        By name of the vessel: the number of its pieces, their length in mm, and their stretch, which is that length by
        the same at rest. A vessel all of which is excised is left out.
    """
    found = (k for k, epoch in enumerate(program.epochs) if epoch.index == constraints.epoch)
    pieces = program.vessels_at[next(found)] if program.vessels_at else VesselPieces()
    now, rest = _lengths(pieces.split(frame.vessel_points)), _lengths(pieces.split(pieces.points))
    measured = {}
    for number in np.unique(pieces.vessel):
        own = pieces.vessel == number
        length = float(now[own].sum())
        stretch = length / float(rest[own].sum())
        measured[program.vessels[number].name] = {"pieces": int(own.sum()), "length_mm": length, "stretch": stretch}
    return measured


def _lengths(lines: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Length of each polyline (k, 3)."""
    return np.array([np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines])
