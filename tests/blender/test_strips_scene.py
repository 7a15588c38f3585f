"""Strips of a scene's events: what operators on them change, refuse and undo."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy
import pytest

from event_patch import co, patch_scene
from lappet.core.problem_code import ProblemCode
from lappet_blender.model.event_list import find_event
from lappet_blender.model.keyframes import curves_of
from lappet_blender.strips import strip_view
from lappet_blender.strips.scene_strips import scene_steps, scene_strips
from lappet_blender.strips.strip_keys import KEYS
from lappet_blender.strips.strip_modal import LAPPET_OT_strips_move
from lappet_blender.strips.strip_overlay import LANE_COLORS, rectangles
from refusals import refusal_code

TOP = 4.0
ops = bpy.ops.lappet


@pytest.fixture
def operation(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A cut at 3, a hook from 8 to 20, a suture from 21 to 24 and a landmark, on a patch."""
    patch_scene(scene, (60.0, 40.0, TOP), 40)
    ops.incision_add(points=co([(-10, 0, TOP), (10, 0, TOP)]), time=3)
    ops.hook_add(anchor=(1, 1, TOP), target=(1, 8, 9), start=8, arrive=12, end=20)
    ops.suture_add(first=(3, 1, TOP), second=(3, -1, TOP), start=21, duration=3)
    ops.landmark_add(point=(5, 5, TOP), label="here")
    bpy.ops.ed.undo_push(message="the operation")
    return scene


def spans() -> dict[str, tuple[float, float]]:
    return {strip.name: (strip.start, strip.end) for strip in scene_strips(bpy.context.scene)}


def keys(name: str) -> set[float]:
    target = find_event(bpy.context.scene, name).target
    return {key.co[0] for curve in curves_of(target) for key in curve.keyframe_points}


BEFORE = {"incision_1": (3.0, 3.0), "hook_1": (8.0, 20.0), "suture_1": (21.0, 24.0)}


def test_every_event_but_a_landmark_is_a_strip(operation: bpy.types.Scene) -> None:
    assert spans() == BEFORE


def test_strips_move_with_their_keyframes_in_one_step_of_undo(operation: bpy.types.Scene) -> None:
    before = keys("hook_1")
    ops.strips_move("EXEC_DEFAULT", True, events="hook_1 suture_1", shift=2.0)
    assert spans() == {"incision_1": (3.0, 3.0), "hook_1": (10.0, 22.0), "suture_1": (23.0, 26.0)}
    assert keys("hook_1") == {each + 2.0 for each in before}
    bpy.ops.ed.undo()
    assert spans() == BEFORE
    assert keys("hook_1") == before
    bpy.ops.ed.redo()
    assert spans()["hook_1"] == (10.0, 22.0)


def test_an_end_changes_the_release_of_a_hook_and_the_duration_of_a_suture(operation: bpy.types.Scene) -> None:
    ops.strips_move(events="hook_1", part="END", shift=5.0)
    ops.strips_move(events="suture_1", part="END", shift=2.5)
    events = operation.lappet.events
    assert events["hook_1"].end == 25.0
    assert events["suture_1"].duration == 5.5
    ops.strips_move(events="suture_1", part="START", shift=1.0)
    assert (events["suture_1"].start, events["suture_1"].duration) == (22.0, 4.5)


def test_a_move_that_cannot_be_changes_nothing_at_all(operation: bpy.types.Scene) -> None:
    before = keys("hook_1")
    late = lambda: ops.strips_move(events="incision_1 hook_1", shift=35.0)  # noqa: E731
    assert refusal_code(late) is ProblemCode.EVENT_AFTER_END
    assert spans() == BEFORE
    assert keys("hook_1") == before


def test_without_names_the_selected_strips_are_meant(operation: bpy.types.Scene) -> None:
    ops.strips_select(which="NONE")
    operation.lappet.active_event = 0
    ops.strips_move(shift=1.0)
    assert spans()["incision_1"] == (4.0, 4.0)  # the active one, for none is selected
    for name in ("hook_1", "suture_1"):
        operation.lappet.events[name].selected = True
    ops.strips_move(shift=1.0)
    assert spans() == {"incision_1": (4.0, 4.0), "hook_1": (9.0, 21.0), "suture_1": (22.0, 25.0)}
    assert refusal_code(lambda: ops.strips_move(events="hook_7", shift=1.0)) == ProblemCode.EVENT_UNKNOWN


