"""The operators on events, run from Python: what they add, what they refuse, and that each is one step of undo."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from event_patch import co, patch_scene
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Incision, Suture
from lappet.procedure.stitches import Station, deep_dermal, running, simple, vertical_mattress
from lappet_blender.display.display_collection import ROLE
from lappet_blender.model.event_list import find_event
from lappet_blender.model.event_values import event_value
from refusals import refusal_code

TOP = 4.0
ops = bpy.ops.lappet


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A scene in mm, frames 1 to 40, with a patch of 60 x 40 x 4 mm whose top lies at z = 4."""
    patch_scene(scene, (60.0, 40.0, TOP), 40)
    bpy.ops.ed.undo_push(message="the patch")
    return scene


def at(*places: tuple[float, float]) -> list[dict[str, Any]]:
    """Points on the top of the patch as an operator takes them."""
    return co([(x, y, TOP) for x, y in places])


def own_objects() -> set[str]:
    """The objects but those that show solved skin: these come as soon as a manifest is known."""
    return {each.name for each in bpy.data.objects if ROLE not in each}


def value(name: str) -> Any:
    """The value of an event."""
    scene = bpy.context.scene
    return event_value(scene, find_event(scene, name))


ACTS: dict[str, Callable[[], object]] = {
    "incision_add": lambda: ops.incision_add("EXEC_DEFAULT", True, points=at((-10, 0), (10, 0)), time=3),
    "undermine_add": lambda: ops.undermine_add("EXEC_DEFAULT", True, points=at((-9, -9), (9, -9), (0, 9)), time=6),
    "thin_add": lambda: ops.thin_add("EXEC_DEFAULT", True, points=at((-9, -9), (9, -9), (0, 9)), thickness=1, time=6),
    "hook_add": lambda: ops.hook_add("EXEC_DEFAULT", True, anchor=(1, 1, TOP), target=(1, 8, 9), start=8, end=20),
    "retractor_add": lambda: ops.retractor_add("EXEC_DEFAULT", True, grip="bed", shift=(0, 0, 3), start=8, end=20),
    "suture_add": lambda: ops.suture_add("EXEC_DEFAULT", True, first=(3, 1, TOP), second=(3, -1, TOP), start=9),
    "suture_run": lambda: ops.suture_run(
        "EXEC_DEFAULT", True, first_edge=at((-9, 1), (9, 1)), second_edge=at((-9, -1), (9, -1)), count=5, start=9
    ),
    "landmark_add": lambda: ops.landmark_add("EXEC_DEFAULT", True, point=(5, 5, TOP), label="here"),
}


@pytest.mark.parametrize("name", ACTS)
def test_one_undo_undoes_one_act_and_one_redo_does_it_again(patch: bpy.types.Scene, name: str) -> None:
    ACTS["incision_add"]()
    objects = own_objects()
    ACTS[name]() if name != "incision_add" else ops.incision_add(
        "EXEC_DEFAULT", True, points=at((-10, 5), (10, 5)), time=4
    )
    events = [(event.uid, event.name) for event in bpy.context.scene.lappet.events]
    values = [value(event_name) for _, event_name in events]
    assert len(events) == 2
    bpy.ops.ed.undo()
    assert [event.name for event in bpy.context.scene.lappet.events] == ["incision_1"]
    assert own_objects() == objects
    bpy.ops.ed.redo()
    assert [(event.uid, event.name) for event in bpy.context.scene.lappet.events] == events
    assert [value(event_name) for _, event_name in events] == values


def test_editing_an_event_is_one_step_each(patch: bpy.types.Scene) -> None:
    ACTS["hook_add"]()
    before = value("hook_1")
    for act in (
        lambda: ops.event_retime("EXEC_DEFAULT", True, event="hook_1", time=10),
        lambda: ops.point_move("EXEC_DEFAULT", True, event="hook_1", index=0, co=(2, 2, TOP)),
        lambda: ops.event_enable("EXEC_DEFAULT", True, event="hook_1", enabled=False),
        lambda: ops.event_rename("EXEC_DEFAULT", True, event="hook_1", name="flap"),
        lambda: ops.event_duplicate("EXEC_DEFAULT", True, event="hook_1"),
        lambda: ops.event_remove("EXEC_DEFAULT", True, event="hook_1"),
    ):
        act()
        bpy.ops.ed.undo()
        (event,) = bpy.context.scene.lappet.events
        assert event.enabled
        assert value("hook_1") == before
        assert [each.name for each in bpy.data.objects if each.type == "EMPTY"] == ["hook_1 target"]


