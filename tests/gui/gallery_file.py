"""The project files of the gallery, opened in a real window: each says that it solves, and one solves and is drawn.

`make projects` makes the files first; then `run.py gallery_file.py`.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE

FOLDER = Path(__file__).resolve().parent.parent.parent / "build" / "gallery" / "blends"
FILE = FOLDER / "v_y.blend"


def scenario(blender: Driver) -> Steps:
    """Opens the file as a download is opened, waits, looks through the camera and renders."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    bpy.ops.wm.open_mainfile("EXEC_DEFAULT", filepath=str(FILE))
    yield 1.0
    frames = import_module(f"{MODULE}.solving.frames")
    scene = blender.window.scene
    yield from blender.wait_until(lambda: frames.progress_of(scene).running, 10.0, "it solves when it is opened")
    view = blender.area().spaces.active.region_3d.view_perspective
    blender.expect(view == "CAMERA", f"the view looks through the camera of the page: {view}")
    yield from blender.show_tab("Lappet")
    yield from blender.move(blender.within(0.4, 0.5))
    yield 2.0
    yield from blender.screenshot("opened")
    begun = frames.progress_of(scene)
    blender.notes["when opened"] = begun.line
    yield from blender.wait_until(lambda: not frames.progress_of(scene).running, 240.0, "until it has solved all")
    states = {frames.frame_state(scene, time) for time in range(scene.frame_start, scene.frame_end + 1)}
    blender.expect(states == {"solved"}, f"every frame is solved: {states}")
    scene.frame_set(scene.frame_end)
    yield 1.0
    yield from blender.screenshot("solved")
    picture = Path.home() / "picture.png"
    scene.frame_set(round(0.6 * scene.frame_end))
    scene.render.resolution_percentage = 40
    scene.cycles.samples = 8
    with blender.override():
        bpy.ops.lappet.render_still(filepath=str(picture))
    blender.expect(picture.is_file(), "its camera, lights and paper make a picture")
    (blender.folder / "picture.png").write_bytes(picture.read_bytes())
    page = scene.lappet.pages[0]
    blender.expect((page.name, page.style) == ("v_y", "ink"), f"the gallery's page is there: {page.style}")
    yield 0.2
    for file in sorted(FOLDER.glob("*.blend")):
        if file != FILE:
            yield from opened(blender, file)


def opened(blender: Driver, file: Path) -> Steps:
    """Opens another file: it begins to solve, without a problem that would stop it, and is stopped."""
    bpy.ops.wm.open_mainfile("EXEC_DEFAULT", filepath=str(file))
    yield 1.0
    frames = import_module(f"{MODULE}.solving.frames")
    scene = blender.window.scene
    name = file.stem
    yield from blender.wait_until(lambda: frames.progress_of(scene).running, 60.0, f"{name} solves when it is opened")
    wrong = [each.message for each in frames.problems_of(scene) if each.severity == "error"]
    blender.expect(not wrong, f"nothing is wrong with it: {wrong}")
    view = blender.area().spaces.active.region_3d.view_perspective
    blender.expect(view == "CAMERA", f"the view looks through the camera of the page: {view}")
    pages = [each.name for each in scene.lappet.pages]
    blender.expect(pages == [name], f"it has its page: {pages}")
    yield 1.0
    yield from blender.screenshot(name)
    bpy.ops.lappet.solve_cancel()
    yield from blender.wait_until(
        lambda: not frames.progress_of(scene).running, 60.0, "and it stops when it is told to"
    )


if __name__ == "__main__":
    run(scenario, limit=840.0)
