"""An operation from a bare mesh to a saved file in a real window, by mouse and keys: what `make test-gui` runs."""

from __future__ import annotations

import os
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Euler, Vector

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from window_pulse import MODULE, Pulse

LENGTH, WIDTH, STEP = 60.0, 44.0, 2.0  # mm, of the bare mesh and its squares
END = 30
FLAP = ((-14.0, -8.0), (13.0, 0.0), (-14.0, 8.0))  # base, tip, base
UNDERMINED = ((-18.0, -11.0), (17.0, -11.0), (17.0, 11.0), (-18.0, 11.0))
CUT, UNDERMINE, PULL, SEW = 3, 4, 6, 18  # frames
GAP = 1.0  # seconds without an answer, software drawing on a busy machine included


def frames() -> Any:
    return import_module(f"{MODULE}.solving.frames")


def events() -> list[str]:
    return [event.name for event in bpy.context.scene.lappet.events]


def states() -> dict[str, int]:
    """How many frames of the scene are solved, stale, failed and missing."""
    found = [frames().frame_state(bpy.context.scene, time) for time in range(1, END + 1)]
    return {name: found.count(name) for name in ("solved", "stale", "failed", "missing")}


def all_solved() -> bool:
    scene = bpy.context.scene
    return frames().manifest_of(scene) is not None and states()["solved"] == END


def shown() -> np.ndarray:
    """Where the vertices of the skin are that is shown, mm."""
    skin = import_module(f"{MODULE}.display.skin_display").skin_object(bpy.context.scene)
    places = np.empty(3 * len(skin.data.vertices), np.float32)
    skin.data.attributes["position"].data.foreach_get("vector", places)
    return places.reshape(-1, 3)


def press(blender: Driver, operator: str, **how: object) -> None:
    """A button of the sidebar."""
    group, name = operator.split(".")
    with blender.override("UI"):
        getattr(getattr(bpy.ops, group), name)("INVOKE_DEFAULT", **how)


def scenario(blender: Driver) -> Steps:
    """Marks, cuts, pulls, sews, solves, scrubs, changes, undoes, varies, saves."""
    yield from bare_mesh(blender)
    pulse = Pulse(blender)
    yield from tissue(blender)
    yield from draw(blender)
    yield from solve(blender, pulse)
    yield from scrub(blender, pulse)
    yield from looks(blender)
    yield from change(blender)
    yield from live(blender, pulse)
    yield from variant(blender)
    yield from reload(blender)


