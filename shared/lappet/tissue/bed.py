"""The bed below skin: its stiffness from the modulus and the thickness of the layer that joins it to what is deeper.

A layer of thickness t between skin and a rigid floor gives way by its shear modulus G in its plane and, being much
wider than thick, by its oedometric modulus M along its normal:

    shear = G / t,   normal = M / t,   M = 2 G (1 - nu) / (1 - 2 nu).
"""

from __future__ import annotations

from dataclasses import dataclass

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Tissue


@dataclass(frozen=True)
class Bed:
    """The stiffness of a bed.

    Parameters
    ----------
    normal
        Along its normal in kPa/mm: `Tissue.bed_stiffness`.
    shear
        In its plane in kPa/mm: `Tissue.bed_shear`.
    """

    normal: float
    shear: float


def bed_of(shear_modulus: float, thickness: float, poissons_ratio: float = 0.49) -> Bed:
    """Derive a bed from the layer below the skin.

    Parameters
    ----------
    shear_modulus
        Shear modulus of the layer in kPa.
    thickness
        Thickness of the layer in mm.
    poissons_ratio
        Its Poisson's ratio; 0.49 is chosen.

    Returns
    -------
    Bed
        The bed.

    Raises
    ------
    RefusedError
        If the thickness is not positive.
    """
    if not 0.0 < thickness < float("inf"):
        raise refused(ProblemCode.LENGTH_NOT_POSITIVE, "bed", f"{thickness:g}", name="thickness")
    oedometric = 2.0 * shear_modulus * (1.0 - poissons_ratio) / (1.0 - 2.0 * poissons_ratio)
    return Bed(oedometric / thickness, shear_modulus / thickness)


# Fat of 0.75 kPa (magnetic resonance elastography of the buttocks of ten women, "Strain-dependent shear properties of
# human adipose tissue in vivo", J Mech Behav Biomed Mater 2023). 2 mm are those of the forehead (Iyengar et al. 2018,
# Dermatol Surg 44:855), 6 mm those of the temple (there too). Tight: dense septa, chosen.
BEDS = {
    "default": Bed(Tissue.bed_stiffness, Tissue.bed_shear),
    "loose": bed_of(0.75, 6.0),
    "tight": bed_of(5.0, 1.0),
}
