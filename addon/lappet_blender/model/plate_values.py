"""Plates in a scene: kept as they were read, and written again with the procedure."""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass

import bpy

from lappet.core.array_codec import CodecError
from lappet.core.value_codec import pack, unpack
from lappet.procedure import Plate


@dataclass(frozen=True)
class KeptPlates:
    """The plates in the order of the procedure."""

    plates: tuple[Plate, ...] = ()


def keep_plates(scene: bpy.types.Scene, plates: tuple[Plate, ...]) -> None:
    """Keep plates in the scene in place of those that it had."""
    scene.lappet.plates = base64.b64encode(pack(KeptPlates(plates))).decode("ascii") if plates else ""


def plate_values(scene: bpy.types.Scene) -> tuple[Plate, ...]:
    """The scene's plates; none where they cannot be read."""
    text = str(scene.lappet.plates)
    if not text:
        return ()
    try:
        kept: KeptPlates = unpack(base64.b64decode(text, validate=True), KeptPlates)
    except (CodecError, binascii.Error, ValueError):
        return ()
    return kept.plates