def test_copies_are_selected_and_have_targets_of_their_own(operation: bpy.types.Scene) -> None:
    ops.strips_move("EXEC_DEFAULT", True, events="hook_1", shift=13.0, copy=True)
    events = operation.lappet.events
    assert spans()["hook_2"] == (21.0, 33.0)
    assert spans()["hook_1"] == (8.0, 20.0)
    assert events["hook_2"].target not in (None, events["hook_1"].target)
    assert [event.name for event in events if event.selected] == ["hook_2"]
    bpy.ops.ed.undo()
    assert spans() == BEFORE


def test_a_copy_that_cannot_be_there_is_not_added(operation: bpy.types.Scene) -> None:
    count = len(bpy.data.objects)
    late = lambda: ops.strips_move(events="hook_1", shift=35.0, copy=True)  # noqa: E731
    assert refusal_code(late) is ProblemCode.EVENT_AFTER_END
    assert spans() == BEFORE
    assert len(bpy.data.objects) == count


def test_an_act_does_not_remember_what_the_last_one_was_told(operation: bpy.types.Scene) -> None:
    ops.strips_move("EXEC_DEFAULT", True, events="hook_1", shift=13.0, copy=True)
    count = len(operation.lappet.events)
    ops.strips_select(which="NONE")
    operation.lappet.active_event = 0
    ops.strips_move("EXEC_DEFAULT", True, shift=1.0)
    assert len(operation.lappet.events) == count
    assert spans()["incision_1"] == (4.0, 4.0)
    properties = ops.strips_move.get_rna_type().properties
    assert all(properties[name].is_skip_save for name in ("events", "part", "shift", "copy", "step"))


def test_mute_turns_off_and_then_on_again(operation: bpy.types.Scene) -> None:
    on = lambda: [event.enabled for event in bpy.context.scene.lappet.events]  # noqa: E731
    ops.strips_mute(events="hook_1,suture_1")
    assert on() == [True, False, False, True]
    ops.strips_mute(events="hook_1,suture_1")
    assert on() == [True] * 4
    operation.lappet.events["hook_1"].enabled = False
    ops.strips_mute(events="hook_1,suture_1")  # one is on still: both are turned off
    assert on() == [True, False, False, True]


def test_strips_are_removed_with_their_targets(operation: bpy.types.Scene) -> None:
    ops.strips_remove(events="hook_1 suture_1")
    assert set(spans()) == {"incision_1"}
    assert not [obj for obj in bpy.data.objects if obj.name.startswith("hook_1")]


def test_steps_are_marked_in_the_words_of_plates_and_marked_anew(operation: bpy.types.Scene) -> None:
    operation.timeline_markers.new("my own", frame=30)
    ops.steps_mark(language="en")
    marked = lambda: sorted((each.frame, each.name) for each in bpy.context.scene.timeline_markers)  # noqa: E731
    english = [
        (1, "Planned incisions"),
        (3, "Incised"),
        (8, "Raised with hooks"),
        (21, "Closed with sutures"),
        (24, "Result"),
        (30, "my own"),
    ]
    assert marked() == english
    ops.strips_move(events="suture_1", shift=2.0)
    ops.steps_mark(language="de")
    assert [frame for frame, _ in marked()] == [1, 3, 8, 23, 26, 30]
    assert marked()[1] == (3, "Eingeschnitten")


def test_a_step_moves_with_its_marker_and_all_that_begins_in_it(operation: bpy.types.Scene) -> None:
    ops.steps_mark(language="en")
    bpy.ops.ed.undo_push(message="Marked")
    ops.strips_move("EXEC_DEFAULT", True, part="STEP", step=21, shift=4.0)
    assert spans() == {**BEFORE, "suture_1": (25.0, 28.0)}
    assert [(s.name, s.start) for s in scene_steps(bpy.context.scene)][-1] == ("Closed with sutures", 25.0)
    bpy.ops.ed.undo()
    assert spans() == BEFORE
    assert 21.0 in [step.start for step in scene_steps(bpy.context.scene)]
    assert refusal_code(lambda: ops.strips_move(part="STEP", step=22, shift=1.0)) == ProblemCode.STEP_UNKNOWN


def test_strips_of_a_step_are_selected_by_a_frame_of_it(operation: bpy.types.Scene) -> None:
    ops.steps_mark(language="en")
    ops.strips_select(which="STEP", frame=9)
    assert [event.name for event in operation.lappet.events if event.selected] == ["hook_1"]
    ops.strips_select(which="ALL")
    assert len([event for event in operation.lappet.events if event.selected]) == 3
    operation.timeline_markers.clear()
    assert refusal_code(lambda: ops.strips_select(which="STEP", frame=9)) == ProblemCode.STEP_UNKNOWN


