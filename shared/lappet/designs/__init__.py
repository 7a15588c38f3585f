"""Flap and excision designs, drawn as points on the skin, and the operations that they make."""

from __future__ import annotations

from lappet.designs.fitted_design import Fitted, fit_to_defect
from lappet.designs.flap_design import Carry, Edge, Excised, FlapDesign
from lappet.designs.fusiform_design import Fusiform, fusiform
from lappet.designs.geodesic_drape import draped_on
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.laid_flaps import changed_flap, laid_flap, relay
from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import add_flap, flap_on_patch
from lappet.designs.oval_outline import oval
from lappet.designs.rhombic_flap import dufourmentel, limberg
from lappet.designs.s_plasty import dual_s_plasty
from lappet.designs.technique import Row, Schedule, Technique
from lappet.designs.transposition import flap_operation
from lappet.designs.z_plasty_design import ZPlasty, z_plasty

__all__ = [
    "DESIGNS",
    "Carry",
    "Edge",
    "Excised",
    "Fitted",
    "FlapDesign",
    "Fusiform",
    "Row",
    "Schedule",
    "Technique",
    "ZPlasty",
    "add_flap",
    "changed_flap",
    "draped_on",
    "dual_s_plasty",
    "dufourmentel",
    "fit_to_defect",
    "flap_on_patch",
    "flap_on_skin",
    "flap_operation",
    "fusiform",
    "laid_flap",
    "limberg",
    "oval",
    "relay",
    "z_plasty",
]
