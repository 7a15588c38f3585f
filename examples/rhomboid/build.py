"""Builds rhomboid.usda: Limberg's flap closes a rhombic defect with sides of 18 mm on a flat patch of 120 x 104 x 4 mm.

Usage: python build.py [rhomboid.usda]
"""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.designs import Schedule, flap_operation, limberg
from lappet.procedure import Procedure
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import write_procedure

SIDE, THICKNESS = 18.0, 4.0  # mm
SPACING = 1.0  # mm, of the lattice
WHEN = Schedule()


def build() -> Procedure:
    """The whole procedure."""
    tissue = flat_patch((120.0, 104.0, THICKNESS), resolution=2.0, spacing=SPACING)
    design = limberg((0.0, 0.0, THICKNESS), (1.0, 0.0, 0.0), SIDE)
    return Procedure(
        tissue=tissue,
        materials=(SKIN.material,),
        events=flap_operation(design, SkinSheet.of(tissue), WHEN),
        start_time=1,
        end_time=WHEN.end,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("rhomboid.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
