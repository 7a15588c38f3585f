"""Follows docs/blender_tutorial.md step by step in a real window and takes its pictures: `run.py tutorial.py`.

`tutorial_pictures.py` cuts them into docs/images. Every act is a click, a drag or a key, or a button's operator.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Euler

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Point, Steps, run

MODULE = "bl_ext.user_default.lappet_blender"
PANELS = ("Tissue", "Materials", "Timeline", "Solve", "Look", "Compare", "Files")
# The Z on the skin, mm: the ends of the central limb are B and C, those of the others A and D.
A, B, C, D = (np.array(corner) for corner in ((0.0, 17.3), (10.0, 0.0), (-10.0, 0.0), (0.0, -17.3)))
UPPER, LOWER = (A + B + C) / 3, (B + C + D) / 3
BESIDE = 0.3  # mm from the cut to a stitch
# Edges that meet: from, to, and a place on the side of the line that is clicked.
SEAMS = (
    ((B, C, UPPER), (D, C, 2 * C - LOWER)),
    ((C, B, LOWER), (A, B, 2 * B - UPPER)),
    ((B, A, UPPER), (D, C, LOWER)),
)


def beside(edge: tuple[Any, Any, Any], away: float = BESIDE, end: float = 0.05) -> list[tuple[float, float]]:
    """The two places to click along an edge of the wound: mm beside it, and that share of it from its ends."""
    start, stop, inside = edge
    along = (stop - start) / np.linalg.norm(stop - start)
    across = (inside - start) - along * ((inside - start) @ along)
    across *= away / np.linalg.norm(across)
    return [tuple(start + share * (stop - start) + across) for share in (end, 1.0 - end)]


def solving() -> Any:
    """What the extension says about solving."""
    return import_module(f"{MODULE}.solving.frames")


def events(kind: str = "") -> list[Any]:
    return [event for event in bpy.context.scene.lappet.events if kind in ("", event.kind)]


def window_call(blender: Driver, button: str, **arguments: Any) -> None:
    """Presses a button: its operator, as the button calls it, with a step of undo."""
    group, _, operator = button.partition(".")
    with blender.override():
        getattr(getattr(bpy.ops, group), operator)("INVOKE_DEFAULT", True, **arguments)


def header(blender: Driver, name: str) -> Point:
    """The header of a panel of the tab, while no panel above it is open."""
    area = blender.region("UI")
    return area.x + 120, area.y + area.height - 17 - 28 * PANELS.index(name)


def view(blender: Driver, axis: str, distance: float, x: float = 4.0) -> Steps:
    """Numpad 7, 3 or Ctrl-7, then zoomed."""
    with blender.override():
        bpy.ops.view3d.view_axis("EXEC_DEFAULT", type=axis)
    yield 0.6
    region = blender.area().spaces.active.region_3d
    region.view_location, region.view_distance = (x, x if axis == "RIGHT" else 0.0, 0.0), distance
    yield 0.4


def turn(blender: Driver, tilt: float, around: float, distance: float) -> Steps:
    """The view turned with the middle button."""
    region = blender.area().spaces.active.region_3d
    region.view_rotation = Euler((tilt, 0.0, around)).to_quaternion()
    region.view_perspective = "PERSP"
    region.view_location, region.view_distance = (4.0, 0.0, 0.0), distance
    yield 0.4


def setting(tool: str, **values: Any) -> None:
    """Settings of the active tool, in the header."""
    active = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT", create=False)
    for name, value in values.items():
        setattr(active.operator_properties(tool), name, value)


def solve(blender: Driver, picture: str = "") -> Steps:
    """Solve, until all frames are there."""
    scene, began = bpy.context.scene, time.monotonic()
    window_call(blender, "lappet.solve")
    if picture:
        while solving().progress_of(scene).done < 15 and solving().progress_of(scene).running:
            yield 0.05
        blender._picture(picture)
    yield from blender.wait_until(lambda: not solving().progress_of(scene).running, 300.0, "the solve ends")
    yield 1.0
    states = solving().frame_runs(scene)
    seconds = round(time.monotonic() - began, 1)
    solved = [run.state for run in states] == ["solved"]
    blender.expect(solved, f"every frame is solved after {seconds} s: {states} {solving().failure_of(scene)}")


def pull(blender: Driver, start: Point, end: Point, picture: str = "") -> Steps:
    """A drag with a picture before the button is let go."""
    yield from blender.move(start)
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.05
    for step in range(1, 9):
        yield from blender.move(tuple(round(a + (b - a) * step / 8) for a, b in zip(start, end, strict=True)))
    if picture:
        yield from blender.screenshot(picture)
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.5


def install(blender: Driver) -> Steps:
    """The zip; then only the viewport and the timeline, so that the pictures are large."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )
    yield 0.5
    for kind in ("OUTLINER", "PROPERTIES"):
        with bpy.context.temp_override(window=blender.window, screen=blender.window.screen, area=blender.area(kind)):
            bpy.ops.screen.area_close()
        yield 0.5
    yield from blender.show_tab("Lappet")
    side = blender.region("UI")
    yield from blender.drag([(side.x + 1, side.y + 300), (side.x - 90, side.y + 300)])
    side = blender.region("UI")
    blender.notes["sidebar"] = (side.x, side.y, side.width, side.height)
    yield from blender.screenshot("tab")


