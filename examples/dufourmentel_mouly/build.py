"""Builds dufourmentel_mouly.usda: Dufourmentel and Mouly's flap closes a rhombic defect on a flat patch of skin.

Usage: python build.py [dufourmentel_mouly.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.designs import Schedule, dufourmentel, flap_operation
from lappet.procedure import Procedure
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import write_procedure

SIDE, ANGLE, THICKNESS = 17.0, 66.0, 4.0  # mm, degrees, mm
SPACING = 1.0  # mm, of the lattice
WHEN = Schedule()


def build() -> Procedure:
    """The whole procedure."""
    tissue = flat_patch((116.0, 100.0, THICKNESS), resolution=2.0, spacing=SPACING)
    design = dufourmentel((0.0, 0.0, THICKNESS), (1.0, 0.0, 0.0), SIDE, ANGLE)
    return Procedure(
        tissue=tissue,
        materials=(SKIN.material,),
        events=flap_operation(design, SkinSheet.of(tissue), WHEN),
        start_time=1,
        end_time=WHEN.end,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("dufourmentel_mouly.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