def test_a_hook_pulls_from_its_anchor_to_its_target_along_straight_keyframes(patch: bpy.types.Scene) -> None:
    ops.hook_add(anchor=(1, 2, TOP), target=(1, 8, 9), start=8, end=20, arrive=6, stiffness=300)
    assert value("hook_1") == Hook(
        "hook_1", (1.0, 2.0, TOP), ((8.0, (1.0, 2.0, TOP)), (14.0, (1.0, 8.0, 9.0))), 8.0, 20.0, 300.0
    )
    empty = find_event(patch, "hook_1").target
    patch.frame_set(11)
    assert tuple(empty.location) == pytest.approx((1.0, 5.0, 6.5))


def test_what_is_left_out_is_taken_from_the_scene(patch: bpy.types.Scene) -> None:
    patch.frame_set(12)
    ops.hook_add(anchor=(1, 2, TOP), target=(1, 8, 9))
    ops.incision_add(points=at((-10, 0), (10, 0)))
    assert (value("hook_1").start, value("hook_1").release) == (12.0, 41.0)
    assert value("incision_1") == Incision("incision_1", 12.0, ((-10, 0, TOP), (10, 0, TOP)), kerf=0.05)


def test_a_run_of_sutures_pairs_the_edges_by_their_length(patch: bpy.types.Scene) -> None:
    corner = at((-9, 3), (0, 3), (0, 9))  # 15 mm with a corner
    straight = at((-12, -3), (12, -3))
    ops.suture_run(single=True, first_edge=corner, second_edge=straight, count=4, start=9, duration=5, name="skin_left")
    pairs = [value(f"skin_left_{k}").anchors for k in (1, 2, 3, 4)]
    shares = [0.125, 0.375, 0.625, 0.875]
    for (first, second), share in zip(pairs, shares, strict=True):
        reached = 15.0 * share
        assert first == pytest.approx((-9 + reached, 3, TOP) if reached < 9 else (0, 3 + reached - 9, TOP), abs=1e-5)
        assert second == pytest.approx((-12 + 24 * share, -3, TOP), abs=1e-5)
    assert (value("skin_left_1").start, value("skin_left_1").duration) == (9.0, 5.0)


def test_a_buried_row_lies_as_deep_below_the_skin_as_it_is_told(patch: bpy.types.Scene) -> None:
    first, second = at((-9, 1), (9, 1)), at((-9, -1), (9, -1))
    ops.suture_run(single=True, first_edge=first, second_edge=second, count=2, start=9, depth=1.5, name="deep")
    ops.suture_add(first=(3, 1, TOP), second=(3, -1, TOP), start=9, depth=0.5, name="one")
    assert [end[2] for end in value("deep_2").anchors] == pytest.approx([TOP - 1.5] * 2, abs=1e-5)
    assert [end[2] for end in value("one").anchors] == pytest.approx([TOP - 0.5] * 2, abs=1e-5)
    assert value("deep_1").anchors[0][:2] == pytest.approx((-4.5, 1.0), abs=1e-5)


def test_a_suture_of_a_shape_is_the_stitch_of_that_name_between_the_edges(patch: bpy.types.Scene) -> None:
    at_edge = Station((3.0, 0.0, TOP), (0.0, -1.0, 0.0), gap=2.0)
    ops.suture_add(
        first=(3, 1, TOP), second=(3, -1, TOP), start=9, shape="VERTICAL_MATTRESS", depth=1.5, drawn=0.8, name="loop"
    )
    wanted = vertical_mattress(at_edge, 1.5)
    loop = value("loop")
    assert loop.mode == "thread"
    np.testing.assert_allclose(loop.anchors, wanted.bites, atol=1e-4)
    assert loop.length == pytest.approx(0.8 * wanted.length, rel=1e-5)
    ops.suture_add(first=(3, 1, TOP), second=(3, -1, TOP), start=9, shape="DEEP_DERMAL", bite=2.0, depth=1.5)
    np.testing.assert_allclose(value("suture_1").anchors, deep_dermal(at_edge, 1.5, bite=2.0).bites, atol=1e-4)


