"""The same tissue without what holds its rim, as if nothing went on beyond it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Procedure, Tissue
from lappet.procedure.prim_paths import TISSUE


def with_free_rim(procedure: Procedure) -> Procedure:
    """Let the rim of a procedure's tissue go.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    Procedure
        The same, with the faces of "fixed" held no more that are rim; a bed, bones and rollers hold as before.

    Raises
    ------
    RefusedError
        If no rim is held, nothing else holds the tissue, or it is stretched at its rim: without the rim its tension
        would go, which the tissue beyond keeps up.
    """
    tissue = procedure.tissue
    held, bed = _faces(tissue, "fixed"), _faces(tissue, "bed")
    rim = _faces(tissue, "rim") if "rim" in tissue.subsets else np.setdiff1d(held, bed)
    freed, rest = np.intersect1d(held, rim), np.setdiff1d(held, rim)
    if not len(freed):
        raise refused(ProblemCode.SURROUNDINGS_NO_RIM, TISSUE, "fixed")
    if not (len(rest) or len(bed) or procedure.bones or tissue.rollers):
        raise refused(ProblemCode.SURROUNDINGS_NOT_HELD, TISSUE, "bed")
    stretched = _stretched_at(procedure, freed)
    if stretched:
        raise refused(ProblemCode.SURROUNDINGS_STRETCHED, TISSUE, stretched)
    kept = {name: faces for name, faces in tissue.subsets.items() if name != "fixed"}
    kept |= {"rim": rim, "underside": _faces(tissue, "underside") if "underside" in tissue.subsets else bed}
    if len(rest):
        kept["fixed"] = rest
    return replace(procedure, tissue=replace(tissue, subsets=kept))


def _faces(tissue: Tissue, subset: str) -> NDArray[np.int32]:
    return np.asarray(tissue.subsets.get(subset, ()), np.int32)


def _stretched_at(procedure: Procedure, faces: NDArray[np.int32]) -> str:
    """The name of what is stretched at rest at some faces; empty where nothing is."""
    tissue = procedure.tissue
    there = {tissue.material} | {
        region.material for region in tissue.regions if np.isin(faces, _faces(tissue, region.faces)).any()
    }
    for material in procedure.materials:
        if material.name in there and material.has_prestretch:
            return material.name
    return next((line.name for line in procedure.skin_lines if any(line.tension or ())), "")