def bare_mesh(blender: Driver) -> Steps:
    """Installs the zip and makes a sheet of squares, as any Blender user would."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    import lappet

    blender.expect("/extensions/.local/" in lappet.__file__, "lappet comes from the extension's wheels")
    for each in list(bpy.data.objects):
        bpy.data.objects.remove(each)
    scene = bpy.context.scene
    scene.unit_settings.scale_length, scene.unit_settings.length_unit = 0.001, "MILLIMETERS"
    scene.frame_start, scene.frame_end = 1, END
    size = (int(LENGTH / STEP), int(WIDTH / STEP))
    with blender.override():
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=size[0], y_subdivisions=size[1], size=1.0)
        bpy.context.object.name = "Patch"
        bpy.context.object.scale = (LENGTH, WIDTH, 1.0)
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    space = blender.area().spaces.active
    space.clip_start, space.clip_end = 0.1, 1000.0
    view = space.region_3d
    view.view_rotation = Euler((0.72, 0.0, 0.2)).to_quaternion()
    view.view_location, view.view_distance = (0.0, 0.0, 0.0), 92.0
    bpy.ops.ed.undo_push(message="A sheet")
    yield from blender.show_tab("Lappet")
    yield from blender.screenshot("01_bare_mesh")


def tissue(blender: Driver) -> Steps:
    """Makes the mesh the tissue."""
    scene = bpy.context.scene
    press(blender, "lappet.tissue_set")
    yield 0.3
    blender.expect(scene.lappet.tissue.object is not None, "the button makes the mesh the tissue")
    blender.expect(scene.lappet.tissue.thicken, "an open surface is given a thickness")
    scene.lappet.tissue.spacing = 1.0
    bpy.ops.ed.undo_push(message="Spacing")
    scene.lappet.look.show_lattice = True
    display = import_module(f"{MODULE}.display.skin_display")
    yield from blender.wait_until(lambda: display.skin_object(scene) is not None, 10.0, "its sheet is shown as skin")
    yield 0.5
    yield from blender.screenshot("02_tissue_and_lattice")
    scene.lappet.look.show_lattice = False
    yield 0.2


def draw(blender: Driver) -> Steps:
    """The incision, the undermining, the hook and the sutures, each with its tool."""
    scene = bpy.context.scene
    at = lambda x, y: blender.at((x, y, 0.0))  # noqa: E731
    scene.frame_set(CUT)
    yield from blender.set_tool("lappet.cutting.incision")
    for place in FLAP:
        yield from blender.click(at(*place))
    yield from blender.screenshot("03_drawing_the_incision")
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: events() == ["incision_1"], 3.0, "clicks and Return draw an incision")

    scene.frame_set(UNDERMINE)
    yield from blender.set_tool("lappet.cutting.undermining")
    for place in (*UNDERMINED, UNDERMINED[0]):
        yield from blender.click(at(*place))
    yield from blender.wait_until(lambda: len(events()) == 2, 3.0, "a closed area is undermined")

    scene.frame_set(PULL)
    yield from blender.set_tool("lappet.hook")
    tip = Vector((11.0, 0.0, 0.0))
    x, y = blender.at(tip)
    yield from blender.move((x, y))
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.05
    yield from blender.move((x - 30, y + 40))
    yield from blender.move((x - 70, y + 110))
    yield from blender.screenshot("04_pulling_the_hook")
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.2
    yield from blender.wait_until(lambda: events()[-1] == "hook_1", 3.0, "a drag places a hook")
    scene.lappet.events[-1].end = SEW + 6.0
    bpy.ops.ed.undo_push(message="Release")

    yield from place_sutures(blender)
    yield from blender.set_tool("lappet.edit")
    yield from blender.screenshot("06_planned")


def place_sutures(blender: Driver) -> Steps:
    """Three sutures on one edge of the flap, and a run along the other."""
    scene = bpy.context.scene
    at = lambda x, y: blender.at((x, y, 0.0))  # noqa: E731
    scene.frame_set(SEW)
    yield 1.0
    yield from blender.set_tool("lappet.suture")
    way = np.array(FLAP[0]) - np.array(FLAP[1])
    across = np.array((way[1], -way[0])) / np.linalg.norm(way)
    for share in (0.12, 0.4, 0.7):
        middle = np.array(FLAP[1]) + share * way
        for side in (-0.8, 0.8):
            yield from blender.click(at(*(middle + side * across)))
        yield 0.1
    count = sum(event.kind == "SUTURE" for event in scene.lappet.events)
    blender.expect(count == 3, f"pairs of clicks on the wound's edges make sutures: {count}")
    way = way * (1.0, -1.0)
    across = np.array((way[1], -way[0])) / np.linalg.norm(way)
    yield from blender.click(at(*(np.array(FLAP[1]) + 0.2 * way - 0.8 * across)), shift=True)
    yield from blender.click(at(*(np.array(FLAP[1]) + 0.7 * way - 0.8 * across)))
    yield from blender.key("RET")
    yield from blender.click(at(*(np.array(FLAP[1]) + 0.2 * way + 0.8 * across)))
    yield from blender.move(at(*(np.array(FLAP[1]) + 0.7 * way + 0.8 * across)))
    yield from blender.screenshot("05_sewing_a_run")
    yield from blender.click(at(*(np.array(FLAP[1]) + 0.7 * way + 0.8 * across)))
    yield from blender.key("RET")
    yield 0.3
    count = sum(event.kind == "SUTURE_RUN" for event in scene.lappet.events)
    blender.expect(count == 1, f"the other edge is sewn by one run: {count}")


def solve(blender: Driver, pulse: Pulse) -> Steps:
    """Solves while Blender answers."""
    scene = bpy.context.scene
    yield from blender.wait_until(
        lambda: frames().manifest_of(scene) is not None, 30.0, "the procedure is listed by itself"
    )
    scene.frame_set(CUT)
    yield 0.5
    yield from blender.screenshot("07_cut_at_rest")
    pulse.begin()
    press(blender, "lappet.solve")
    yield from blender.wait_until(lambda: 5 < states()["solved"] < END, 120.0, "frames arrive one by one")
    yield from blender.screenshot("08_solving")
    begun = scene.frame_current
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("RIGHT_ARROW")
    yield from blender.wait_until(lambda: scene.frame_current == begun + 1, 2.0, "keys are answered meanwhile")
    yield from blender.wait_until(all_solved, 200.0, "every frame is solved")
    blender.notes["solving"] = pulse.words()
    blender.expect(pulse.gap < GAP, f"the window keeps answering while it solves: {pulse.words()}")
    if frames().failure_of(scene) is not None:
        blender.expect(False, f"no frame fails: {frames().failure_of(scene).problem}")
    yield from blender.screenshot("09_solved")


def scrub(blender: Driver, pulse: Pulse) -> Steps:
    """Goes through the frames by key, and plays them."""
    scene = bpy.context.scene
    yield from blender.set_tool("builtin.select_box")
    pulse.begin()
    moved = {}
    for frame in (PULL + 4, 14, SEW, SEW + 6, END):
        while scene.frame_current != frame:
            yield from blender.key("RIGHT_ARROW" if scene.frame_current < frame else "LEFT_ARROW")
        yield 0.2
        moved[frame] = float(shown()[:, 2].max())
        yield from blender.screenshot(f"10_frame_{frame:02d}")
    blender.expect(moved[14] > 3.0, f"the hook lifts the flap: {moved}")
    blender.expect(abs(moved[END]) < 3.0, "and it lies again once it is sewn")
    blender.notes["scrubbing"] = pulse.words()
    with blender.override():
        bpy.ops.screen.animation_play()
    begun, frame = time.monotonic(), scene.frame_current
    yield 2.0
    blender.expect(scene.frame_current != frame, f"it plays, {pulse.words()}")
    with blender.override():
        bpy.ops.screen.animation_cancel(restore_frame=False)
    blender.notes["played"] = time.monotonic() - begun


def looks(blender: Driver) -> Steps:
    """Colors of the skin."""
    scene = bpy.context.scene
    scene.frame_set(14)
    scene.lappet.active_event = -1
    for color in ("STRAIN", "CHECKER", "PLAIN"):
        scene.lappet.look.color = color
        yield 0.6
        yield from blender.screenshot(f"11_look_{color.lower()}")
    scene.lappet.look.color = "GRID"
    yield 0.3
    bpy.ops.ed.undo_push(message="Looks")


def change(blender: Driver) -> Steps:
    """A change makes later frames stale; undo and redo bring solved frames back at once."""
    scene = bpy.context.scene
    scene.frame_set(PULL + 4)
    bpy.ops.ed.undo_push(message="Frame")
    before = shown().copy()
    hook = next(event for event in scene.lappet.events if event.kind == "HOOK")
    scene.lappet.active_event = events().index(hook.name)
    hook.stiffness = 60.0
    bpy.ops.ed.undo_push(message="Softer")
    yield from blender.wait_until(lambda: states()["stale"] > 0, 10.0, "a change makes later frames stale")
    yield 1.0
    blender.expect(states()["solved"] >= PULL - 1, f"and leaves the earlier ones: {states()}")
    yield from blender.screenshot("12_stale")
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(all_solved, 1.0, "Ctrl-Z brings the solved frames back at once")
    scene = bpy.context.scene
    scene.frame_set(PULL + 4)
    blender.expect(bool(np.array_equal(shown(), before)), "and shows them")
    yield from blender.screenshot("13_undone")
    yield from blender.key("Z", ctrl=True, shift=True)
    yield from blender.wait_until(lambda: states()["stale"] > 0, 1.0, "redo makes them stale again")
    press(blender, "lappet.solve")
    yield from blender.wait_until(all_solved, 200.0, "the changed frames are solved")
    bpy.context.scene.frame_set(PULL + 4)
    blender.expect(bool(np.abs(shown() - before).max() > 0.1), "and differ")
    yield from blender.screenshot("14_solved_again")


def live(blender: Driver, pulse: Pulse) -> Steps:
    """The skin follows a hook's target as it is dragged."""
    scene = bpy.context.scene
    scene.frame_set(14)
    hook = next(event for event in scene.lappet.events if event.kind == "HOOK")
    scene.lappet.active_event = events().index(hook.name)
    yield from blender.set_tool("builtin.select_box")
    x, y = blender.at(hook.target.matrix_world.translation)
    with blender.override():
        for each in bpy.context.view_layer.objects:
            each.select_set(False)
        hook.target.select_set(True)
        bpy.context.view_layer.objects.active = hook.target
    bpy.ops.ed.undo_push(message="Target")
    yield from blender.move((x, y))
    with blender.override():
        bpy.ops.lappet.live("INVOKE_DEFAULT")
    yield 1.0
    before = shown().copy()
    pulse.begin()
    yield from blender.key("G")
    for step in range(1, 25):
        yield from blender.move((x + 4 * step, y + 2 * step))
        yield 0.05
    yield from blender.wait_until(
        lambda: float(np.abs(shown() - before).max()) > 1.0, 20.0, "the skin follows while the mouse is dragged"
    )
    yield 0.5
    yield from blender.screenshot("15_live")
    blender.notes["live"] = pulse.words()
    yield from blender.click((x + 96, y + 48))
    yield from blender.key("ESC")
    yield 1.0
    blender.expect(not frames().progress_of(scene).live, "Esc ends live mode")
    yield from blender.screenshot("16_after_live")
    scene.frame_set(15)
    scene.frame_set(14)
    u, v = blender.at(hook.target.matrix_world.translation)
    blender.expect(abs(u - x - 96) < 3 and abs(v - y - 48) < 3, "the target is keyed where it was let go")
    yield from blender.key("Z", ctrl=True)
    yield 0.3
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(all_solved, 3.0, "Ctrl-Z takes the drag back, and the solved frames are there")


