"""Materials to start from, each with where its numbers come from; and skin over fat.

Where nothing was measured the source says so.
"""

from __future__ import annotations

from lappet.tissue.presets.deep_tissue import CARTILAGE, DEEP_TISSUES, FAT, GALEA, MUSCLE, TARSUS
from lappet.tissue.presets.layers import FAT_FACES, skin_over_fat
from lappet.tissue.presets.preset import CHOSEN, SOURCES, Preset, PublishedCurve, Sourced
from lappet.tissue.presets.skin import SKIN, SKINS, TAUT_SKIN

PRESETS = {preset.unstretched.name: preset for preset in (*SKINS, *DEEP_TISSUES)}

__all__ = [
    "CARTILAGE",
    "CHOSEN",
    "FAT",
    "FAT_FACES",
    "GALEA",
    "MUSCLE",
    "PRESETS",
    "SKIN",
    "SOURCES",
    "TARSUS",
    "TAUT_SKIN",
    "Preset",
    "PublishedCurve",
    "Sourced",
    "skin_over_fat",
]
