"""The strip timeline in a real window, with a mouse and keys: `python tests/gui/run.py strips.py`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

sys.path.insert(0, str(Path(__file__).parent))

from event_driver import Driver, Point, Steps, run
from tools import MODULE, height, prepare

EDITOR = "DOPESHEET_EDITOR"


def box(blender: Driver, name: str, share: float = 0.5) -> Point:
    """The window's pixel of a strip, `share` of the way from its begin to its end."""
    area, region = blender.area(EDITOR), blender.region("WINDOW", EDITOR)
    picture = view().picture_in(bpy.context.scene, area.spaces.active, region)
    found = next(each for each in picture.boxes if each.strip.name == name)
    x = found.x0 + share * (found.x1 - found.x0)
    return round(region.x + x), round(region.y + 0.5 * (found.y0 + found.y1))


def pixels(blender: Driver, frames: float) -> int:
    """How many pixels so many frames are wide."""
    region = blender.region("WINDOW", EDITOR)
    return round(frames * view().view_of(bpy.context.scene, blender.area(EDITOR).spaces.active, region).scale)


def view() -> Any:
    """The add-on's module."""
    return sys.modules[f"{MODULE}.strips.strip_view"]


def span(name: str) -> tuple[float, float]:
    """When an event begins and has ended."""
    event = bpy.context.scene.lappet.events[name]
    return float(event.start), float(event.end if event.kind == "HOOK" else event.start + event.duration)


def chosen() -> list[str]:
    """The events whose strips are selected."""
    return [event.name for event in bpy.context.scene.lappet.events if event.selected]


def muted() -> list[str]:
    """The events that do not take place."""
    return [event.name for event in bpy.context.scene.lappet.events if not event.enabled]


def shifted(at: Point, by: int) -> Point:
    """A pixel beside another."""
    return at[0] + by, at[1]


def keyframes() -> tuple[float, float]:
    """The first and the last keyframe of the target of hook_1."""
    first, last = bpy.context.scene.lappet.events["hook_1"].target.animation_data.action.frame_range
    return float(first), float(last)


def operation() -> None:
    """Cuts, two hooks and a row of sutures."""
    flap = [height(*each) for each in ((-14, -6), (-2, 8), (12, 8), (13, -4))]
    bpy.ops.lappet.incision_add(points=[{"name": "", "co": p} for p in flap], time=3.0, kerf=0.2)
    bpy.ops.lappet.hook_add(anchor=height(-1, 5), target=(-2, 6, 6), start=6.0, arrive=10.0, end=20.0)
    bpy.ops.lappet.hook_add(anchor=height(9, 5), target=(9, 7, 6), start=8.0, arrive=12.0, end=18.0)
    for index, x in enumerate((0.0, 3.0, 6.0, 9.0)):
        bpy.ops.lappet.suture_add(first=height(x, 7.6), second=height(x, 8.4), start=22 + 2 * index, duration=2)
    bpy.ops.ed.undo_push(message="Procedure")