def tissue(blender: Driver) -> Steps:
    """A grid of 100 x 80 mm becomes the tissue."""
    scene = bpy.context.scene
    scene.unit_settings.scale_length, scene.unit_settings.length_unit = 0.001, "MILLIMETERS"
    for each in list(bpy.data.objects):
        bpy.data.objects.remove(each)
    with blender.override():
        bpy.ops.mesh.primitive_grid_add("EXEC_DEFAULT", True, x_subdivisions=50, y_subdivisions=40, size=100.0)
        bpy.ops.transform.resize("EXEC_DEFAULT", True, value=(1.0, 0.8, 1.0))
        bpy.ops.view3d.view_all("EXEC_DEFAULT")
    yield 0.5
    window_call(blender, "lappet.tissue_set")
    yield 1.0
    blender.expect(scene.lappet.tissue.thicken and scene.frame_end == 40, "the open grid is thickened, frames 1 to 40")
    yield from blender.screenshot("tissue_scale")
    window_call(blender, "lappet.tissue_apply_scale")
    scene.lappet.tissue.spacing = 1.5
    window_call(blender, "lappet.tissue_check")
    yield 1.0
    scene.lappet.look.show_lattice = True
    yield from blender.screenshot("tissue")
    scene.lappet.look.show_lattice = False
    side = blender.region("UI")
    yield from blender.click((side.x + 120, side.y + side.height - 17))  # folds the panel Tissue
    dope = blender.area("DOPESHEET_EDITOR")
    with bpy.context.temp_override(window=blender.window, area=dope, region=blender.region("WINDOW", dope.type)):
        bpy.ops.action.view_all()
    yield 0.5


def cut(blender: Driver) -> Steps:
    """The Z at frame 3, the undermining at frame 6."""
    scene = bpy.context.scene
    yield from view(blender, "TOP", 100.0, 6.0)
    scene.frame_set(3)
    yield from blender.set_tool("lappet.cutting.incision")
    for corner in (A, B, C):
        yield from blender.click(blender.at((*corner, 0.0)))
    yield from blender.move(blender.at((*D, 0.0)))
    yield from blender.screenshot("incision")
    yield from blender.click(blender.at((*D, 0.0)))
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: len(events("INCISION")) == 1, 2.0, "four clicks and Return cut the Z")
    scene.frame_set(6)
    yield from blender.set_tool("lappet.cutting.undermining")
    circle = [blender.at((15 * np.cos(t), 24 * np.sin(t), 0.0)) for t in np.linspace(0, 6.1, 40)]
    yield from blender.move(circle[0])
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.05
    for place in circle[1:]:
        yield from blender.move(place)
    yield from blender.screenshot("undermine")
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.1
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: len(events("UNDERMINE")) == 1, 2.0, "a stroke and Return undermine")


