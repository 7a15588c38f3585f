"""What people do to the shown skin and around it, in a real window, without a traceback: `run.py disturbed.py`.

Edit mode, sculpting, hiding, deleting, linked copies, another frame rate, two windows, two scenes.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from large import sheet
from tools import MODULE, height, prepare


def scenario(blender: Driver) -> Steps:
    """A solved flap that is disturbed in every way."""
    yield from prepare(blender)
    scene, ops = bpy.context.scene, bpy.ops.lappet
    frames = import_module(f"{MODULE}.solving.frames")
    skin_of = import_module(f"{MODULE}.display.skin_display").skin_object
    scene.frame_end = 5
    made = sheet(31, 21)
    with blender.override():
        ops.tissue_set(object=made.name, thickness=5.0, spacing=2.5)
    bpy.data.objects.remove(bpy.data.objects["block"])
    flap = [height(x, y) for x, y in ((-14, -8), (-2, 8), (12, 8), (12, -8))]
    ops.incision_add(points=[{"name": "", "co": p} for p in flap], time=2.0, kerf=0.2)
    ops.hook_add(anchor=height(4, 5), target=(4, 6, 6), start=3.0, arrive=1.0)
    yield from blender.show_tab("Lappet")
    ops.solve("INVOKE_DEFAULT")
    solved = lambda: frames.frame_state(bpy.context.scene, 5) == "solved"  # noqa: E731
    yield from blender.wait_until(solved, 90.0, "it is solved")
    scene.frame_set(5)
    yield 1.0
    bpy.ops.ed.undo_push(message="Solved")
    yield from blender.set_tool("lappet.hook")
    yield from blender.move(blender.at(height(-20, 0)))
    for mode, name in (("EDIT", "edit"), ("SCULPT", "sculpt"), ("VERTEX_PAINT", "paint")):
        skin = skin_of(scene)
        bpy.context.view_layer.objects.active = skin
        with blender.override():
            bpy.ops.object.mode_set(mode=mode)
        yield 0.5
        for frame in (4, 5):
            scene.frame_set(frame)
            yield 0.3
        x, y = blender.at(height(-20, 0))
        yield from blender.drag([(x, y), (x + 60, y + 20)])
        yield from blender.screenshot(f"skin_{name}")
        with blender.override():
            bpy.ops.object.mode_set(mode="OBJECT")
        yield 0.5
        scene.frame_set(4)
        scene.frame_set(5)
        yield 0.5
        blender.expect(skin_of(scene) is not None, f"after {name} mode the skin is shown")
    yield from hidden_and_deleted(blender, skin_of)
    yield from copied(blender, skin_of)
    scene.render.fps = 30
    yield 1.0
    blender.expect(solved(), "another frame rate leaves the frames solved")
    yield from windows_and_scenes(blender, skin_of)


def hidden_and_deleted(blender: Driver, skin_of: object) -> Steps:
    """H, Alt-H, X with the skin selected."""
    scene = bpy.context.scene
    skin = skin_of(scene)
    bpy.context.view_layer.objects.active = skin
    skin.select_set(True)
    yield from blender.set_tool("builtin.select_box")
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("H")
    yield 0.5
    scene.frame_set(4)
    yield 0.5
    yield from blender.screenshot("skin_hidden")
    yield from blender.key("H", alt=True)
    yield 0.5
    skin = skin_of(scene)
    bpy.data.objects.remove(skin)
    yield 0.5
    scene.frame_set(5)
    yield 1.0
    blender.expect(skin_of(scene) is not None, "a deleted skin comes again with the next frame")
    yield from blender.screenshot("skin_again")


def copied(blender: Driver, skin_of: object) -> Steps:
    """Alt-D of the skin and of the tissue: copies that share a mesh."""
    scene = bpy.context.scene
    for source in (skin_of(scene), scene.lappet.tissue.object):
        twin = source.copy()
        twin.hide_viewport, twin.location.x = False, 70.0
        scene.collection.objects.link(twin)
        yield 0.3
        for frame in (2, 5):
            scene.frame_set(frame)
            yield 0.5
    blender.expect(skin_of(scene) is not None, "linked copies leave the skin shown")
    yield from blender.screenshot("copies")


def windows_and_scenes(blender: Driver, skin_of: object) -> Steps:
    """A second window that shows a second scene."""
    with blender.override():
        bpy.ops.wm.window_new_main()
    yield 1.0
    first, second = bpy.context.window_manager.windows[:2]
    with bpy.context.temp_override(window=first):
        bpy.ops.lappet.variant_new()
    yield 2.0
    scenes = {each.scene.name for each in (first, second)}
    blender.expect(len(scenes) == 2, f"two windows show two scenes: {sorted(scenes)}")
    for frame in (2, 3, 5):
        for each in (first, second):
            each.scene.frame_set(frame)
            yield 0.5
    yield from blender.screenshot("two_windows")
    for each in (first, second):
        blender.expect(skin_of(each.scene) is not None, f"the skin of {each.scene.name} is there")
    with bpy.context.temp_override(window=second):
        bpy.ops.wm.window_close()
    yield 1.0
    other = next(each for each in bpy.data.scenes if each != first.scene)
    bpy.data.scenes.remove(other)
    yield 1.0
    blender.expect(skin_of(first.scene) is not None, "the scene that is left shows its skin")


if __name__ == "__main__":
    run(scenario, limit=400.0)
