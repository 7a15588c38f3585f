"""Flap and excision designs, drawn as points on the skin, and the operations that they make."""

from __future__ import annotations

from lappet.designs.flap_design import Carry, Edge, FlapDesign
from lappet.designs.fusiform_design import Fusiform, fusiform
from lappet.designs.geodesic_drape import draped_on
from lappet.designs.oval_outline import oval
from lappet.designs.rhombic_flap import dufourmentel, limberg
from lappet.designs.s_plasty import dual_s_plasty
from lappet.designs.transposition import Row, Schedule, Technique, flap_operation
from lappet.designs.z_plasty_design import ZPlasty, z_plasty

__all__ = [
    "Carry",
    "Edge",
    "FlapDesign",
    "Fusiform",
    "Row",
    "Schedule",
    "Technique",
    "ZPlasty",
    "draped_on",
    "dual_s_plasty",
    "dufourmentel",
    "flap_operation",
    "fusiform",
    "limberg",
    "oval",
    "z_plasty",
]
