"""Steps that the tests of solving share."""

from __future__ import annotations

import bpy

from lappet_blender.solving import frames

QUIET = 10.0  # seconds that the timer may take until nothing is under way


def states(scene: bpy.types.Scene) -> str:
    """The states of frames 1 to 8 as letters: solved, stale (t), failed, missing."""
    letters = {"solved": "s", "stale": "t", "failed": "f", "missing": "m"}
    return "".join(letters[frames.frame_state(scene, time)] for time in range(1, 9))


def solve(scene: bpy.types.Scene) -> None:
    """Solves all of it."""
    assert bpy.ops.lappet.solve(wait=True) == {"FINISHED"}
    assert states(scene) == "ssssssss"