def variant(blender: Driver) -> Steps:
    """A variant of the procedure beside the first."""
    press(blender, "lappet.variant_new", name="Stiff hook")
    yield 0.5
    scene = bpy.context.scene
    blender.expect(scene.name == "Stiff hook", "New Variant goes to the copy")
    hook = next(event for event in scene.lappet.events if event.kind == "HOOK")
    hook.stiffness = 900.0
    scene.frame_set(14)
    press(blender, "lappet.solve")
    yield from blender.wait_until(all_solved, 200.0, "the variant is solved")
    with blender.override():
        bpy.ops.view3d.view_all()
    yield 0.8
    yield from blender.screenshot("17_compared")
    display = import_module(f"{MODULE}.display.display_collection")
    beside = display.find_object(display.find_collection(scene), "other skin")
    blender.expect(beside is not None and not beside.hide_viewport, "the first procedure is seen beside it")


def reload(blender: Driver) -> Steps:
    """Saves, opens again, and finds everything."""
    folder = Path(os.environ["LAPPET_GUI_RESULTS"])
    before, names = shown().copy(), events()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "operation.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    yield 0.5
    bpy.ops.wm.open_mainfile(filepath=str(folder / "operation.blend"))
    yield 0.5
    yield from blender.wait_until(all_solved, 5.0, "the file opens with its frames solved")
    blender.expect(events() == names, "with its events")
    blender.expect(bool(np.array_equal(shown(), before)), "and with the frame that was shown")
    yield from blender.screenshot("18_reloaded")


if __name__ == "__main__":
    run(scenario, limit=390.0)
