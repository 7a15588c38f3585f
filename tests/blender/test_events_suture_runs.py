"""A suture run is one event of a scene: added by operators, edited in the list, shown with all its stitches."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from event_patch import co, patch_scene
from lappet.core.problem import problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import SutureLayer, SutureRun
from lappet.suturing import with_single_sutures
from lappet_blender.events.run_preview import stitches_of
from lappet_blender.model.changes import subscribe, unsubscribe
from lappet_blender.model.event_list import find_event
from lappet_blender.model.event_values import add_value, event_value
from lappet_blender.model.scene_procedure import read_scene
from lappet_blender.solving.select_problem import problem_event
from lappet_blender.tools.handles import handles_of
from refusals import refusal_code

TOP = 4.0
ops = bpy.ops.lappet


@pytest.fixture
def patch(scene: bpy.types.Scene) -> bpy.types.Scene:
    """A scene in mm with a patch of 60 x 60 x 4 mm."""
    patch_scene(scene, (60.0, 60.0, TOP), 40)
    scene.lappet.tissue.spacing = 1.0
    bpy.ops.ed.undo_push(message="the patch")
    return scene


def at(*places: tuple[float, float]) -> list[dict]:
    """Places on the skin as the operators take them."""
    return co([(x, y, TOP) for x, y in places])


def run_of(name: str) -> SutureRun:
    value = event_value(bpy.context.scene, find_event(bpy.context.scene, name))
    assert isinstance(value, SutureRun)
    return value


EVERYTHING = SutureRun(
    "whole",
    (((-10.0, 1.0, TOP), (0.0, 2.0, TOP), (10.0, 1.0, TOP)), ((-10.0, -1.0, TOP), (10.0, -1.0, TOP))),
    9.0,
    sides=(-1, 1),
    corners=((2, 1),),
    duration=6.0,
    spacing=3.5,
    margin=1.5,
    bite=0.25,
    layers=(SutureLayer("deep", 2.5), SutureLayer("skin", 0.0, True)),
    pattern="verticalMattress",
    pass_depth=1.5,
    order="forward",
    mode="thread",
    thread="silk 4-0",
    stiffness=700.0,
    drawn=0.85,
    tension=300.0,
    pull_through=900.0,
    insides=(((10.0, 3.0, TOP), (11.0, -3.0, TOP)),),
)


def test_a_run_comes_back_from_the_scene_as_it_was(patch: bpy.types.Scene) -> None:
    add_value(patch, EVERYTHING)
    assert run_of("whole") == EVERYTHING
    assert read_scene(patch).procedure.events == (EVERYTHING,)


def test_a_copy_of_a_run_has_its_corners_and_layers(patch: bpy.types.Scene) -> None:
    add_value(patch, EVERYTHING)
    assert ops.event_duplicate(event="whole", shift=3.0) == {"FINISHED"}
    copy = run_of(patch.lappet.events[1].name)
    assert (copy.corners, copy.insides, copy.layers) == (EVERYTHING.corners, EVERYTHING.insides, EVERYTHING.layers)
    assert copy.start == 12.0


def test_two_edges_are_sewn_by_one_event_with_as_many_stitches_as_asked_for(patch: bpy.types.Scene) -> None:
    ops.suture_run(first_edge=at((-9, 1), (9, 1)), second_edge=at((9, -1), (-9, -1)), flip=True, count=5, start=9)
    (event,) = patch.lappet.events
    assert (event.kind, event.name) == ("SUTURE_RUN", "suture_run_1")
    run = run_of("suture_run_1")
    assert (run.sides, run.order, run.start, run.duration) == ((1, -1), "halving", 9.0, 8.0)
    stitches = stitches_of(patch, event)
    assert [stitch.name for stitch in stitches] == [f"suture_run_1/{k}" for k in range(1, 6)]
    for k, stitch in enumerate(stitches):
        first, second = stitch.anchors
        assert first == pytest.approx((-9.0 + 18.0 * (k + 0.5) / 5.0, 1.0, TOP), abs=1e-3)
        assert second == pytest.approx((first[0], -1.0, TOP), abs=1e-3)


def test_both_walls_of_an_incision_are_sewn_where_they_are(patch: bpy.types.Scene) -> None:
    ops.incision_add(points=at((-10, -10), (10, 10)), time=3, kerf=0.2)
    ops.suture_run(incision="incision_1", count=3, start=5)
    for k, stitch in enumerate(stitches_of(patch, patch.lappet.events[1])):
        first, second = np.array(stitch.anchors)
        middle = -10 + 20 * (k + 0.5) / 3
        np.testing.assert_allclose(0.5 * (first + second), (middle, middle, TOP), atol=1e-3)
        assert np.linalg.norm(first - second) == pytest.approx(2 * (0.1 + 0.01), abs=1e-3)


def test_edges_on_the_underside_are_those_of_a_deep_layer(patch: bpy.types.Scene) -> None:
    below = [{"name": "", "co": (x, 1.0, 0.0)} for x in (-9, 9)]
    other = [{"name": "", "co": (x, -1.0, 0.0)} for x in (-9, 9)]
    ops.suture_run(first_edge=below, second_edge=other, count=4, start=9)
    (layer,) = run_of("suture_run_1").layers
    assert (layer.name, layer.depth) == ("deep", pytest.approx(TOP))
    assert {stitch.anchors[0][2] for stitch in stitches_of(patch, patch.lappet.events[0])} == {0.0}


def test_the_tissue_of_an_edge_lies_away_from_the_incision_beside_it(patch: bpy.types.Scene) -> None:
    ops.incision_add(points=at((-10, 10), (10, 10)), time=3)
    ops.incision_add(points=at((-10, 0), (10, 0)), time=3)
    # The flap's edge lies above its cut, the wound's it is sewn to above its own: not on its near side.
    ops.suture_run(first_edge=at((-9, 0.5), (9, 0.5)), second_edge=at((-9, 10.5), (9, 10.5)), start=9, depth=2.0)
    assert run_of("suture_run_1").sides == (1, 1)


def test_a_change_of_the_spacing_is_told_and_the_plan_shows_other_stitches(patch: bpy.types.Scene) -> None:
    ops.suture_run(first_edge=at((-9, 1), (9, 1)), second_edge=at((-9, -1), (9, -1)), spacing=3.0)
    event = patch.lappet.events[0]
    assert len(stitches_of(patch, event)) == 6
    told: list[str] = []

    def listener(scene: bpy.types.Scene) -> None:
        told.append(scene.name)

    subscribe(listener)
    try:
        event.spacing = 2.0
        event.sewn_in = "BOTH"
    finally:
        unsubscribe(listener)
    assert len(told) >= 2
    names = [stitch.name for stitch in stitches_of(patch, event)]
    assert names == [
        *(f"suture_run_1/deep/{k}" for k in range(1, 10)),
        *(f"suture_run_1/skin/{k}" for k in range(1, 9)),
    ]
    assert event.sewn_in == "BOTH"
    event.sewn_in = "SKIN"
    assert run_of("suture_run_1").layers == (SutureLayer("skin"),)
    single = with_single_sutures(read_scene(patch).procedure)
    assert [each.name for each in single.events] == [stitch.name for stitch in stitches_of(patch, event)]


def test_a_run_that_cannot_be_sewn_is_refused_and_one_made_so_shows_no_stitches(patch: bpy.types.Scene) -> None:
    crossing = {"first_edge": at((-9, 1), (9, 1)), "second_edge": at((-9, -4), (9, 4))}
    assert refusal_code(lambda: ops.suture_run(**crossing)) is ProblemCode.SUTURE_RUN_EDGES_CROSS
    far = {"first_edge": at((-9, 1), (9, 1)), "second_edge": at((-9, -40), (9, -40))}
    assert refusal_code(lambda: ops.suture_run(**far)) is ProblemCode.SUTURE_RUN_OFF_SKIN
    assert len(patch.lappet.events) == 0
    ops.suture_run(first_edge=at((-9, 1), (9, 1)), second_edge=at((-9, -1), (9, -1)), spacing=3.0)
    patch.lappet.events[0].spacing = 50.0
    assert stitches_of(patch, patch.lappet.events[0]) == ()


def test_insets_are_where_the_first_and_last_stitches_lie(patch: bpy.types.Scene) -> None:
    edges = {"first_edge": at((-10, 1), (10, 1)), "second_edge": at((-10, -1), (10, -1))}
    ops.suture_run(**edges, count=4, inset_start=0.1, inset_end=0.25, start=9)
    found = [stitch.anchors[0][0] for stitch in stitches_of(patch, patch.lappet.events[0])]
    np.testing.assert_allclose(found, np.linspace(-8.0, 5.0, 4), atol=1e-3)


def test_a_running_suture_of_the_tool_is_a_pattern_of_the_run(patch: bpy.types.Scene) -> None:
    edges = {"first_edge": at((-9, 1), (9, 1)), "second_edge": at((-9, -1), (9, -1))}
    ops.suture_run(**edges, count=3, start=9, shape="RUNNING", bite=2.0, depth=1.0, drawn=0.8)
    run = run_of("suture_run_1")
    assert (run.pattern, run.bite, run.pass_depth, run.drawn) == ("running", 2.0, 1.0, pytest.approx(0.8))
    (thread,) = stitches_of(patch, patch.lappet.events[0])
    assert len(thread.anchors) == 3 * 4


def test_what_is_wrong_with_a_stitch_leads_to_its_run(patch: bpy.types.Scene) -> None:
    ops.incision_add(points=at((-10, 0), (10, 0)), time=3)
    ops.suture_run(incision="incision_1", spacing=3.0, start=5)
    found = problem(ProblemCode.SUTURE_PULLS_THROUGH, "/Procedure/Timeline/suture_run_1/4", "9000", time=7, limit=3440)
    assert problem_event(patch, found) == 1


def test_edges_that_were_clicked_have_handles_and_those_of_a_design_none(patch: bpy.types.Scene) -> None:
    ops.suture_run(first_edge=at((-9, 1), (9, 1)), second_edge=at((-9, -1), (9, -1)), start=5)
    own = patch.lappet.events[0].uid
    assert len([each for each in handles_of(patch, 1.0) if each.event_uid == own]) == 4
    ops.flap_limberg(side=8.0, lines="X", time=1)
    runs = {event.uid for event in patch.lappet.events if event.kind == "SUTURE_RUN"}
    assert {each.event_uid for each in handles_of(patch, 1.0)} & runs == {own}
