"""Every tool of the toolbar in a real window, with a mouse and keys: `python tests/gui/run.py tools.py`."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Euler

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run

MODULE = "bl_ext.user_default.lappet_blender"


def block() -> bpy.types.Object:
    """A block of 60 x 40 x 6 mm, its skin at z = 0, gently domed, in squares of 2 mm."""
    x, y = np.meshgrid(np.linspace(-30, 30, 31), np.linspace(-20, 20, 21))
    top = np.stack([x, y, -(x**2 + y**2) / 200.0], axis=-1).reshape(-1, 3)
    below = np.stack([x, y, np.full_like(x, -10.0)], axis=-1).reshape(-1, 3)
    ids = np.arange(x.size).reshape(x.shape)
    quads = np.stack([ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]], axis=-1).reshape(-1, 4)
    rim = np.concatenate([ids[0, :-1], ids[:-1, -1], ids[-1, :0:-1], ids[:0:-1, 0]])
    turned = np.roll(rim, -1)
    sides = np.stack([rim, rim + x.size, turned + x.size, turned], axis=1)
    mesh = bpy.data.meshes.new("skin block")
    faces = np.concatenate([quads, quads[:, ::-1] + x.size, sides])
    mesh.from_pydata(np.vstack([top, below]).tolist(), [], faces.tolist())
    made = bpy.data.objects.new("block", mesh)
    bpy.context.collection.objects.link(made)
    return made


def height(x: float, y: float) -> tuple[float, float, float]:
    """The point of the block's skin over (x, y)."""
    return (x, y, -(x * x + y * y) / 200.0)


DRAWN = [height(-20, -8), height(-5, 4), height(10, -6)]  # the points of the clicked incision


def events() -> list[str]:
    return [event.name for event in bpy.context.scene.lappet.events]


def last() -> bpy.types.PropertyGroup:
    return bpy.context.scene.lappet.events[-1]


def first_points(event: bpy.types.PropertyGroup) -> np.ndarray:
    return np.array([tuple(point.co) for point in event.points])


def near(places: np.ndarray, *wanted: tuple[float, float, float]) -> bool:
    """Whether places are those wanted, to a pixel or two."""
    return places.shape == (len(wanted), 3) and bool(np.abs(places - np.array(wanted)).max() < 0.5)