def test_steps_of_no_event_are_refused(operation: bpy.types.Scene) -> None:
    for event in operation.lappet.events:
        event.enabled = False
    assert refusal_code(lambda: ops.steps_mark()) == ProblemCode.STEP_NO_EVENTS


class Region:
    """A region of 10 pixels a frame that begins at frame 0."""

    type, width, height = "WINDOW", 500, 160
    view2d = SimpleNamespace(region_to_view=lambda x, y: (x / 10.0, float(y)))


def stand_in(scene: bpy.types.Scene) -> Any:
    """The context of a Timeline."""
    said: dict[str, Any] = {}
    area = SimpleNamespace(type="DOPESHEET_EDITOR", header_text_set=lambda text: said.update(header=text))
    space = SimpleNamespace(type="DOPESHEET_EDITOR", mode="TIMELINE", show_markers=True)
    manager = SimpleNamespace(modal_handler_add=lambda _: True)
    return SimpleNamespace(scene=scene, area=area, space_data=space, region=Region(), window_manager=manager, said=said)


class Drag:
    """The operator's methods without Blender's operator around them."""

    _take = LAPPET_OT_strips_move._take
    _show = LAPPET_OT_strips_move._show
    _said = LAPPET_OT_strips_move._said
    _end = LAPPET_OT_strips_move._end
    invoke = LAPPET_OT_strips_move.invoke
    modal = LAPPET_OT_strips_move.modal
    run = LAPPET_OT_strips_move.run

    def __init__(self, copy: bool = False) -> None:
        self.events, self.part, self.shift, self.copy, self.step = "", "BODY", 0.0, copy, 1

    def execute(self, context: Any) -> set[str]:
        self.run(context)
        return {"FINISHED"}


def mouse(kind: str, value: str, at: tuple[float, float], **held: bool) -> Any:
    keys = {"shift": False, "ctrl": False, **held}
    return SimpleNamespace(type=kind, value=value, mouse_region_x=at[0], mouse_region_y=at[1], **keys)


def middle_of(context: Any, name: str, share: float = 0.5) -> tuple[float, float]:
    """A pixel of a strip, `share` of the way from its begin to its end."""
    picture = strip_view.picture_in(context.scene, context.space_data, context.region)
    box = next(each for each in picture.boxes if each.strip.name == name)
    return box.x0 + share * (box.x1 - box.x0), 0.5 * (box.y0 + box.y1)


def drag(context: Any, drag: Drag, by: float, at: tuple[float, float], **held: bool) -> set[str]:
    """Presses at a pixel, moves by so many pixels and releases."""
    began = drag.invoke(context, mouse("LEFTMOUSE", "PRESS", at))
    if began != {"RUNNING_MODAL"}:
        return began
    drag.modal(context, mouse("MOUSEMOVE", "NOTHING", (at[0] + by, at[1]), **held))
    return drag.modal(context, mouse("LEFTMOUSE", "RELEASE", (at[0] + by, at[1]), **held))


def test_a_drag_shows_where_the_strip_would_be_and_a_release_moves_it(operation: bpy.types.Scene) -> None:
    context, tool = stand_in(operation), Drag()
    x, y = middle_of(context, "hook_1")
    assert tool.invoke(context, mouse("LEFTMOUSE", "PRESS", (x, y))) == {"RUNNING_MODAL"}
    tool.modal(context, mouse("MOUSEMOVE", "NOTHING", (x + 52, y)))
    assert spans() == BEFORE  # the event waits for the release
    shown = {s.name: (s.start, s.end) for s in strip_view.shown_strips(operation)}
    assert shown["hook_1"] == (13.0, 25.0)
    assert context.said["header"].startswith("hook_1: 13 – 25, +5 frames")
    assert tool.modal(context, mouse("LEFTMOUSE", "RELEASE", (x + 52, y))) == {"FINISHED"}
    assert spans()["hook_1"] == (13.0, 25.0)
    assert context.said["header"] is None
    assert not strip_view.preview.spans


def test_escape_leaves_everything_as_it_was(operation: bpy.types.Scene) -> None:
    context, tool = stand_in(operation), Drag()
    x, y = middle_of(context, "hook_1")
    tool.invoke(context, mouse("LEFTMOUSE", "PRESS", (x, y)))
    tool.modal(context, mouse("MOUSEMOVE", "NOTHING", (x + 52, y)))
    assert tool.modal(context, mouse("ESC", "PRESS", (x + 52, y))) == {"CANCELLED"}
    assert spans() == BEFORE
    assert not strip_view.preview.spans


