"""Where the parts of a procedure lie on its USD stage: prim paths."""

from __future__ import annotations

ROOT = "/Procedure"


TISSUE = f"{ROOT}/Tissue"


BONE = f"{ROOT}/Bone"


MATERIALS = f"{ROOT}/Materials"


SKIN_LINES = f"{ROOT}/SkinLines"


ANATOMY = f"{ROOT}/Anatomy"
MUSCLES = f"{ROOT}/Muscles"
SCENERY = f"{ROOT}/Scenery"
FLAPS = f"{ROOT}/Flaps"
PLATES = f"{ROOT}/Plates"


TIMELINE = f"{ROOT}/Timeline"