def test_a_run_of_a_shape_is_a_stitch_at_each_place_and_a_running_one_a_single_thread(patch: bpy.types.Scene) -> None:
    first, second = at((-9, 1), (9, 1)), at((-9, -1), (9, -1))
    places = [Station((x, 0.0, TOP), (0.0, -1.0, 0.0), gap=2.0) for x in (-6.0, 0.0, 6.0)]
    ops.suture_run(
        single=True, first_edge=first, second_edge=second, count=3, start=9, shape="SIMPLE", bite=2.0, name="loop"
    )
    for k, place in enumerate(places):
        np.testing.assert_allclose(value(f"loop_{k + 1}").anchors, simple(place, 2.0, 2.0).bites, atol=1e-4)
    ops.suture_run(
        single=True, first_edge=first, second_edge=second, count=3, start=9, shape="RUNNING", bite=2.0, depth=1.0
    )
    np.testing.assert_allclose(value("suture_1").anchors, running(places, 2.0, 1.0).bites, atol=1e-4)
    assert len(patch.lappet.events) == 4
    # Across an incision the bites are counted from its edges.
    ops.incision_add(points=at((-9, 5), (9, 5)), time=3, kerf=0.2)
    ops.suture_run(
        single=True, incision="incision_1", count=1, start=5, shape="FIGURE_OF_EIGHT", bite=3.0, name="eight"
    )
    across = np.ptp(np.array(value("eight_1").anchors)[:, 1])
    assert across == pytest.approx(2 * (3.0 + 0.1 + 0.01), abs=1e-4)


def test_the_spacing_gives_the_count_and_a_flipped_edge_is_met_from_its_end(patch: bpy.types.Scene) -> None:
    ops.suture_run(
        single=True, first_edge=at((-9, 1), (9, 1)), second_edge=at((9, -1), (-9, -1)), spacing=3.0, flip=True
    )
    assert len(patch.lappet.events) == 6
    for event in patch.lappet.events:
        first, second = value(event.name).anchors
        assert first[0] == pytest.approx(second[0], abs=1e-5)


def test_sutures_across_an_incision_lie_on_both_its_sides_at_its_edges(patch: bpy.types.Scene) -> None:
    ops.incision_add(points=at((-10, -10), (10, 10)), time=3, kerf=0.2)
    ops.suture_run(single=True, incision="incision_1", count=3, start=5)
    assert [event.name for event in patch.lappet.events][1:] == ["suture_1", "suture_2", "suture_3"]
    for k, share in enumerate((1 / 6, 0.5, 5 / 6)):
        first, second = np.array(value(f"suture_{k + 1}").anchors)
        middle = -10 + 20 * share
        np.testing.assert_allclose(0.5 * (first + second), (middle, middle, TOP), atol=1e-5)
        across = (first - second) / np.linalg.norm(first - second)
        np.testing.assert_allclose(across, np.array([-1, 1, 0]) / math.sqrt(2), atol=1e-4)
        assert np.linalg.norm(first - second) == pytest.approx(2 * (0.1 + 0.01), abs=1e-5)
    ops.suture_run(single=True, incision="incision_1", count=1, bite=2.0, depth=1.5, name="deep")
    first, second = np.array(value("deep_1").anchors)
    assert np.linalg.norm(first - second) == pytest.approx(4.0, abs=1e-5)
    assert (first[2], second[2]) == pytest.approx((TOP - 1.5, TOP - 1.5), abs=1e-5)


def test_a_retractor_starts_in_the_middle_of_what_it_grips(patch: bpy.types.Scene) -> None:
    ops.retractor_add(grip="bed", shift=(0, 0, 3), start=8, end=20, arrive=4)
    (first, start), (second, end) = value("retractor_1").motion
    assert (first, second) == (8.0, 12.0)
    np.testing.assert_allclose(np.array(start).reshape(4, 4)[3], (0, 0, 0, 1), atol=1e-6)
    np.testing.assert_allclose(np.array(end).reshape(4, 4)[3], (0, 0, 3, 1), atol=1e-6)


def test_points_of_a_line_can_be_moved_inserted_and_removed(patch: bpy.types.Scene) -> None:
    ops.incision_add(points=at((-10, 0), (10, 0)), time=3)
    ops.point_insert(event="incision_1", index=1, co=(0, 5, TOP))
    ops.point_move(event="incision_1", index=0, co=(-12, 1, TOP))
    assert value("incision_1").points == ((-12, 1, TOP), (0, 5, TOP), (10, 0, TOP))
    ops.point_remove(event="incision_1", index=1)
    assert value("incision_1").points == ((-12, 1, TOP), (10, 0, TOP))
    assert refusal_code(lambda: ops.point_remove(event="incision_1", index=0)) is ProblemCode.EVENT_POINTS_NEEDED
    move = partial(ops.point_move, event="incision_1", index=7, co=(0, 0, TOP))
    assert refusal_code(move) is ProblemCode.EVENT_POINT_UNKNOWN
    assert refusal_code(lambda: ops.excise(point=(0, 0, 90))) is ProblemCode.EVENT_OFF_TISSUE


