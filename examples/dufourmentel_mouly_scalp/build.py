"""Builds dufourmentel_mouly_scalp.usda: Dufourmentel and Mouly's flap closes a rhombic defect of 66° on a scalp over a skull.

Usage: python build.py [dufourmentel_mouly_scalp.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.dome import dome_bone, dome_scalp, draped
from lappet.procedure import Material, Procedure
from lappet.rhombic_flap import dufourmentel
from lappet.skin_sheet import SkinSheet
from lappet.transposition import Row, Schedule, Technique, flap_operation
from lappet.usd_stage import write_procedure

SIDE, ANGLE = 14.0, 66.0  # mm, degrees
RADIUS, REACH, THICKNESS = 80.0, 52.0, 5.0  # mm: of the head, along the scalp from the middle to the rim, of the scalp
BONE, BONE_REACH = 74.9, 60.0  # mm: radius and reach of the skull; the scalp glides 0.1 mm above it
SPACING = 1.0  # mm, of the lattice
WHEN = Schedule()
HOW = Technique(beyond=12.0, apart=3.2, rows=(Row("galea", 3.9), Row("dermal", 1.9, 0.5), Row("skin", 0.0)))


def build() -> Procedure:
    """The whole procedure."""
    tissue = dome_scalp(RADIUS, REACH, THICKNESS, resolution=2.0, spacing=SPACING)
    design = dufourmentel((0.0, 0.0, RADIUS), (1.0, 0.0, 0.0), SIDE, ANGLE, project=draped(RADIUS))
    return Procedure(
        tissue=tissue,
        materials=(Material("skin", model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45),),
        events=flap_operation(design, SkinSheet.of(tissue), WHEN, HOW),
        bones=(dome_bone(BONE, BONE_REACH),),
        start_time=1,
        end_time=WHEN.end,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("dufourmentel_mouly_scalp.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
