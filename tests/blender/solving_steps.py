"""Steps that the tests of solving share."""

from __future__ import annotations

import bpy
import numpy as np
from numpy.typing import NDArray

from lappet_blender.solving import controller, frames

QUIET = 10.0  # seconds that the timer may take until nothing is under way


def states(scene: bpy.types.Scene) -> str:
    """The states of frames 1 to 8 as letters: solved, stale (t), failed, missing."""
    letters = {"solved": "s", "stale": "t", "failed": "f", "missing": "m"}
    return "".join(letters[frames.frame_state(scene, time)] for time in range(1, 9))


def solve(scene: bpy.types.Scene) -> None:
    """Solves all of it."""
    assert bpy.ops.lappet.solve(wait=True) == {"FINISHED"}
    assert states(scene) == "ssssssss"


def live_points(scene: bpy.types.Scene) -> NDArray[np.float32] | None:
    """The skin's points (n, 3) in mm for the hook as it is dragged; None where live mode is off or has none yet."""
    found = controller.find_controller(scene)
    live = None if found is None else found.live
    return None if live is None or live.frame is None else live.frame.points
