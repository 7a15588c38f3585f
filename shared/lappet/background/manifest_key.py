"""The key of a manifest: equal for equal procedures, settings and solvers, whoever computes it."""

from __future__ import annotations

from dataclasses import fields

from lappet.core.digest import digest
from lappet.procedure import Bone, Procedure, Tissue
from lappet.program.settings import SolverSettings, for_tissue, in_key


def manifest_key(procedure: Procedure, settings: SolverSettings, solver_identity: str) -> str:
    """Compute the key of a manifest: a hash of all values of the procedure and of what of the settings changes a frame.

    The names of events, materials and subsets and the order of the events take part; numbers count by value (1 as 1.0,
    -0 as 0), and the threads, which change no frame, not at all. The tissue and the bones are hashed once per object.

    Parameters
    ----------
    procedure
        The procedure.
    settings
        How to solve.
    solver_identity
        What identifies the solver, as for `lappet.program.keys.frame_keys`.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    settings = for_tissue(settings, procedure.tissue)
    choice = {item.name: getattr(settings, item.name) for item in fields(settings) if in_key(item.name)}
    return digest("manifest", solver_identity, choice, procedure, remember=(Tissue, Bone)).hex()
