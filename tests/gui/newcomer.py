"""What a newcomer tries first, on a file that was never saved: `run.py newcomer.py`.

The first script of the documents, a material of one's own, the grid in Workbench, a picture of a frame that is not
solved, a head in meters, a piece of skin taken from a mesh.
"""

from __future__ import annotations

import os
import re
import sys
from importlib import import_module
from pathlib import Path

import bpy
from mathutils import Vector

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE

GUIDE = Path(__file__).resolve().parent.parent.parent / "docs" / "blender_scripting.md"


def scenario(blender: Driver) -> Steps:
    """Runs the parts one after another."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    yield from first_script(blender)
    yield from own_material(blender)
    yield from unsolved_picture(blender)
    yield from in_meters(blender)
    yield from field_of_a_mesh(blender)


def first_script(blender: Driver) -> Steps:
    """The first script of the documents, word for word, in the scene that Blender begins with."""
    (script,) = re.findall(r"## A first script\n\n```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL)
    blender.expect(not bpy.data.filepath, "the file was never saved")
    with blender.override():
        exec(compile(script, str(GUIDE), "exec"), {})
    scene = bpy.context.scene
    frames = import_module(f"{MODULE}.solving.frames")
    states = {frames.frame_state(scene, time) for time in range(scene.frame_start, scene.frame_end + 1)}
    blender.expect(states == {"solved"}, f"it solves all frames: {states}")
    picture = Path.home() / "open.png"
    blender.expect(picture.is_file(), f"it renders {picture}")
    if picture.is_file():
        (blender.folder / "first_script.png").write_bytes(picture.read_bytes())
    names = [each.name for each in scene.objects if each.name in ("Cube", "Light")]
    blender.expect(not names, f"nothing of the new file lies in the wound: {names}")
    yield 1.0
    yield from blender.show_tab("Lappet")
    yield from blender.move(blender.within(0.4, 0.5))
    yield from blender.key("HOME")
    yield 1.0
    yield from blender.screenshot("home")
    skin = import_module(f"{MODULE}.display.skin_display").skin_object(scene)
    corners = [blender.at(skin.matrix_world @ Vector(corner)) for corner in skin.bound_box]
    across = (max(x for x, _ in corners) - min(x for x, _ in corners)) / blender.region().width
    blender.expect(across > 0.3, f"Home frames the skin, and not the stage's paper: {across:.2f} of the view")
    with blender.override():
        bpy.ops.view3d.view_all(center=False)  # View > Frame All, which no extension can change
    yield 1.0
    yield from blender.screenshot("frame_all")
    corners = [blender.at(skin.matrix_world @ Vector(corner)) for corner in skin.bound_box]
    across = (max(x for x, _ in corners) - min(x for x, _ in corners)) / blender.region().width
    space = blender.area().spaces.active
    near = space.clip_end > 1.2 * space.region_3d.view_distance
    blender.expect(
        near and across > 0.07, f"Frame All shows it small, with the lights around it: {across:.2f} of the view"
    )
    shown = [each.name for each in scene.objects if each.name == "Backdrop" and each.visible_get()]
    blender.expect(bool(shown), "the paper is still there")
    with blender.override():
        bpy.ops.view3d.view_camera()
    yield from blender.screenshot("first_script_window")


def own_material(blender: Driver) -> Steps:
    """A material of the user's own stays on the skin at the next frame."""
    scene = bpy.context.scene
    skin = import_module(f"{MODULE}.display.skin_display").skin_object(scene)
    mine = bpy.data.materials.new("My skin")
    mine.diffuse_color = (0.2, 0.5, 0.3, 1.0)
    skin.data.materials[0] = mine
    for frame in (19, 1, 34):  # of other epochs too
        scene.frame_set(frame)
        yield 0.7
        shown = import_module(f"{MODULE}.display.skin_display").skin_object(scene).data.materials[0]
        blender.expect(shown == mine, f"at frame {frame} the skin has it: {shown.name}")
    yield from blender.screenshot("own_material")


def unsolved_picture(blender: Driver) -> Steps:
    """A picture of a frame that is not solved says what it shows."""
    scene = bpy.context.scene
    next(each for each in scene.lappet.events if each.kind == "HOOK").stiffness = 90.0
    frames = import_module(f"{MODULE}.solving.frames")
    yield from blender.wait_until(lambda: frames.frame_state(scene, 20) == "stale", 20.0, "an edit makes frames stale")
    scene.frame_set(20)
    reports = import_module(f"{MODULE}.display.render_still")
    told = reports.another_frame(scene)
    blender.expect(told is not None and "20" in told.message, f"a still says so: {told.message if told else None}")


def in_meters(blender: Driver) -> Steps:
    """A head of 0.25 units at a scale of 1 m is a head; one of 25 units is told to be too large."""
    scene = bpy.data.scenes.new("Meters")
    blender.window.scene = scene
    yield 0.3
    scene.unit_settings.scale_length = 1.0
    problems = import_module("lappet.checks.suspicious_tissue").size_problems
    values = import_module(f"{MODULE}.model.mesh_values").mesh_values
    for size, odd in ((0.25, False), (25.0, True)):
        with blender.override():
            bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=size / 2)
        bpy.context.view_layer.update()
        found = problems(values(scene, bpy.context.object).points)
        blender.expect(bool(found) == odd, f"a head of {size:g} m: {[each.message for each in found]}")
        if odd:
            bpy.data.objects.remove(bpy.context.object)


def field_of_a_mesh(blender: Driver) -> Steps:
    """A disc of the sphere's skin becomes tissue with a fixed rim and a bed, in one step and one undo."""
    scene = bpy.context.scene
    head = bpy.context.scene.objects[0]
    bpy.context.view_layer.objects.active = head
    with blender.override():
        bpy.ops.ed.undo_push(message="Head")
        done = bpy.ops.lappet.tissue_take_field(
            "EXEC_DEFAULT", True, object=head.name, point=(0.0, -125.0, 20.0), radius=35.0, thickness=4.0
        )
    blender.expect(done == {"FINISHED"}, "the skin around a point is taken")
    tissue = scene.lappet.tissue.object
    groups = {each.name.removeprefix("lappet_") for each in tissue.data.attributes if each.name.startswith("lappet_")}
    blender.expect({"fixed", "bed"} <= groups, f"its rim is fixed and its underside lies on a bed: {sorted(groups)}")
    blender.expect(head.hide_get(), "the mesh stays, hidden")
    yield 1.5
    with blender.override():
        bpy.ops.view3d.view_selected()
    yield from blender.show_tab("Lappet")
    yield from blender.screenshot("field")
    yield from blender.move(blender.within(0.5, 0.5))
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(
        lambda: bpy.data.scenes["Meters"].lappet.tissue.object is None, 5.0, "Ctrl-Z takes it back in one step"
    )


if __name__ == "__main__":
    run(scenario, limit=500.0)