def prepare(blender: Driver) -> Steps:
    """Installs the zip and makes a tissue, seen from above at a slant."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    for each in list(bpy.data.objects):
        bpy.data.objects.remove(each)
    scene = bpy.context.scene
    scene.unit_settings.scale_length = 0.001
    scene.frame_end = 40
    block()
    with blender.override():
        bpy.ops.lappet.tissue_set(object="block")
    space = blender.area().spaces.active
    space.clip_start, space.clip_end = 0.1, 1000.0
    view = space.region_3d
    view.view_perspective = "PERSP"
    view.view_rotation = Euler((0.6, 0.0, 0.15)).to_quaternion()
    view.view_location, view.view_distance = (0.0, 0.0, -3.0), 95.0
    bpy.ops.ed.undo_push(message="Tissue")
    yield 0.5


def scenario(blender: Driver) -> Steps:
    """Draws, pulls, sutures, marks and edits."""
    yield from prepare(blender)
    tools = [name for name in blender.tools() if name.startswith("lappet.")]
    blender.expect(len(tools) == 8, f"the toolbar has {len(tools)} tools of Lappet")
    yield from clicked_incision(blender)
    yield from freehand_incision(blender)
    yield from undermining(blender)
    yield from hook(blender)
    yield from small_tools(blender)
    yield from editing(blender)
    yield from target(blender)
    yield from runs(blender)
    yield from views(blender)
    yield from without_toolbar(blender)
    yield from interrupted(blender)


def clicked_incision(blender: Driver) -> Steps:
    """Three clicks and Return; one click is taken back."""
    at = lambda x, y: blender.at(height(x, y))  # noqa: E731
    yield from blender.set_tool("lappet.cutting.incision")
    yield from blender.click(at(-20, -8))
    yield from blender.click(at(-5, 4))
    yield from blender.move(at(10, -6))
    yield from blender.screenshot("incision_preview")
    yield from blender.click(at(10, -6))
    yield from blender.click(at(22, 6))
    yield from blender.key("BACK_SPACE")
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: len(events()) == 1, 2.0, "three clicks and Return make an incision")
    blender.expect(near(first_points(last()), *DRAWN), "its points are where the mouse clicked")
    yield from blender.screenshot("incision")


def freehand_incision(blender: Driver) -> Steps:
    """A stroke closed by C, undone and redone; a line given up."""
    at = lambda x, y: blender.at(height(x, y))  # noqa: E731
    circle = [at(14 + 6 * np.cos(a), 8 + 5 * np.sin(a)) for a in np.linspace(0, 5.2, 14)]
    yield from blender.drag(circle, steps=3)
    yield from blender.screenshot("free_hand_preview")
    yield from blender.key("C")
    yield from blender.wait_until(lambda: len(events()) == 2, 2.0, "a free-hand stroke and C make a closed incision")
    blender.expect(last().basis == "CATMULL_ROM" and last().closed, "it is smooth and closed")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: len(events()) == 1, 2.0, "Ctrl-Z takes the incision back in one step")
    yield from blender.key("Z", ctrl=True, shift=True)
    yield from blender.wait_until(lambda: len(events()) == 2, 2.0, "Ctrl-Shift-Z brings it again")
    yield from blender.click(at(-10, -12))
    yield from blender.key("ESC")
    yield 0.2
    blender.expect(len(events()) == 2, "Esc leaves nothing behind")


def undermining(blender: Driver) -> Steps:
    """Clicks around an area; the last one snaps to the first."""
    at = lambda x, y: blender.at(height(x, y))  # noqa: E731
    yield from blender.set_tool("lappet.cutting.undermining")
    corners = [(-24, -14), (-2, -14), (-2, 10), (-24, 10)]
    for corner in corners:
        yield from blender.click(at(*corner))
    yield from blender.move(at(-23.8, -13.9))
    yield from blender.screenshot("undermine_snap")
    yield from blender.click(at(-23.8, -13.9))
    yield from blender.wait_until(lambda: last().kind == "UNDERMINE", 2.0, "a click near the first point closes it")
    blender.expect(near(first_points(last()), *(height(*c) for c in corners)), "it has the four corners, none twice")


def hook(blender: Driver) -> Steps:
    """A drag from the skin; the empty is there in the end."""
    at = lambda x, y: blender.at(height(x, y))  # noqa: E731
    scene = bpy.context.scene
    yield from blender.set_tool("lappet.hook")
    x, y = at(-6, -4)
    steps = [(x, y), (x + 30, y + 60), (x + 60, y + 120)]
    yield from blender.move(steps[0])
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.05
    yield from blender.move(steps[1])
    yield from blender.move(steps[2])
    yield from blender.screenshot("hook_preview")
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.1
    yield from blender.wait_until(lambda: last().kind == "HOOK", 2.0, "press, drag and release place a hook")
    target = last().target
    scene.frame_set(scene.frame_current + 12)
    yield 0.3
    u, v = blender.at(bpy.data.objects[target.name].matrix_world.translation)
    blender.expect(abs(u - steps[2][0]) < 3 and abs(v - steps[2][1]) < 3, "12 frames on it is where it was dragged")
    yield from blender.screenshot("hook")


def small_tools(blender: Driver) -> Steps:
    """Suture, landmark, retractor and excision, one each."""
    at = lambda x, y: blender.at(height(x, y))  # noqa: E731
    yield from blender.set_tool("lappet.suture")
    yield from blender.click(at(-12, -4))
    yield from blender.move(at(-12, 1))
    yield from blender.screenshot("suture_preview")
    yield from blender.click(at(-12, 1))
    yield from blender.wait_until(lambda: last().kind == "SUTURE", 2.0, "two clicks make a suture")
    yield from blender.set_tool("lappet.landmark")
    yield from blender.click(at(20, -12))
    yield from blender.wait_until(lambda: last().kind == "LANDMARK", 2.0, "a click makes a landmark")
    yield from blender.set_tool("lappet.retractor")
    x, y = at(24, 14)
    yield from blender.drag([(x, y), (x + 40, y + 40)])
    yield from blender.wait_until(lambda: last().kind == "RETRACTOR", 2.0, "a drag places a retractor")
    yield from blender.set_tool("lappet.excise")
    yield from blender.move(at(14, 8))
    blender.event("LEFTMOUSE", "PRESS")
    yield from blender.screenshot("excise_preview")
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.1
    yield from blender.wait_until(lambda: last().kind == "EXCISION", 2.0, "a click makes an excision")


def editing(blender: Driver) -> Steps:
    """Selects, moves, inserts and removes points, and undoes it."""
    at = lambda x, y: blender.at(height(x, y))  # noqa: E731
    scene = bpy.context.scene
    yield from blender.set_tool("lappet.edit")
    scene.frame_set(1)
    yield 0.2
    yield from blender.screenshot("edit")
    yield from blender.click(at(-20, -8))
    yield 0.1
    blender.expect(scene.lappet.active_event == 0, "a click on its point selects the first incision")
    blender.expect(bpy.context.object is None, "and not the object of the skin")
    yield from blender.click(at(-26, 17))
    yield 0.1
    blender.expect(bpy.context.object is not None, "a click beside the plan selects the object there")
    yield from blender.click(blender.within(0.9, 0.1))
    yield 0.1
    blender.expect(not bpy.context.selected_objects, "a click beside everything selects none")
    yield from blender.drag([at(-5, 4), at(-4, 12)])
    yield 0.1
    moved = first_points(scene.lappet.events[0])
    blender.expect(near(moved, height(-20, -8), height(-4, 12), height(10, -6)), "a drag moves its second point")
    yield from blender.click(at(3, 3), ctrl=True)
    yield 0.1
    blender.expect(len(scene.lappet.events[0].points) == 4, "Ctrl-click on its line inserts a point")
    yield from blender.screenshot("edited")
    yield from blender.key("X")
    yield 0.1
    blender.expect(len(scene.lappet.events[0].points) == 3, "X removes it")
    yield from blender.key("Z", ctrl=True)
    yield from blender.key("Z", ctrl=True)
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(
        lambda: near(first_points(bpy.context.scene.lappet.events[0]), *DRAWN),
        2.0,
        "three Ctrl-Z undo the three acts",
    )
    yield from blender.screenshot("undone")


def target(blender: Driver) -> Steps:
    """A hook's target is dragged in the view, keyed where it is let go, and comes back."""
    scene = bpy.context.scene
    hook = next(event for event in scene.lappet.events if event.kind == "HOOK")
    name = hook.target.name
    scene.frame_set(13)
    yield 0.3
    before = bpy.data.objects[name].matrix_world.translation.copy()
    x, y = blender.at(before)
    yield from blender.drag([(x, y), (x + 50, y + 20)])
    yield 0.2
    u, v = blender.at(bpy.data.objects[name].matrix_world.translation)
    blender.expect(abs(u - x - 50) < 3 and abs(v - y - 20) < 3, "a drag moves the target of a hook")
    blender.expect(bpy.context.object.name == name, "and selects it")
    scene.frame_set(14)
    scene.frame_set(13)
    yield 0.1
    u, v = blender.at(bpy.data.objects[name].matrix_world.translation)
    blender.expect(abs(u - x - 50) < 3, "it is keyed: another frame and back does not take it")
    yield from blender.key("Z", ctrl=True)
    yield 0.3
    bpy.context.scene.frame_set(13)  # undo has gone back to the frame of the step before
    there = bpy.data.objects[name].matrix_world.translation
    blender.expect((there - before).length < 0.01, "Ctrl-Z brings it back in one step")


