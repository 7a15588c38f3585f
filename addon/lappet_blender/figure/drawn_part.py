"""What follows the frame in the scene of a figure."""

from __future__ import annotations

from typing import Protocol

import bpy

from ..look.tube import add_tube_object, draw_tubes
from .section_cut import TubePart


class ScenePart(Protocol):
    """Something in the scene that follows the frame."""

    def show(self, time: float) -> None:
        """Draw what there is at a frame."""


class DrawnTubes:
    """A part in the scene that is made of tubes."""

    def __init__(self, name: str, part: TubePart, material: bpy.types.Material, sides: int) -> None:
        self._part, self._sides = part, sides
        self.object = add_tube_object(name, material)

    def show(self, time: float) -> None:
        """Draw what there is at a frame and nothing else."""
        draw_tubes(self.object, *self._part.tubes(time), self._sides)