def scenario(blender: Driver) -> Steps:
    """Drags, stretches, selects, copies, mutes and moves a step; each is undone by one Ctrl-Z."""
    yield from prepare(blender)
    operation()
    editor = blender.area(EDITOR)
    with blender.override(area=EDITOR):
        bpy.ops.action.view_all()
    yield from blender.move(blender.within(0.5, 0.5))  # over a region Blender moves no edge
    with blender.override(area=EDITOR):
        done = bpy.ops.lappet.strips_room("INVOKE_DEFAULT")
    blender.expect(done == {"FINISHED"}, "there is an act that makes room for strips")
    yield from blender.move((editor.x + editor.width // 2, editor.y + editor.height))  # the warped mouse: events count
    yield 1.0
    blender.expect(editor.height > 200, f"the Timeline is {editor.height} pixels high")
    blender.notes["editor"] = [editor.width, editor.height, editor.spaces.active.mode]
    yield from blender.screenshot("timeline")
    yield from dragging(blender)
    yield from stretching(blender)
    yield from snapping(blender)
    yield from several(blender)
    yield from steps(blender)
    yield from copies(blender)
    yield from tall(blender)
    yield from beside(blender)


def dragging(blender: Driver) -> Steps:
    """A hook goes three frames later, by hand, and back by Ctrl-Z."""
    at, before = box(blender, "hook_1"), keyframes()
    yield from blender.move(at)
    blender.event("LEFTMOUSE", "PRESS")
    yield 0.1
    for step in range(1, 7):
        yield from blender.move(shifted(at, pixels(blender, 0.5 * step)))
    blender.expect(span("hook_1") == (6.0, 20.0), f"the hook waits for the release: {span('hook_1')}")
    yield from blender.screenshot("dragged")
    blender.event("LEFTMOUSE", "RELEASE")
    yield from blender.wait_until(lambda: span("hook_1") == (9.0, 23.0), 3.0, f"a drag moves: {span('hook_1')}")
    after = keyframes()
    blender.expect(after == (before[0] + 3.0, before[1] + 3.0), f"its target's keyframes with it: {before}, {after}")
    name = bpy.context.window_manager.operators[-1].bl_idname
    blender.expect(name == "LAPPET_OT_strips_move", f"the panel of the last operation is that of the drag: {name}")
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: span("hook_1") == (6.0, 20.0), 3.0, f"Ctrl-Z takes it back: {span('hook_1')}")
    yield from blender.key("Z", ctrl=True, shift=True)
    yield from blender.wait_until(lambda: span("hook_1") == (9.0, 23.0), 3.0, "Ctrl-Shift-Z does it again")
    yield from blender.key("Z", ctrl=True)
    yield 0.3


def stretching(blender: Driver) -> Steps:
    """The release of a hook, and Esc."""
    at = box(blender, "hook_1", 0.995)
    yield from blender.drag([at, shifted(at, pixels(blender, 2.2))])
    yield from blender.wait_until(lambda: span("hook_1") == (6.0, 22.0), 3.0, f"an end snaps: {span('hook_1')}")
    yield from undone(blender, lambda: span("hook_1") == (6.0, 20.0), "its end is where it was")
    at = box(blender, "hook_2")
    yield from blender.move(at)
    blender.event("LEFTMOUSE", "PRESS")
    yield from blender.move(shifted(at, pixels(blender, 5)))
    yield from blender.key("ESC")
    blender.event("LEFTMOUSE", "RELEASE")
    yield 0.2
    blender.expect(span("hook_2") == (8.0, 18.0), f"Esc leaves it where it was: {span('hook_2')}")


def undone(blender: Driver, condition: Callable[[], bool], sentence: str) -> Steps:
    """One Ctrl-Z takes the last act back, as the condition tells."""
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(condition, 3.0, f"by one Ctrl-Z {sentence}")
    yield 0.3


def done_again(blender: Driver, condition: Callable[[], bool], sentence: str) -> Steps:
    """One Ctrl-Shift-Z does it again."""
    yield from blender.key("Z", ctrl=True, shift=True)
    yield from blender.wait_until(condition, 3.0, f"by Ctrl-Shift-Z {sentence}")
    yield 0.3


def snapping(blender: Driver) -> Steps:
    """Ctrl moves without snapping; where that left a strip, another one snaps."""
    at = box(blender, "hook_2")
    yield from blender.drag([at, shifted(at, pixels(blender, 0.4))], ctrl=True)
    yield from blender.wait_until(
        lambda: 8.1 < span("hook_2")[0] < 8.9, 3.0, f"Ctrl moves by parts of a frame: {span('hook_2')}"
    )
    odd = span("hook_2")[0]
    at = box(blender, "hook_1")
    yield from blender.drag([at, shifted(at, pixels(blender, odd - 6.0) + 4)])
    yield from blender.wait_until(
        lambda: abs(span("hook_1")[0] - odd) < 1e-4, 3.0, f"a begin snaps to that of another: {span('hook_1')}, {odd}"
    )
    yield from undone(blender, lambda: span("hook_1") == (6.0, 20.0), "hook_1 is where it was")
    yield from undone(blender, lambda: span("hook_2") == (8.0, 18.0), "hook_2 is where it was")


def several(blender: Driver) -> Steps:
    """Two that are selected are dragged together, G moves without a button, a double click goes to the frame."""
    yield from blender.click(box(blender, "suture_3"))
    yield from blender.click(box(blender, "suture_4"), shift=True)
    at = box(blender, "suture_4")
    yield from blender.drag([at, shifted(at, pixels(blender, 2.1))])
    yield from blender.wait_until(
        lambda: (span("suture_3")[0], span("suture_4")[0]) == (28.0, 30.0), 3.0, f"both move: {span('suture_3')}"
    )
    yield from undone(
        blender, lambda: (span("suture_3")[0], span("suture_4")[0]) == (26.0, 28.0), "both are where they were"
    )
    at = box(blender, "hook_2")
    yield from blender.click(at)
    yield from blender.key("G")
    yield from blender.move(shifted(at, pixels(blender, 1)))
    yield from blender.move(shifted(at, pixels(blender, 2.1)))
    yield from blender.screenshot("moved_by_g")
    yield from blender.key("RET")
    yield from blender.wait_until(lambda: span("hook_2") == (10.0, 20.0), 3.0, f"G and Return move: {span('hook_2')}")
    yield from undone(blender, lambda: span("hook_2") == (8.0, 18.0), "it is where it was")
    bpy.context.scene.frame_set(1)
    yield from blender.move(box(blender, "suture_2"))
    with blender.override(area=EDITOR):  # a double click, which Blender does not simulate
        bpy.ops.lappet.strip_jump("INVOKE_DEFAULT")
    yield from blender.wait_until(
        lambda: bpy.context.scene.frame_current == 24, 3.0, "a double click goes to the frame at which a strip begins"
    )
    keys = bpy.context.window_manager.keyconfigs.user.keymaps["Dopesheet"].keymap_items
    values = [each.value for each in keys if each.idname == "lappet.strip_jump"]
    blender.expect(values == ["DOUBLE_CLICK"], f"it hangs on the double click: {values}")


def marked() -> list[tuple[int, str]]:
    """The markers of the scene, by frame."""
    return sorted((each.frame, each.name) for each in bpy.context.scene.timeline_markers)


def steps(blender: Driver) -> Steps:
    """Markers name the steps; the name of one is dragged."""
    with blender.override(area=EDITOR):
        bpy.ops.lappet.steps_mark("EXEC_DEFAULT", True, language="en")
    yield 0.3
    markers = marked()
    blender.expect((6, "Raised with hooks") in markers, f"markers name the steps: {markers}")
    yield from undone(blender, lambda: marked() == [], "no marker is left")
    yield from done_again(blender, lambda: marked() == markers, "the markers are there")
    yield from blender.screenshot("steps")
    area, region = blender.area(EDITOR), blender.region("WINDOW", EDITOR)
    bands = view().picture_in(bpy.context.scene, area.spaces.active, region).steps
    band = next(each for each in bands if each.step.name == "Closed with sutures")
    at = round(region.x + band.x0 + 20), round(region.y + 0.5 * (band.y0 + band.y1))
    yield from blender.click(at)
    every = ["suture_1", "suture_2", "suture_3", "suture_4"]
    yield from blender.wait_until(lambda: chosen() == every, 3.0, f"a click on a step's name selects it: {chosen()}")
    yield 0.5  # or it were a double click
    yield from blender.drag([at, shifted(at, pixels(blender, 3.1))])
    yield from blender.wait_until(
        lambda: span("suture_1")[0] == 25.0 and span("suture_4")[0] == 31.0,
        3.0,
        f"the name of a step moves all that is in it: {span('suture_1')}",
    )
    frames = [each.frame for each in bpy.context.scene.timeline_markers if each.name == "Closed with sutures"]
    blender.expect(frames == [25], f"and its marker: {frames}")
    yield from undone(
        blender,
        lambda: (span("suture_1")[0], span("suture_4")[0]) == (22.0, 28.0) and marked() == markers,
        "all of it and the marker are where they were",
    )
    yield from done_again(blender, lambda: span("suture_1")[0] == 25.0, "the step is moved")


def copies(blender: Driver) -> Steps:
    """Clicks select; Shift-D copies; H mutes; X removes."""
    yield from blender.click(box(blender, "suture_1"))
    blender.expect(chosen() == ["suture_1"], f"a click selects one strip: {chosen()}")
    yield from blender.click(box(blender, "suture_2"), shift=True)
    blender.expect(chosen() == ["suture_1", "suture_2"], f"Shift and a click add another: {chosen()}")
    at = box(blender, "suture_2")
    yield from blender.move(at)
    yield from blender.key("H")
    blender.expect(muted() == ["suture_1", "suture_2"], f"H mutes both: {muted()}")
    yield from blender.screenshot("muted")
    yield from undone(blender, lambda: muted() == [], "both take place")
    yield from done_again(blender, lambda: muted() == ["suture_1", "suture_2"], "both are off")
    yield from blender.move(box(blender, "suture_2"))
    yield from blender.key("H")
    yield from blender.wait_until(lambda: muted() == [], 3.0, f"H once more: both are on: {muted()}")
    count = len(bpy.context.scene.lappet.events)
    yield from blender.click(box(blender, "hook_2"))
    at = box(blender, "hook_2")
    yield from blender.key("D", shift=True)
    yield from blender.move(shifted(at, pixels(blender, 4)))
    yield from blender.move(shifted(at, pixels(blender, 12)))
    yield from blender.screenshot("copied")
    yield from blender.click(shifted(at, pixels(blender, 12)))
    yield from blender.wait_until(
        lambda: len(bpy.context.scene.lappet.events) == count + 1, 3.0, "Shift-D and a click add a copy"
    )
    blender.expect(chosen() == ["hook_3"] and span("hook_3")[0] > 14.0, f"it is selected, later: {span('hook_3')}")
    yield from undone(blender, lambda: len(bpy.context.scene.lappet.events) == count, "the copy is gone")
    yield from done_again(blender, lambda: len(bpy.context.scene.lappet.events) == count + 1, "it is there")
    yield from blender.move(box(blender, "hook_3"))
    yield from blender.key("X")
    yield from blender.wait_until(
        lambda: len(bpy.context.scene.lappet.events) == count, 3.0, "X over a strip removes its event"
    )
    yield from blender.key("Z", ctrl=True)
    yield from blender.wait_until(lambda: len(bpy.context.scene.lappet.events) == count + 1, 3.0, "undone by Ctrl-Z")


def tall(blender: Driver) -> Steps:
    """The Dope Sheet of the workspace Animation."""
    blender.window.workspace = bpy.data.workspaces["Animation"]
    yield 1.0
    modes = [area.spaces.active.mode for area in blender.window.screen.areas if area.type == EDITOR]
    blender.expect(blender.area(EDITOR).spaces.active.mode == "DOPESHEET", f"the Dope Sheet is the largest: {modes}")
    with blender.override(area=EDITOR):
        bpy.ops.action.view_all()
    yield from blender.move(blender.within(0.5, 0.2, area=EDITOR))
    yield from blender.screenshot("dope_sheet")
    before = span("hook_1")
    blender.notes["dope sheet"] = [box(blender, "hook_1"), pixels(blender, -1), list(before)]
    at = box(blender, "hook_1")
    yield from blender.drag([at, shifted(at, pixels(blender, -1))])
    yield from blender.screenshot("dope_sheet_dragged")
    yield from blender.wait_until(
        lambda: span("hook_1")[0] == before[0] - 1.0, 3.0, f"a drag works there too: {span('hook_1')}"
    )


def beside(blender: Driver) -> Steps:
    """What lies beside the strips is Blender's: the playhead, and box selection."""
    region = blender.region("WINDOW", EDITOR)
    yield from blender.click((round(region.x + 0.5 * region.width), region.y + region.height - 8))
    yield 0.2
    playhead = bpy.context.scene.frame_current
    blender.expect(playhead != 1, f"the ruler moves the playhead: {playhead}")
    bpy.context.scene.lappet.show_strips = False
    yield from blender.screenshot("hidden")


if __name__ == "__main__":
    run(scenario)
