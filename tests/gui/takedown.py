"""The extension is disabled and reinstalled whatever it is doing: `python tests/gui/run.py takedown.py`.

Each part leaves Blender at work (a line half drawn, a hook held, a handle dragged, live mode, a solve) and takes the
extension down; then the window is drawn and gets events as before.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import addon_utils
import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Steps, run
from tools import MODULE, height, prepare

END = 12


def disable() -> None:
    """What the switch in the preferences does."""
    bpy.ops.preferences.addon_disable(module=MODULE)


def enable() -> None:
    bpy.ops.preferences.addon_enable(module=MODULE)


def reinstall() -> None:
    """What Install from Disk does with a zip of a version that is there."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["LAPPET_ZIP"], repo="user_default", enable_on_install=True
    )


def running() -> list[str]:
    """The modal operators of the window."""
    return [each.bl_idname for each in bpy.context.window.modal_operators] if bpy.context.window else []


def handlers() -> list[str]:
    """The handlers that Blender calls and that belong to the extension."""
    found = (getattr(bpy.app.handlers, name) for name in dir(bpy.app.handlers))
    every = [each for handlers in found if isinstance(handlers, list) for each in handlers]
    return [each.__name__ for each in every if each.__module__.startswith(MODULE)]


def pull() -> None:
    """A hook that waits to be dragged, and a flap with its handles."""
    bpy.ops.lappet.hook_add(anchor=height(-1, 5), target=(-2, 6, 6), start=3.0, arrive=3.0)
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": height(x, -6)} for x in (-14, 12)], time=2.0, kerf=0.2)


def scenario(blender: Driver) -> Steps:
    """Takes the extension down in every state."""
    yield from prepare(blender)
    bpy.context.scene.frame_end = END
    bpy.context.scene.lappet.tissue.spacing = 2.0
    pull()
    bpy.ops.ed.undo_push(message="Procedure")
    yield from blender.show_tab("Lappet")
    yield 0.5
    states = (line_half_drawn, hook_held, suture_half_placed, handle_held, strip_held, live, solving, playing)
    for begin in (*states, lattice_shown):
        for end in (disable, reinstall):
            yield from taken_down(blender, begin, end)
    yield from set_while_it_works(blender)


def taken_down(blender: Driver, begin: Callable[[Driver], Steps], end: Callable[[], None]) -> Steps:
    """One state and one way of ending."""
    what = f"{begin.__name__.replace('_', ' ')}, {end.__name__}"
    print(f"--- {what}", flush=True)
    yield from begin(blender)
    end()
    yield from moves(blender)
    blender.event("LEFTMOUSE", "RELEASE")
    yield from moves(blender)
    if end is disable:
        blender.expect(not addon_utils.check(MODULE)[1], f"{what}: it is disabled")
        blender.expect(not handlers(), f"{what}: no handler is left: {handlers()}")
        tool = bpy.context.workspace.tools.from_space_view3d_mode("OBJECT")
        blender.expect(not tool.idname.startswith("lappet."), f"{what}: Blender's own tool is in hand: {tool.idname}")
        left = [each for each in running() if each.startswith("LAPPET")]
        blender.expect(not left, f"{what}: no tool runs on: {left}")
        yield from blender.click(blender.within(0.5, 0.5))
        yield from blender.key("Z", ctrl=True)
        yield from blender.key("Z", ctrl=True, shift=True)
        enable()
    yield from moves(blender)
    blender.expect(addon_utils.check(MODULE) == (True, True), f"{what}: it works again")
    blender.expect(bpy.context.scene.lappet.tissue.object is not None, f"{what}: the scene has its tissue still")
    yield 0.3


def moves(blender: Driver) -> Steps:
    """The mouse goes over the view, the toolbar and the sidebar."""
    for across, up in ((0.3, 0.3), (0.5, 0.5), (0.7, 0.4)):
        yield from blender.move(blender.within(across, up))
    for region in ("TOOLS", "UI"):
        yield from blender.move(blender.within(0.5, 0.5, region))
    for area in blender.window.screen.areas:
        area.tag_redraw()
    yield 0.2


def line_half_drawn(blender: Driver) -> Steps:
    yield from blender.set_tool("lappet.cutting.incision")
    yield from blender.click(blender.at(height(-20, -8)))
    yield from blender.click(blender.at(height(-5, 4)))
    yield from blender.move(blender.at(height(10, -6)))


def hook_held(blender: Driver) -> Steps:
    yield from blender.set_tool("lappet.hook")
    x, y = blender.at(height(5, 3))
    yield from blender.move((x, y))
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.05
    yield from blender.move((x - 30, y + 40))


