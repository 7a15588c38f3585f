"""The first drag of hook and retractor in a real window: the skin follows the held button: `run.py hook_drag.py`."""

from __future__ import annotations

import sys
import time
from importlib import import_module
from pathlib import Path

import bpy
import numpy as np
from mathutils import Quaternion

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from large import sheet
from tools import MODULE, events, height, last, prepare


def shown(scene: bpy.types.Scene) -> np.ndarray:
    """The points of the skin as it is shown."""
    skin = import_module(f"{MODULE}.display.skin_display").skin_object(scene)
    points = np.empty(3 * len(skin.data.vertices), np.float32)
    skin.data.attributes["position"].data.foreach_get("vector", points)
    return points.reshape(-1, 3)


def moved(before: np.ndarray) -> float:
    """How far the skin has moved, mm."""
    after = shown(bpy.context.scene)
    return float(np.linalg.norm(after - before, axis=1).max()) if len(after) == len(before) else np.nan


def scenario(blender: Driver) -> Steps:
    """A flap is cut and solved; its tip is pulled by the tool Hook."""
    yield from prepare(blender)
    frames = import_module(f"{MODULE}.solving.frames")
    scene = bpy.context.scene
    scene.frame_end = 12
    with blender.override():
        sheet(61, 41)
        bpy.ops.lappet.tissue_set(object="sheet", thickness=5.0, spacing=2.0)
        bpy.data.objects.remove(bpy.data.objects["block"])
        flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
        bpy.ops.lappet.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
        bpy.ops.ed.undo_push(message="Flap")
    yield from blender.show_tab("Lappet")
    yield from blender.wait_until(lambda: frames.manifest_of(scene) is not None, 90.0, "it is listed")
    scene.frame_set(3)
    bpy.ops.ed.undo_push(message="Frame 3")
    yield 1.0

    yield from blender.set_tool("lappet.hook")

    yield from drag(blender, "unsolved", expected=False)
    blender.expect(events()[-1] == "hook_1", "without a solved frame before it a hook is placed as ever")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: len(events()) == 1, 2.0, "Ctrl-Z takes it back")
    scene = bpy.context.scene
    bpy.ops.lappet.solve("INVOKE_DEFAULT", until=2)
    yield from blender.wait_until(lambda: frames.frame_state(scene, 2) == "solved", 90.0, "the frame before is solved")
    yield 1.0
    rest = shown(scene)
    yield from drag(blender, "given_up", expected=True, release="ESC")
    yield 1.0
    blender.expect(len(events()) == 1 and moved(rest) < 0.01, "Esc leaves no hook, and the skin as it was")
    yield from drag(blender, "pulled", expected=True)
    hook = last()
    blender.expect(hook.name == "hook_1" and hook.start == 3.0, "it is placed at this frame when the button goes up")
    anchor = np.array(hook.points[0].co)
    blender.expect(
        bool(np.abs(anchor - height(4, 4)).max() < 0.5), "in the point of the skin where it was taken hold of"
    )
    yield 1.0
    blender.expect(moved(rest) < 0.01, "at its first frame the skin is where it was: it is pulled from there on")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: len(events()) == 1, 2.0, "Ctrl-Z takes the hook back in one step")
    yield from blender.wait_until(
        lambda: frames.frame_state(bpy.context.scene, 2) == "solved", 3.0, "frames stay solved"
    )
    yield from retractor(blender)


def retractor(blender: Driver) -> Steps:
    """The flap's tip is gripped and lifted by the tool Retractor; then its target is turned, live."""
    control = import_module(f"{MODULE}.solving.controller")
    yield 1.0
    rest = shown(bpy.context.scene)
    yield from blender.set_tool("lappet.retractor")
    yield from drag(blender, "lifted", expected=True, release="ESC")
    yield 1.0
    blender.expect(len(events()) == 1 and moved(rest) < 0.01, "Esc leaves no retractor, and the skin as it was")
    blender.expect(groups() == [], "and no group of faces")
    yield from drag(blender, "retracted", expected=True)
    held = last()
    blender.expect(held.name == "retractor_1" and held.start == 3.0, "it is placed at this frame, with a group")
    blender.expect(groups() == ["grip_1"], f"which is made then: {groups()}")
    yield 2.0
    scene = bpy.context.scene
    scene.frame_set(3)
    scene.lappet.active_event = len(scene.lappet.events) - 1
    bpy.ops.lappet.live("INVOKE_DEFAULT")
    live = control.controller_of(scene).live
    yield from blender.wait_until(lambda: live.frame is not None, 90.0, "live: the skin is there")
    before = shown(scene)
    turned = held.target.rotation_quaternion
    held.target.rotation_quaternion = turned @ Quaternion((0.0, 1.0, 0.0), 0.5)
    yield from blender.wait_until(lambda: moved(before) > 0.3, 20.0, "a retractor that turns takes the skin along")
    blender.notes["turned"] = f"{moved(before):.1f} mm"
    yield 2.0
    yield from blender.screenshot("hook_turned")
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: control.controller_of(scene).live is None, 3.0, "Return ends it")
    turn = held.target.rotation_quaternion.copy()
    scene.frame_set(1)
    scene.frame_set(3)
    left = held.target.rotation_quaternion.rotation_difference(turn).angle
    blender.expect(turn.angle > 0.4 and left < 1e-4, f"its turn is keyed: {turn.angle:.2f}, {left:.5f} rad away")


def groups() -> list[str]:
    """The groups of faces that retractors may grip."""
    mesh = bpy.context.scene.lappet.tissue.object.data
    return sorted(each.name.removeprefix("lappet_") for each in mesh.attributes if each.name.startswith("lappet_grip"))


def drag(blender: Driver, name: str, expected: bool, release: str = "RELEASE") -> Steps:
    """Presses on the skin, pulls it in small steps, waits with the button down, lets go."""
    control = import_module(f"{MODULE}.solving.controller")
    view = blender.area().spaces.active.region_3d
    view.view_location, view.view_distance = (0.0, 0.0, 0.0), 110.0
    yield 0.3
    start, end = blender.at(height(4, 4)), blender.at((4, 4, 12))
    before, began = shown(bpy.context.scene), time.monotonic()
    far: list[float] = []
    followed = 0.0
    yield from blender.move(start)
    blender.event("LEFTMOUSE", "PRESS")
    for step in range(1, 41):
        at = tuple(round(a + (b - a) * step / 40) for a, b in zip(start, end, strict=True))
        yield from blender.move((at[0], at[1]))
        yield 0.1
        far.append(moved(before))
        if far[-1] > 0.05 and not followed:
            followed = time.monotonic() - began
    yield 2.0
    far.append(moved(before))
    yield from blender.screenshot(f"hook_{name}")
    live = control.controller_of(bpy.context.scene).live
    blender.notes[name] = f"followed after {followed:.1f} s, {far[-1]:.1f} mm; last update took " + (
        f"{live.seconds:.2f} s" if live is not None else "nothing"
    )
    print(blender.notes[name], flush=True)
    blender.expect(
        (far[-1] > 1.0) == expected, f"{name}: the skin followed while the button was down: {far[-1]:.1f} mm"
    )
    if release == "RELEASE":
        blender.event("LEFTMOUSE", "RELEASE")
    else:
        yield from blender.key(release)
        blender.event("LEFTMOUSE", "RELEASE")
    yield 0.3
    blender.expect(control.controller_of(bpy.context.scene).live is None, f"{name}: it ends with the button")


if __name__ == "__main__":
    run(scenario)