def test_the_end_under_the_mouse_is_dragged_and_snaps_to_the_next_strip(operation: bpy.types.Scene) -> None:
    context = stand_in(operation)
    assert drag(context, Drag(), 14.0, middle_of(context, "hook_1", 0.99)) == {"FINISHED"}
    assert spans()["hook_1"] == (8.0, 21.0)  # 21.4 by the mouse: to the suture's begin
    assert drag(context, Drag(), 14.0, middle_of(context, "hook_1", 0.99), ctrl=True) == {"FINISHED"}
    assert spans()["hook_1"] == (8.0, 22.4)


def test_a_click_selects_and_shift_adds_and_takes_out(operation: bpy.types.Scene) -> None:
    context = stand_in(operation)
    chosen = lambda: [event.name for event in operation.lappet.events if event.selected]  # noqa: E731
    drag(context, Drag(), 0.0, middle_of(context, "suture_1"))
    assert chosen() == ["suture_1"]
    assert operation.lappet.active_event == 2
    Drag().invoke(context, mouse("LEFTMOUSE", "PRESS", middle_of(context, "hook_1"), shift=True))
    assert chosen() == ["hook_1", "suture_1"]
    Drag().invoke(context, mouse("LEFTMOUSE", "PRESS", middle_of(context, "hook_1"), shift=True))
    assert chosen() == ["suture_1"]
    ops.strips_select(which="ALL")
    drag(context, Drag(), 0.0, middle_of(context, "hook_1"))
    assert chosen() == ["hook_1"]  # a click on one of several
    assert spans() == BEFORE


def test_a_drag_of_one_selected_strip_takes_the_others_along(operation: bpy.types.Scene) -> None:
    context = stand_in(operation)
    ops.strips_select(which="ALL")
    drag(context, Drag(), 40.0, middle_of(context, "hook_1"))
    assert spans() == {name: (start + 4.0, end + 4.0) for name, (start, end) in BEFORE.items()}


def test_the_name_of_a_step_is_dragged_with_what_is_in_it(operation: bpy.types.Scene) -> None:
    ops.steps_mark(language="en")
    context = stand_in(operation)
    band = next(b for b in strip_view.picture_in(operation, context.space_data, context.region).steps if b.x0 == 210)
    drag(context, Drag(), 30.0, (band.x0 + 8.0, 0.5 * (band.y0 + band.y1)))
    assert spans() == {**BEFORE, "suture_1": (24.0, 27.0)}


def test_a_press_beside_the_strips_is_blenders_own(operation: bpy.types.Scene) -> None:
    context = stand_in(operation)
    x, y = middle_of(context, "hook_1")
    assert Drag().invoke(context, mouse("LEFTMOUSE", "PRESS", (495.0, y))) == {"PASS_THROUGH"}
    assert Drag().invoke(context, mouse("LEFTMOUSE", "PRESS", (x, 158.0))) == {"PASS_THROUGH"}  # the ruler
    operation.lappet.show_strips = False
    assert Drag().invoke(context, mouse("LEFTMOUSE", "PRESS", (x, y))) == {"PASS_THROUGH"}
    operation.lappet.show_strips = True
    context.space_data.mode = "GPENCIL"
    assert Drag().invoke(context, mouse("LEFTMOUSE", "PRESS", (x, y))) == {"PASS_THROUGH"}


def test_a_double_click_goes_to_the_frame_of_a_strip(operation: bpy.types.Scene) -> None:
    ops.strip_jump("EXEC_DEFAULT", events="suture_1")
    assert operation.frame_current == 21


def test_what_is_off_selected_or_snapped_to_is_drawn_so(operation: bpy.types.Scene) -> None:
    context = stand_in(operation)
    operation.lappet.active_event = 3  # the landmark: no strip is active
    operation.lappet.events["suture_1"].enabled = False
    operation.lappet.events["hook_1"].selected = True
    picture = strip_view.picture_in(operation, context.space_data, context.region)
    colors = {each[4] for each in rectangles(picture, 500.0, 136.0, 21.0, lambda frame: 10.0 * frame)}
    assert LANE_COLORS[0] in colors
    assert LANE_COLORS[1] in colors
    assert LANE_COLORS[2] not in colors  # the suture is off
    assert (1.0, 0.62, 0.15, 1.0) in colors
    assert any(each[0] == 209.0 for each in rectangles(picture, 500.0, 136.0, 21.0, lambda frame: 10.0 * frame))


def test_every_key_names_an_operator_that_is_there(addon: None) -> None:
    for name, *_ in KEYS:
        assert getattr(bpy.ops.lappet, name.partition(".")[2]).get_rna_type() is not None
