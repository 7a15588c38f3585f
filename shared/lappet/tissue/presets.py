"""Materials to start from, each with where its numbers come from; and skin over fat.

Where nothing was measured the source says so. Moduli are kPa, lengths mm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Material, Procedure, Region
from lappet.procedure.prim_paths import MATERIALS
from lappet.tissue.surface import skin_faces

FAT_FACES = "fat_below"


@dataclass(frozen=True)
class Preset:
    """A material and its source.

    Parameters
    ----------
    material
        The material.
    source
        Where its numbers come from.
    measured
        Whether its stiffness was fitted to measurements of that tissue.
    """

    material: Material
    source: str
    measured: bool


def _of_shear_modulus(mu: float, poissons_ratio: float) -> float:
    return 2.0 * mu * (1.0 + poissons_ratio)


SKIN = Preset(
    Material("skin", model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45, density=1100.0),
    "Not measured: a modulus of the order of skin at small stretch, which neither stiffens nor has a direction. No "
    "measured parameters of the human scalp were found.",
    measured=False,
)
TAUT_SKIN = Preset(
    replace(SKIN.material, name="taut_skin", prestretch=(1.1, 1.05)),
    "Not measured: skin under a mild tension, stretched in vivo by a tenth along its direction, half as much "
    "across. It parts when it is cut, and takes up what a flap gives. Turn the direction to Langer's lines.",
    measured=False,
)
DERMIS_OF_THE_BACK = Preset(
    Material(
        "dermis",
        model="neoHookean",
        youngs_modulus=_of_shear_modulus(201.4, 0.49),
        poissons_ratio=0.49,
        fiber_k1=243.6 * 201.4,
        fiber_k2=0.1327,
        fiber_dispersion=0.1404,
        density=1100.0,
    ),
    "Ní Annaidh et al. 2012, Ann Biomed Eng 40:1666, doi 10.1007/s10439-012-0542-3: excised skin of the human back. "
    "mu 0.2014 MPa, k1 243.6, k2 0.1327, kappa 0.1404. The paper gives k1 without a unit; it is taken in units of mu: "
    "along the fibers that makes a modulus of 4 (1 - 3 kappa)^2 k1 = 66 MPa, and 83 ± 35 MPa were measured; as MPa it "
    "would be 327. Poisson's ratio and density were not measured. Turn the fiber direction to Langer's lines.",
    measured=True,
)
FAT = Preset(
    Material(
        "fat", model="neoHookean", youngs_modulus=_of_shear_modulus(0.53, 0.49), poissons_ratio=0.49, density=920.0
    ),
    "Sims et al. 2010, Biomech Model Mechanobiol 9:703, doi 10.1007/s10237-010-0207-9: subdermal fat of pigs, "
    "neo-Hookean, mu 0.53 ± 0.31 kPa. Poisson's ratio and density are not measured there.",
    measured=True,
)
PRESETS = {preset.material.name: preset for preset in (SKIN, TAUT_SKIN, DERMIS_OF_THE_BACK, FAT)}


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
