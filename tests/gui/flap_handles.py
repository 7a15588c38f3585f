"""The handles of a laid flap in a real window: `python tests/gui/run.py flap_handles.py`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Point, Steps, run
from tools import MODULE, height, prepare

SIDE, START = 7.0, (-6.0, -2.0)


def measure() -> float:
    """The side of the flap now."""
    return float(dict(flap().measures)["side"])


def flap() -> Any:
    """The laid flap of the scene."""
    model = sys.modules[f"{MODULE}.model.scene_procedure"]
    return model.read_scene(bpy.context.scene).procedure.flaps[0]


def handle(blender: Driver, name: str) -> Point:
    """The pixel of a handle."""
    gizmos = sys.modules[f"{MODULE}.tools.flap_gizmos"]
    places = gizmos.shown_places(bpy.context.scene, blender.area().spaces.active)
    return blender.at(next(place for each, place in places if each.name == name))


def scenario(blender: Driver) -> Steps:
    """Lays a Limberg flap, drags each of its handles, and undoes."""
    yield from prepare(blender)
    with blender.override():
        bpy.ops.lappet.flap_limberg("EXEC_DEFAULT", True, side=SIDE, at=height(*START), lines="X", time=1)
    yield 0.5
    yield from blender.show_tab("Lappet")
    yield from blender.screenshot("handles")
    at = handle(blender, "place")
    yield from blender.move(at)
    yield 0.3
    yield from blender.drag([at, blender.at(height(-2.0, 1.0))])
    yield 0.5
    yield from blender.wait_until(
        lambda: np.allclose(flap().at, height(-2.0, 1.0), atol=1.0), 5.0, f"a drag moves the flap: {flap().at}"
    )
    yield from blender.screenshot("moved")
    side, before = handle(blender, "side"), measure()
    middle = blender.at(flap().at)
    further = tuple(round(m + 1.3 * (s - m)) for s, m in zip(side, middle, strict=True))
    yield from blender.move(side)
    yield 0.3
    yield from blender.drag([side, (further[0], further[1])])
    yield 0.5
    yield from blender.wait_until(
        lambda: measure() > 1.15 * before, 5.0, f"a drag of the corner makes the side longer: {measure():g} mm"
    )
    yield from blender.screenshot("longer")
    name = bpy.context.window_manager.operators[-1].bl_idname
    blender.expect(
        name == "LAPPET_OT_flap_edit_limberg", f"the panel of the last operation is that of the edit: {name}"
    )
    turn = handle(blender, "turn")
    yield from blender.move(turn)
    yield 0.3
    yield from blender.drag([turn, blender.at(height(-2.0, 16.0))])
    yield 0.5
    yield from blender.wait_until(lambda: flap().direction[1] > 0.9, 5.0, f"a drag turns the flap: {flap().direction}")
    yield from blender.screenshot("turned")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(
        lambda: abs(flap().direction[1]) < 0.2 and measure() > 1.15 * before,
        5.0,
        "one step of undo takes the turn back",
    )
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: measure() == before, 5.0, "another takes the longer side back")


if __name__ == "__main__":
    run(scenario)
