"""Tissue of several layers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Material, Procedure, Region
from lappet.procedure.prim_paths import MATERIALS
from lappet.tissue.presets.deep_tissue import FAT
from lappet.tissue.presets.skin import SKIN
from lappet.tissue.surface import skin_faces

FAT_FACES = "fat_below"


def skin_over_fat(
    procedure: Procedure, thickness: float, skin: Material = SKIN.material, fat: Material = FAT.material
) -> Procedure:
    """Lay skin over fat: the tissue is made of one material down to a depth and of another below.

    Materials of these names are replaced. The face subset `FAT_FACES` is added with a region, before all others, so
    that those win.

    Parameters
    ----------
    procedure
        The procedure.
    thickness
        Thickness of the skin in mm.
    skin
        Material of the skin.
    fat
        Material below.

    Returns
    -------
    Procedure
        The layered procedure.

    Raises
    ------
    ValueError
        If the thickness is not positive or both materials have one name.
    """
    if not (np.isfinite(thickness) and thickness > 0.0):
        raise refused(ProblemCode.LENGTH_NOT_POSITIVE, skin.name, f"{thickness:g}", name="thickness")
    if skin.name == fat.name:
        raise refused(ProblemCode.SKIN_FAT_NAME, MATERIALS, skin.name)
    tissue = procedure.tissue
    others = {name: faces for name, faces in tissue.subsets.items() if name != FAT_FACES}
    regions = [region for region in tissue.regions if region.faces != FAT_FACES]
    layered = replace(
        tissue,
        material=skin.name,
        subsets={FAT_FACES: np.flatnonzero(skin_faces(tissue)).astype(np.int32), **others},
        regions=(Region(FAT_FACES, fat.name, depth_from=thickness), *regions),
    )
    kept = [material for material in procedure.materials if material.name not in (skin.name, fat.name)]
    return replace(procedure, tissue=layered, materials=(skin, fat, *kept))