def hooks(blender: Driver) -> Steps:
    """Two hooks at frame 8 carry each flap's tip to the far end of the other limb, until frame 26."""
    scene = bpy.context.scene
    scene.frame_set(8)
    yield from view(blender, "TOP", 75.0)
    yield from blender.set_tool("lappet.hook")
    setting("lappet.place_hook", frames=18)
    yield 0.2
    yield from pull(blender, blender.at((8.7, 0.7, 0.0)), blender.at((-0.3, -15.9, 0.0)))
    yield from pull(blender, blender.at((-8.7, -0.7, 0.0)), blender.at((0.3, 15.9, 0.0)), "hook")
    blender.expect(len(events("HOOK")) == 2, "two drags place two hooks")
    for hook in events("HOOK"):
        hook.end = 38.0  # Release, in the panel
    yield from blender.screenshot("hooks")


def sew(blender: Driver, height: float, picture: str) -> Steps:
    """Three runs of six stitches."""
    before = len(events("SUTURE_RUN"))
    yield from blender.set_tool("lappet.suture")
    setting("lappet.place_suture", mode="RUN", count=6, duration=10.0)
    yield 0.3
    for index, seam in enumerate(SEAMS):
        for which, edge in enumerate(seam):
            for x, y in beside(edge):
                yield from blender.click(blender.at((x, y, height)))
            if index == 1 and which == 1:
                yield from blender.screenshot(picture)
            yield from blender.key("RET")
            yield 0.3
    made = len(events("SUTURE_RUN")) - before
    blender.expect(made == 3, f"three seams are {made} runs")


def places(blender: Driver, height: float, name: str) -> Steps:
    """A picture of where to click; `tutorial_pictures.py` numbers the places, a little off the line to be read."""
    yield from blender.screenshot(name)
    spots = [blender.at((x, y, height)) for seam in SEAMS for edge in seam for x, y in beside(edge, 1.1, 0.16)]
    blender.notes[name] = spots


def stitches(blender: Driver) -> Steps:
    """The deep row from below, through X-ray; the row in the skin from above. Both at frame 26."""
    scene = bpy.context.scene
    scene.frame_set(26)
    shading = blender.area().spaces.active.shading
    yield from view(blender, "TOP", 62.0)
    yield from places(blender, 0.0, "places_skin")
    yield from view(blender, "BOTTOM", 62.0)
    shading.show_xray = True
    yield from places(blender, -4.0, "places_deep")
    yield from sew(blender, -4.0, "sew_deep")
    shading.show_xray = False
    yield from view(blender, "TOP", 62.0)
    yield from sew(blender, 0.0, "sew_skin")


def watched(blender: Driver) -> Steps:
    """Solve, scrub."""
    scene = bpy.context.scene
    yield from turn(blender, 0.75, 0.15, 75.0)
    yield from solve(blender, "solving")
    scene.lappet.look.show_plan = False
    for frame in (17, 26, 32, 40):
        scene.frame_set(frame)
        yield 8.0  # the stitches of a frame are found a few at a time
        yield from blender.screenshot(f"solved_{frame}")
    scene.lappet.look.show_plan = True


