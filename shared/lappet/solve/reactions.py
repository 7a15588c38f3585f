"""The force of whatever holds or loads the tissue: fixed faces, retractors, bed, bones, rollers, loads on faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lappet.daemon.solved_frame import HOLDERS, SolvedFrame
from lappet.program.program import Program


@dataclass(frozen=True)
class Reaction:
    """The force of one thing that holds or loads the tissue in one frame, a row of the table.

    Parameters
    ----------
    time
        Time code.
    holder
        What it is: one of `lappet.daemon.solved_frame.HOLDERS`. The weak bed holds what nothing else does.
    name
        Its name: of a part of the fixed faces, a retractor, or the faces that slide or are loaded; else as the holder.
    force_mn
        Its length in mN.
    force_x_mn, force_y_mn, force_z_mn
        The force on the tissue in mN. With the weight and the forces of the hooks they are in balance.
    """

    time: float
    holder: str
    name: str
    force_mn: float
    force_x_mn: float
    force_y_mn: float
    force_z_mn: float


def reactions(program: Program, frame: SolvedFrame) -> list[Reaction]:
    """List what holds and loads the tissue in a frame, and its forces.

    Parameters
    ----------
    program
        The program.
    frame
        A frame of it.

    Returns
    -------
    list[Reaction]
        A row for each.
    """
    named = {
        "fixed": program.fixed_parts,
        "retractor": program.retractors,
        "roller": program.rollers,
        "load": program.loads,
    }
    rows = []
    for (kind, number), force in zip(frame.holders.tolist(), frame.reactions.astype(np.float64), strict=True):
        holder = HOLDERS[kind]
        names = named.get(holder, ())
        name = names[number] if number < len(names) else holder
        rows.append(Reaction(frame.time, holder, name, float(np.linalg.norm(force)), *force.tolist()))
    return rows
