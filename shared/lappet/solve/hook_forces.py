"""The force of each hook on the tissue."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program


@dataclass(frozen=True)
class HookForce:
    """The force of one hook in one frame, a row of the table.

    Parameters
    ----------
    time
        Time code.
    hook
        Name of the hook.
    force_mn
        Its pull in mN.
    force_x_mn, force_y_mn, force_z_mn
        Its force on the tissue in mN.
    force_error_mn
        Estimated error of its pull in mN, or None without an estimate.
    """

    time: float
    hook: str
    force_mn: float
    force_x_mn: float
    force_y_mn: float
    force_z_mn: float
    force_error_mn: float | None = None


def hook_forces(program: Program, frame: SolvedFrame) -> list[HookForce]:
    """List the forces of the hooks of a frame.

    Parameters
    ----------
    program
        The program.
    frame
        A frame of it.

    Returns
    -------
    list[HookForce]
        A row for each hook that acts.
    """
    forces = frame.hook_forces.astype(np.float64)
    names = [program.hooks[i] for i in frame.hook_index]
    return [
        HookForce(frame.time, name, float(np.linalg.norm(force)), *force.tolist())
        for name, force in zip(names, forces, strict=True)
    ]