def setting(operator: str) -> bpy.types.OperatorProperties:
    """The settings of the tool in hand."""
    return bpy.context.workspace.tools.from_space_view3d_mode("OBJECT").operator_properties(operator)


def runs(blender: Driver) -> Steps:
    """Runs of sutures: along an incision, and between two edges."""
    yield from blender.set_tool("lappet.suture")
    setting("lappet.place_suture").mode = "INCISION"
    setting("lappet.place_suture").spacing = 5.0
    before = len(events())
    yield from blender.click(blender.at(height(-12, -1.8)))
    yield 0.2
    sewn = bpy.context.scene.lappet.events[before:]
    blender.expect(
        [event.kind for event in sewn] == ["SUTURE_RUN"] and sewn[0].spacing == 5.0,
        f"a click on an incision sews it with one run: {len(sewn)}",
    )
    setting("lappet.place_suture").mode = "RUN"
    setting("lappet.place_suture").count = 3
    before = len(events())
    for place in ((-8, -16), (8, -16)):
        yield from blender.click(blender.at(height(*place)))
    yield from blender.key("RET")
    for place in ((8, -18), (-8, -18)):
        yield from blender.click(blender.at(height(*place)))
    yield from blender.screenshot("run_preview")
    yield from blender.key("RET")
    yield 0.2
    sewn = bpy.context.scene.lappet.events[before:]
    blender.expect([event.kind for event in sewn] == ["SUTURE_RUN"], "two edges and Return make a run")
    ends = [tuple(sewn[0].points[k].co) for k in (0, sewn[0].second_from)]
    blender.expect(
        abs(ends[0][0] - ends[1][0]) < 0.5,
        "whose edges begin at the same end, though one was clicked backwards",
    )
    yield from blender.screenshot("runs")


