"""The strands of muscles as the daemon is told them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lappet.cutting.epoch import Strands
from lappet.procedure import Material, Procedure


def strand_program(procedure: Procedure, materials: Sequence[Material]) -> Strands:
    """Lay out the strands of a procedure's muscles.

    Parameters
    ----------
    procedure
        The procedure.
    materials
        The table of materials that the strands index.

    Returns
    -------
    Strands
        The strands, muscle after muscle.
    """
    names = [material.name for material in materials]
    strands = [(names.index(muscle.material), strand) for muscle in procedure.muscles for strand in muscle.strands]
    if not strands:
        return Strands()
    counts = np.array([len(strand.points) for _, strand in strands])
    return Strands(
        start=(np.cumsum(counts) - counts).astype(np.int32),
        material=np.array([material for material, _ in strands], np.int32),
        points=np.array([point for _, strand in strands for point in strand.points], np.float64),
        radii=np.array([radius for _, strand in strands for radius in strand.radii], np.float64),
    )
