"""Builds dual_s_plasty.usda: two S-shaped flaps close an oval defect of 30 x 18 mm on a domed scalp.

Usage: python build.py [dual_s_plasty.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.designs import Row, Schedule, Technique, dual_s_plasty, flap_operation
from lappet.procedure import Procedure
from lappet.tissue.dome import dome_bone, dome_scalp, draped
from lappet.tissue.presets import SKIN
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import write_procedure

LENGTH, WIDTH, INCISION, ADVANCE = 30.0, 18.0, 42.0, 12.0  # mm
# The dome: radius of the head, the scalp's reach along it from the middle to the rim, its thickness, mm.
RADIUS, REACH, THICKNESS = 90.0, 62.0, 5.0  # mm
BONE, BONE_REACH = 84.9, 70.0  # mm: radius and reach of the skull's outer face, 0.1 mm below the scalp
SPACING = 1.1  # mm, of the lattice
WHEN = Schedule()
HOW = Technique(beyond=12.0, apart=3.2, rows=(Row("galea", 3.9), Row("dermal", 1.0, 0.5), Row("skin", 0.0)))


def build() -> Procedure:
    """The whole procedure."""
    tissue = dome_scalp(RADIUS, REACH, THICKNESS, resolution=2.0, spacing=SPACING)
    design = dual_s_plasty(
        (0.0, 0.0, RADIUS), (1.0, 0.0, 0.0), LENGTH, WIDTH, INCISION, ADVANCE, project=draped(RADIUS)
    )
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
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("dual_s_plasty.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