def without_toolbar(blender: Driver) -> Steps:
    """A tool that is started from the menu, with another in hand; nothing to draw on."""
    yield from blender.set_tool("builtin.select_box")
    before = len(events())
    with blender.override():
        bpy.ops.lappet.draw_incision("INVOKE_DEFAULT")
    yield 0.1
    yield from blender.click(blender.at(height(-25, 15)))
    yield from blender.click(blender.at(height(-15, 16)))
    yield from blender.click(blender.at(height(-15, 16)), button="RIGHTMOUSE")
    yield 0.2
    blender.expect(len(events()) == before + 1, "a tool works from the menu; the right button ends it")
    skin = bpy.context.scene.lappet.skin
    skin.hide_set(True)
    yield 0.3
    yield from blender.set_tool("lappet.landmark")
    yield from blender.click(blender.at(height(5, 5)))
    yield 0.2
    blender.expect(len(events()) == before + 1, "nothing is drawn on skin that is hidden")
    yield from blender.screenshot("hidden")
    skin.hide_set(False)
    yield from blender.key("ESC")  # the sentence that said so
    yield 0.3


def views(blender: Driver) -> Steps:
    """Drawing in a quad view, an orthographic view and through a camera."""
    scene = bpy.context.scene
    yield from blender.set_tool("lappet.landmark")
    with blender.override():
        bpy.ops.screen.region_quadview()
    yield 0.5
    area = blender.area()
    windows = [region for region in area.regions if region.type == "WINDOW"]
    top = max(range(3), key=lambda k: area.spaces.active.region_quadviews[k].view_matrix[2][2])
    views = area.spaces.active.region_quadviews
    views[top].view_location, views[top].view_distance = (0, 0, 0), 60.0
    yield 0.5
    from bpy_extras.view3d_utils import location_3d_to_region_2d

    for k, point in ((top, height(4.0, -15.0)), (3, height(-8.0, 14.0))):
        seen = location_3d_to_region_2d(windows[k], views[k], point)
        yield from blender.click((round(windows[k].x + seen[0]), round(windows[k].y + seen[1])))
        yield 0.2
        found = last()
        held = found.kind == "LANDMARK" and np.abs(first_points(found)[0] - point).max() < 0.8
        blender.expect(held, f"a click in the view {k} of a quad view is where it was made")
    yield from blender.screenshot("quad_view")
    with blender.override():
        bpy.ops.screen.region_quadview()
    yield 0.5
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.location, camera.rotation_euler = (0.0, -60.0, 70.0), (0.7, 0.0, 0.0)
    scene.camera = camera
    blender.area().spaces.active.region_3d.view_perspective = "CAMERA"
    yield 0.5
    yield from blender.click(blender.at(height(9.0, 2.0)))
    yield 0.2
    blender.expect(np.abs(first_points(last())[0] - height(9.0, 2.0)).max() < 0.8, "so it is through a camera")
    yield from blender.screenshot("camera")
    blender.area().spaces.active.region_3d.view_perspective = "PERSP"
    yield 0.3


def interrupted(blender: Driver) -> Steps:
    """The frame changes while a line is drawn; another file is opened while a line is drawn."""
    scene = bpy.context.scene
    scene.frame_set(5)
    yield from blender.set_tool("lappet.cutting.incision")
    yield from blender.click(blender.at(height(-20, -12)))
    yield from blender.key("RIGHT_ARROW")
    yield 0.3
    blender.expect(scene.frame_current == 6, "the arrow keys change the frame while a line is drawn")
    yield from blender.click(blender.at(height(20, -14)))
    yield from blender.key("RET")
    yield 0.2
    blender.expect(last().kind == "INCISION" and last().start == 6.0, "and the cut is made at the frame in view")
    yield from blender.click(blender.at(height(-20, 0)))
    yield 0.1
    bpy.ops.wm.read_homefile(use_empty=True)
    yield 1.0
    blender.expect(len(bpy.context.scene.lappet.events) == 0, "another file can be opened while a line is drawn")
    yield from blender.screenshot("another_file")


if __name__ == "__main__":
    run(scenario)