def suture_half_placed(blender: Driver) -> Steps:
    yield from blender.set_tool("lappet.suture")
    yield from blender.click(blender.at(height(-4, -5)))


def handle_held(blender: Driver) -> Steps:
    scene = bpy.context.scene
    yield from blender.set_tool("builtin.select_box")
    if not scene.lappet.flaps:
        with blender.override():
            bpy.ops.lappet.flap_limberg("EXEC_DEFAULT", True, side=8.0, at=height(0.0, 0.0), lines="X", time=1)
    flaps = import_module(f"{MODULE}.model.laid_flaps")
    for index in range(len(scene.lappet.events)):
        scene.lappet.active_event = index
        if flaps.active_flap(scene):
            break
    yield 1.0
    gizmos = import_module(f"{MODULE}.tools.flap_gizmos")
    places = {h.name: p for h, p in gizmos.shown_places(scene, blender.area().spaces.active)}
    at = blender.at(places["place"])
    yield from blender.move(at)
    yield 0.3
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from blender.move((at[0] + 20, at[1] + 10))
    yield from blender.move((at[0] + 40, at[1] + 15))


def strip_held(blender: Driver) -> Steps:
    editor = "DOPESHEET_EDITOR"
    with blender.override(area=editor):
        bpy.ops.lappet.strips_room("INVOKE_DEFAULT")
        bpy.ops.action.view_all()
    low = blender.area(editor)
    yield from blender.move((low.x + low.width // 2, low.y + low.height))  # where the mouse is put: only events count
    yield 1.0
    view = import_module(f"{MODULE}.strips.strip_view")
    area, region = blender.area(editor), blender.region("WINDOW", editor)
    picture = view.picture_in(bpy.context.scene, area.spaces.active, region)
    box = next(each for each in picture.boxes if each.strip.kind == "HOOK")
    at = round(region.x + 0.5 * (box.x0 + box.x1)), round(region.y + 0.5 * (box.y0 + box.y1))
    yield from blender.move(at)
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.1
    yield from blender.move((at[0] + 30, at[1]))
    yield from blender.move((at[0] + 60, at[1]))
    blender.expect(bool(view.preview.spans), "a strip is held")


def live(blender: Driver) -> Steps:
    scene = bpy.context.scene
    scene.frame_set(4)
    scene.lappet.active_event = next(k for k, each in enumerate(scene.lappet.events) if each.kind == "HOOK")
    yield 1.0
    with blender.override("UI"):
        bpy.ops.lappet.live("INVOKE_DEFAULT")
    yield 0.3
    scene.lappet.events[scene.lappet.active_event].target.location.z += 0.5
    yield 0.5


def solving(blender: Driver) -> Steps:
    with blender.override("UI"):
        bpy.ops.lappet.solve("INVOKE_DEFAULT")
    yield 0.6


def playing(blender: Driver) -> Steps:
    with blender.override():
        bpy.ops.screen.animation_play()
    yield 0.5


def lattice_shown(blender: Driver) -> Steps:
    with blender.override():
        bpy.ops.screen.animation_cancel()
    bpy.context.scene.lappet.look.show_lattice = True
    yield from blender.set_tool("lappet.edit")
    yield from blender.click(blender.at(height(-1, 5)))
    yield 0.3


def set_while_it_works(blender: Driver) -> Steps:
    """Makes another mesh the tissue, and the first again, while frames are solved, played and drawn; undoes it."""
    print("--- tissue_set while the window works", flush=True)
    if "Other" not in bpy.data.objects:
        with blender.override():
            bpy.ops.mesh.primitive_grid_add(
                "EXEC_DEFAULT", True, x_subdivisions=30, y_subdivisions=20, size=40.0, location=(80.0, 0.0, 0.0)
            )
            bpy.context.object.name = "Other"
        bpy.ops.ed.undo_push(message="Another mesh")
    for state in (solving, playing, line_half_drawn):
        yield from state(blender)
        for name, thickness in (("Other", 4.0), ("block", 0.0)) * 2:
            with blender.override("UI"):
                bpy.ops.lappet.tissue_set("EXEC_DEFAULT", True, object=name, thickness=thickness)
            found = bpy.context.scene.lappet.tissue.object
            blender.expect(found is not None and found.name == name, f"{state.__name__}: {name} becomes the tissue")
            yield from moves(blender)
            yield from blender.key("Z", ctrl=True)
            yield 0.2
        with blender.override():
            bpy.ops.screen.animation_cancel()
        yield from blender.key("ESC")
        bpy.ops.lappet.tissue_set("EXEC_DEFAULT", True, object="block")
        yield 0.2


if __name__ == "__main__":
    run(scenario, limit=570.0)