def second_thoughts(blender: Driver) -> Steps:
    """The flaps go through each other: lift one. Then undo, redo."""
    scene = bpy.context.scene
    scene.frame_set(17)
    yield from view(blender, "RIGHT", 70.0, 0.0)
    yield from blender.set_tool("lappet.edit")
    hook_1, hook_2 = events("HOOK")
    for hook, up in ((hook_1, 8.0), (hook_2, 13.0)):
        place = hook.target.matrix_world.translation.copy()
        start, end = blender.at(place), blender.at((place.x, place.y, place.z + up))
        yield from pull(blender, start, end, "lift" if hook == hook_2 else "")
    heights = [round(hook.target.matrix_world.translation.z, 1) for hook in events("HOOK")]
    blender.expect(min(heights) > 7.0, f"both targets are lifted: {heights} mm")
    yield 1.5
    # Until the cuts are prepared anew, frames count as stale from the hook's first one on.
    yield from blender.wait_until(lambda: solving().manifest_of(scene) is not None, 60.0, "the cuts are prepared")
    yield 2.0
    runs = solving().frame_runs(scene)
    found = [(run.state, run.first, run.last) for run in runs]
    blender.expect(found == [("solved", 1, 8), ("stale", 9, 40)], f"later frames are stale: {runs}")
    yield from blender.screenshot("stale")
    yield from solve(blender)
    yield from turn(blender, 0.9, 0.3, 75.0)
    scene.lappet.look.show_plan = False
    yield from blender.screenshot("lifted")
    scene.lappet.look.show_plan = True
    lifted = solving().manifest_of(scene).key
    for _ in range(2):
        yield from blender.key("Z", ctrl=True)
        yield 0.5
    yield from blender.wait_until(
        lambda: (
            solving().manifest_of(bpy.context.scene) is not None
            and [run.state for run in solving().frame_runs(bpy.context.scene)] == ["solved"]
        ),
        6.0,
        "two Ctrl-Z: the frames from before are there again, all solved",
    )
    blender.expect(solving().manifest_of(bpy.context.scene).key != lifted, "they are those without the lift")
    yield from blender.screenshot("undone")
    yield 4.0
    bpy.context.scene.frame_set(17)
    yield from blender.screenshot("undone_17")
    for _ in range(2):
        yield from blender.key("Z", ctrl=True, shift=True)
        yield 0.5
    yield from blender.wait_until(
        lambda: (
            solving().manifest_of(bpy.context.scene) is not None
            and solving().manifest_of(bpy.context.scene).key == lifted
        ),
        6.0,
        "Ctrl-Shift-Z brings the lift back",
    )


def compared(blender: Driver) -> Steps:
    """A variant without the deep row beside the first, and the strain map."""
    bpy.context.scene.frame_set(40)
    bpy.context.scene.name = "Z-plasty"
    window_call(blender, "lappet.variant_new", name="No deep row")
    yield 1.0
    variant = bpy.context.window.scene
    blender.expect(variant.name == "No deep row", f"the window is in the variant {variant.name}")
    for event in [e for e in variant.lappet.events if e.kind == "SUTURE_RUN"][:3]:
        event.enabled = False
    yield from solve(blender)
    for name in ("Timeline", "Solve", "Compare"):
        yield from blender.click(header(blender, name))
        yield 0.4
    variant.lappet.look.show_plan = False
    yield from turn(blender, 0.5, 0.0, 240.0)
    blender.area().spaces.active.region_3d.view_location = (92.0, -6.0, 0.0)
    yield 8.0
    yield from blender.screenshot("compare")
    yield from blender.click(header(blender, "Compare"))
    yield from blender.click(header(blender, "Look"))
    yield 0.4
    blender.window.scene = bpy.data.scenes["Z-plasty"]
    scene = bpy.data.scenes["Z-plasty"]
    window_call(blender, "lappet.look_preset", preset="STRAIN")
    yield from turn(blender, 0.4, 0.0, 165.0)
    blender.area().spaces.active.region_3d.view_location = (12.0, -12.0, 0.0)
    yield 6.0
    yield from blender.screenshot("strain")
    window_call(blender, "lappet.look_preset", preset="OPERATION")
    scene.lappet.look.color, scene.lappet.look.show_plan = "GRID", False
    yield 4.0


def rendered(blender: Driver) -> Steps:
    """The stage and the picture."""
    scene = bpy.context.scene
    window_call(blender, "lappet.set_stage", engine="WORKBENCH")
    yield 1.0
    blender.expect(scene.camera is not None, "there is a stage with a camera")
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 1200, 800, 100
    path = blender.folder / "render.png"
    bpy.ops.lappet.render_still(filepath=str(path))
    blender.expect(path.is_file(), "the picture is written")


PARTS = (install, tissue, cut, hooks, stitches, watched, second_thoughts, compared, rendered)


def scenario(blender: Driver) -> Iterator[float]:
    """The whole tutorial."""
    for part in PARTS:
        began = time.monotonic()
        yield from part(blender)
        print(f"{part.__name__}: {time.monotonic() - began:.0f} s", flush=True)


if __name__ == "__main__":
    run(scenario, limit=900.0)
