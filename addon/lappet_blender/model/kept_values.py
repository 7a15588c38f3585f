"""What a scene holds of a procedure without tools for it, kept as it was read.

That is: loads, sections, rollers, muscles and the motions of bones.
"""

from __future__ import annotations

import base64
import binascii
from dataclasses import dataclass, replace

import bpy

from lappet.core.array_codec import CodecError
from lappet.core.value_codec import pack, unpack
from lappet.procedure import Bone, Event, Muscle, Pressure, Procedure, Roller, Section, Tissue, Traction

KEPT_EVENTS = (Traction, Pressure, Section)


@dataclass(frozen=True)
class KeptMotion:
    """How the bone of a name moves."""

    name: str
    motion: tuple[tuple[float, tuple[float, ...]], ...]


@dataclass(frozen=True)
class KeptValues:
    """The values, each kind in the order of the procedure."""

    tractions: tuple[Traction, ...] = ()
    pressures: tuple[Pressure, ...] = ()
    sections: tuple[Section, ...] = ()
    rollers: tuple[Roller, ...] = ()
    muscles: tuple[Muscle, ...] = ()
    moving_bones: tuple[KeptMotion, ...] = ()

    @property
    def events(self) -> tuple[Event, ...]:
        """The events among them."""
        return (*self.tractions, *self.pressures, *self.sections)

    def rolling(self, tissue: Tissue) -> Tissue:
        """The tissue with the rollers whose faces it still has."""
        return replace(tissue, rollers=tuple(each for each in self.rollers if each.faces in tissue.subsets))

    def moving(self, bones: tuple[Bone, ...]) -> tuple[Bone, ...]:
        """The bones with the motions that are kept for their names."""
        motions = {each.name: each.motion for each in self.moving_bones}
        return tuple(replace(bone, motion=motions[bone.name]) if bone.name in motions else bone for bone in bones)


def keep(scene: bpy.types.Scene, procedure: Procedure) -> KeptValues:
    """Store in the scene what it has no tools for, in place of what it kept before, and return it."""
    kept = KeptValues(
        tuple(each for each in procedure.events if isinstance(each, Traction)),
        tuple(each for each in procedure.events if isinstance(each, Pressure)),
        tuple(each for each in procedure.events if isinstance(each, Section)),
        procedure.tissue.rollers,
        procedure.muscles,
        tuple(KeptMotion(bone.name, bone.motion) for bone in procedure.bones if bone.motion),
    )
    scene.lappet.kept = "" if kept == KeptValues() else base64.b64encode(pack(kept)).decode("ascii")
    return kept


def kept_values(scene: bpy.types.Scene) -> KeptValues:
    """What the scene keeps; nothing where that cannot be read."""
    text = str(scene.lappet.kept)
    if not text:
        return KeptValues()
    try:
        return unpack(base64.b64decode(text, validate=True), KeptValues)
    except (CodecError, binascii.Error, ValueError):
        return KeptValues()