def test_a_duplicate_has_an_empty_and_keyframes_of_its_own(patch: bpy.types.Scene) -> None:
    ACTS["hook_add"]()
    first = value("hook_1")
    ops.event_duplicate(event="hook_1", shift=20)
    copied = value("hook_2")
    assert (copied.start, copied.release) == (first.start + 20, first.release + 20)
    assert copied.targets == tuple((time + 20, place) for time, place in first.targets)
    ops.event_retime(event="hook_2", time=first.start + 21)
    assert value("hook_1") == first
    ops.event_remove(event="hook_2")
    assert value("hook_1") == first
    assert [each.name for each in bpy.data.objects if each.type == "EMPTY"] == ["hook_1 target"]


def test_what_cannot_be_is_refused_and_nothing_is_done(patch: bpy.types.Scene) -> None:
    code, cut = ProblemCode, ops.incision_add
    assert refusal_code(lambda: cut(points=at((-10, 0), (10, 0)), time=41)) is code.EVENT_AFTER_END
    assert refusal_code(lambda: cut(points=at((0, 0)), time=3)) is code.CURVE_TOO_SHORT
    assert refusal_code(lambda: cut(points=at((200, 0), (210, 0)), time=3)) is code.CURVE_OFF_TISSUE
    assert refusal_code(lambda: ops.excise(point=(0, 0, TOP), time=5)) is code.EXCISION_BEFORE_CUT
    assert refusal_code(lambda: ops.undermine_add(points=at((0, 0), (1, 0)), time=3)) is code.CURVE_TOO_SHORT
    assert refusal_code(lambda: ops.retractor_add(grip="ear", start=3, end=8)) is code.GRIP_UNKNOWN
    same = partial(ops.suture_add, first=(0, 0, TOP), second=(0, 0, TOP))
    assert refusal_code(same) is code.SUTURE_OF_ONE_POINT
    short = partial(ops.suture_run, first_edge=at((0, 0)), second_edge=at((0, 1), (1, 1)))
    assert refusal_code(short) is code.SUTURE_EDGE
    assert refusal_code(lambda: ops.suture_run(single=True, incision="cut")) is code.EVENT_UNKNOWN
    ACTS["hook_add"]()
    assert refusal_code(ACTS["hook_add"]) is code.HOOK_SAME_POINT
    assert refusal_code(lambda: ops.hook_add(anchor=(5, 1, TOP), start=9, end=9)) is code.EVENT_RELEASE
    assert refusal_code(lambda: ops.event_retime(event="hook_1", time=80)) is code.EVENT_AFTER_END
    assert refusal_code(lambda: ops.event_remove(event="x")) is code.EVENT_UNKNOWN


def test_a_report_names_the_event_and_not_its_prim(patch: bpy.types.Scene) -> None:
    with pytest.raises(RuntimeError, match=r"^Error: incision_1: "):
        ops.incision_add(points=at((-10, 0), (10, 0)), time=41)


def test_without_a_tissue_nothing_can_be_placed(scene: bpy.types.Scene) -> None:
    assert refusal_code(lambda: ops.landmark_add(point=(0, 0, 0))) is ProblemCode.TISSUE_NONE


def test_an_event_that_is_off_stays_in_the_list_and_hinders_nothing(patch: bpy.types.Scene) -> None:
    ACTS["hook_add"]()
    ops.event_enable(event="hook_1", enabled=False)
    ACTS["hook_add"]()
    assert [(event.name, event.enabled) for event in patch.lappet.events] == [("hook_1", False), ("hook_2", True)]


def test_choosing_an_event_selects_its_empty_and_jumping_goes_to_its_frame(patch: bpy.types.Scene) -> None:
    ACTS["hook_add"]()
    ACTS["incision_add"]()
    ops.event_select(event="hook_1")
    assert patch.lappet.active_event == 0
    assert bpy.context.view_layer.objects.active.name == "hook_1 target"
    ops.event_jump(event="incision_1")
    assert (patch.frame_current, patch.lappet.active_event) == (3, 1)


def test_saving_and_loading_keeps_every_event(patch: bpy.types.Scene, blend: Path) -> None:
    for act in ACTS.values():
        act()
    before = [value(event.name) for event in patch.lappet.events]
    uids = [event.uid for event in patch.lappet.events]
    assert any(isinstance(each, Suture) for each in before)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    events = bpy.context.scene.lappet.events
    assert [value(event.name) for event in events] == before
    assert [event.uid for event in events] == uids
