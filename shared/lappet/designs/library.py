"""The flap library: every design by its name."""

from __future__ import annotations

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.a_t_plasty import A_T_PLASTY
from lappet.designs.advancement_flap import H_PLASTY, U_PLASTY
from lappet.designs.back_cut_rotation_flap import ROTATION_BACK_CUT
from lappet.designs.bilobed_flap import BILOBED
from lappet.designs.cervicofacial_flap import CERVICOFACIAL
from lappet.designs.crescentic_advancement_flap import CRESCENTIC
from lappet.designs.dorsal_nasal_flap import DORSAL_NASAL
from lappet.designs.double_keystone_flap import KEYSTONE_III
from lappet.designs.five_flap_z_plasty import FIVE_FLAP_Z_PLASTY
from lappet.designs.four_flap_z_plasty import FOUR_FLAP_Z_PLASTY
from lappet.designs.fusiform_excision import FUSIFORM, S_EXCISION
from lappet.designs.grafted_keystone_flap import KEYSTONE_II
from lappet.designs.island_v_y import ISLAND_V_Y
from lappet.designs.karapandzic_flap import KARAPANDZIC
from lappet.designs.keystone_flap import KEYSTONE
from lappet.designs.library_design import LibraryDesign
from lappet.designs.multiple_rhombic_flaps import DOUBLE_RHOMBIC, TRIPLE_RHOMBIC
from lappet.designs.multiple_z_plasty import MULTIPLE_Z_PLASTY
from lappet.designs.nasolabial_flap import NASOLABIAL
from lappet.designs.note_flap import NOTE_FLAP
from lappet.designs.o_t_plasty import O_T_PLASTY
from lappet.designs.o_z_plasty import O_Z_PLASTY
from lappet.designs.paramedian_forehead_flap import PARAMEDIAN_FOREHEAD
from lappet.designs.rhombic_flap import DUFOURMENTEL, LIMBERG
from lappet.designs.rotation_advancement import MILLARD
from lappet.designs.rotation_flap import ROTATION
from lappet.designs.round_excision import ROUND_EXCISION
from lappet.designs.s_plasty import DUAL_S_PLASTY
from lappet.designs.trilobed_flap import TRILOBED
from lappet.designs.upper_lid_excision import UPPER_LID
from lappet.designs.v_y_plasty import V_Y_PLASTY, Y_V_PLASTY
from lappet.designs.w_plasty_design import W_PLASTY
from lappet.designs.webster_flap import WEBSTER
from lappet.designs.z_plasty_flaps import Z_PLASTY

# In the order of a textbook: excisions, scar revisions, transposition, rotation, advancement.
DESIGNS = {
    design.name: design
    for design in (
        FUSIFORM,
        S_EXCISION,
        ROUND_EXCISION,
        UPPER_LID,
        W_PLASTY,
        Z_PLASTY,
        MULTIPLE_Z_PLASTY,
        FOUR_FLAP_Z_PLASTY,
        FIVE_FLAP_Z_PLASTY,
        LIMBERG,
        DUFOURMENTEL,
        WEBSTER,
        DOUBLE_RHOMBIC,
        TRIPLE_RHOMBIC,
        NOTE_FLAP,
        BILOBED,
        TRILOBED,
        NASOLABIAL,
        DORSAL_NASAL,
        PARAMEDIAN_FOREHEAD,
        ROTATION,
        ROTATION_BACK_CUT,
        CERVICOFACIAL,
        O_Z_PLASTY,
        DUAL_S_PLASTY,
        U_PLASTY,
        H_PLASTY,
        A_T_PLASTY,
        O_T_PLASTY,
        CRESCENTIC,
        V_Y_PLASTY,
        Y_V_PLASTY,
        ISLAND_V_Y,
        KEYSTONE,
        KEYSTONE_II,
        KEYSTONE_III,
        MILLARD,
        KARAPANDZIC,
    )
}


def library_design(name: str) -> LibraryDesign:
    """Look up a design.

    Parameters
    ----------
    name
        Its name.

    Returns
    -------
    LibraryDesign
        The design.

    Raises
    ------
    RefusedError
        If the library has none of that name.
    """
    if name not in DESIGNS:
        raise refused(ProblemCode.DESIGN_UNKNOWN, "", name, known=", ".join(DESIGNS))
    return DESIGNS[name]
