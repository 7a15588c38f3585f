"""Builds rhomboid_scalp.usda: Limberg's flap closes a rhombic defect with sides of 12 mm on a domed scalp.

Usage: python build.py [rhomboid_scalp.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.designs import Row, Schedule, Technique, flap_operation, limberg
from lappet.procedure import Procedure
from lappet.tissue.dome import dome_bone, dome_scalp, draped
from lappet.tissue.presets import SKIN
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import write_procedure

SIDE = 12.0  # mm
# The dome: radius of the head, the scalp's reach along it from the middle to the rim, its thickness, mm.
RADIUS, REACH, THICKNESS = 90.0, 48.0, 6.0  # mm
BONE, BONE_REACH = 83.9, 56.0  # mm: radius and reach of the skull's outer face, 0.1 mm below the scalp
SPACING = 1.0  # mm, of the lattice
WHEN = Schedule()
HOW = Technique(beyond=10.0, apart=2.6, rows=(Row("galea", 4.7), Row("dermal", 1.0, 0.5), Row("skin", 0.0)))


def build() -> Procedure:
    """The whole procedure."""
    tissue = dome_scalp(RADIUS, REACH, THICKNESS, resolution=2.0, spacing=SPACING)
    design = limberg((0.0, 0.0, RADIUS), (1.0, 0.0, 0.0), SIDE, project=draped(RADIUS))
    return Procedure(
        tissue=tissue,
        materials=(SKIN.material,),
        events=flap_operation(design, SkinSheet.of(tissue), WHEN, HOW),
        bones=(dome_bone(BONE, BONE_REACH),),
        start_time=1,
        end_time=WHEN.end,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("rhomboid_scalp.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
