"""Events in a scene: their names, their values as a procedure holds them, and the empties that hooks follow."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RigidMotion
from lappet.procedure import Excision, Hook, Incision, Landmark, Retractor, Suture, SutureRun, Thin, Undermine
from lappet.tissue.presets import PRESETS
from lappet_blender.model import event_list, target_samples
from lappet_blender.model.event_list import add_event, find_event, move_event, remove_event, rename_event
from lappet_blender.model.event_values import event_value, set_event
from lappet_blender.model.keyframes import curves_of
from lappet_blender.model.material_values import find_material, material_values, set_material

TOP = 4.0
HOOK = Hook(
    "hook_1",
    (1.5, 2.0, TOP),
    ((8.0, (1.5, 2.0, 4.0)), (14.3, (0.1, 7.7, 13.0)), (26.0, (-9.25, 3.0, 4.0))),
    8.0,
    38.0,
    300.0,
)


def add(scene: bpy.types.Scene, value: object) -> None:
    """Adds a value of a procedure as an event."""
    event = add_event(scene, type(value).__name__.upper(), value.name)
    set_event(scene, event, value)


def hook_empty(scene: bpy.types.Scene, *keys: tuple[float, tuple[float, float, float]]) -> bpy.types.Object:
    """A hook from 2 to 8 and its empty, with keyframes as Blender makes them by default (curved)."""
    event = add_event(scene, "HOOK", points=[(0, 0, 0)], start=2, end=8)
    empty = bpy.data.objects.new("mine", None)
    scene.collection.objects.link(empty)
    event.target = empty
    for frame, place in keys:
        empty.location = place
        empty.keyframe_insert("location", frame=frame)
    return empty


@pytest.fixture
def scene(scene: bpy.types.Scene) -> bpy.types.Scene:
    """In mm, 40 frames."""
    scene.unit_settings.scale_length = 0.001
    scene.frame_start, scene.frame_end = 1, 40
    return scene


@pytest.mark.parametrize("scale", [0.001, 1.0, 0.01])
@pytest.mark.parametrize(
    "value",
    [
        Incision("cut", 3.0, ((0.1, 2.0, TOP), (7.3, -1.0, TOP), (9.0, 1.0, TOP)), kerf=0.05),
        Incision("shallow", 3.5, ((0.0, 0.0, TOP), (1.0, 0.0, TOP), (2.0, 3.0, TOP)), 1.3, 0.2, "catmullRom", True),
        Incision("bevel", 3.5, ((0.0, 0.0, TOP), (1.0, 0.0, TOP)), direction=(0.25, 1.1, -1.0)),
        Excision("out", 4.0, ((0.3, 0.2, TOP), (4.0, 0.0, TOP))),
        Thin("thin", 9.0, ((0.0, 0.0, TOP), (5.0, 0.0, TOP), (0.0, 5.0, TOP)), 1.25, "catmullRom", 1.5, 3.0),
        Undermine("under", 6.0, ((0.0, 0.0, TOP), (5.0, 0.0, TOP), (0.0, 5.0, TOP)), "bspline"),
        HOOK,
        Hook("still", (0.7, 0.0, TOP), ((4.0, (0.7, 0.3, 9.0)),), 4.0, 9.0),
        Suture("suture_1", ((0.2, 0.1, TOP), (0.2, -0.1, TOP)), 26.0, 10.0, 1000.0),
        Suture("nylon", ((0.2, 0.1, TOP), (0.2, -0.1, TOP)), 26.0, 9.0, 80.0, "thread", "nylon 5-0", 1.5, 300.0, 900.0),
        Suture("running", ((0.2, 0.1, TOP), (0.2, -0.1, TOP), (2.2, 0.1, 1.5)), 26.0, 9.0, 80.0, "thread", length=4.5),
        Landmark("mark", ((1.0, 2.0, TOP), (2.0, 2.0, TOP)), "scar end"),
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_a_value_comes_back_from_the_scene_as_it_was_given_whatever_the_unit(
    scene: bpy.types.Scene, value: object, scale: float
) -> None:
    scene.unit_settings.scale_length = scale
    add(scene, value)
    back = event_value(scene, scene.lappet.events[0])
    if isinstance(value, Hook):
        assert [time for time, _ in back.targets] == [time for time, _ in value.targets]
        np.testing.assert_allclose([p for _, p in back.targets], [p for _, p in value.targets], atol=1e-5)
        assert (back.anchor, back.start, back.release, back.stiffness) == (
            value.anchor,
            value.start,
            value.release,
            value.stiffness,
        )
    else:
        assert back == value


def test_in_a_scene_of_millimetres_straight_keyframes_give_the_very_decimals(scene: bpy.types.Scene) -> None:
    add(scene, HOOK)
    assert event_value(scene, scene.lappet.events[0]) == HOOK


def test_a_retractor_that_turns_moves_the_same_at_every_frame(scene: bpy.types.Scene) -> None:
    turn = Matrix.Translation((3, 1, 2)) @ Matrix.Rotation(math.radians(70), 4, "X")
    turn = turn @ Matrix.Rotation(math.radians(40), 4, "Z")
    motion = ((4.0, np.eye(4).ravel()), (12.0, np.array(turn).T.ravel()), (20.0, np.array(turn).T.ravel()))
    value = Retractor("pull", "grip", motion, 4.0, 22.0)
    add(scene, value)
    back = event_value(scene, scene.lappet.events[0])
    assert (back.grip, back.start, back.release) == ("grip", 4.0, 22.0)
    wanted, found = RigidMotion(value.motion), RigidMotion(back.motion)
    for frame in range(1, 30):
        np.testing.assert_allclose(found.between(4.0, frame), wanted.between(4.0, frame), atol=2e-6)


def test_a_retractor_that_only_shifts_keeps_its_keyframes(scene: bpy.types.Scene) -> None:
    away = Matrix.Translation((0, 0, 5))
    value = Retractor("pull", "grip", ((4.0, np.eye(4).ravel()), (12.0, np.array(away).T.ravel())), 4.0, 22.0)
    add(scene, value)
    assert event_value(scene, scene.lappet.events[0]) == value


def test_curved_keyframes_become_one_sample_a_frame_that_lies_on_the_curve(scene: bpy.types.Scene) -> None:
    empty = hook_empty(scene, (2, (0, 0, 4)), (8, (6, 0, 4)))
    targets = dict(event_value(scene, scene.lappet.events[0]).targets)
    assert list(targets) == [float(frame) for frame in range(2, 9)]
    for frame in range(2, 9):
        scene.frame_set(frame)
        assert targets[frame] == pytest.approx(tuple(empty.location), abs=1e-5)
    assert abs(targets[3][0] - 1.0) > 0.2, "the default curve eases in, it is no straight line"


def test_an_empty_that_rides_on_another_is_followed_without_touching_the_users_frame_or_pose(
    scene: bpy.types.Scene,
) -> None:
    empty = hook_empty(scene)
    rail = bpy.data.objects.new("rail", None)
    guide = bpy.data.objects.new("guide", None)
    for each in (rail, guide):
        scene.collection.objects.link(each)
    empty.location = (0, 0, 1)
    empty.parent = rail
    for frame, x in ((2, 0.0), (8, 6.0)):
        rail.location.x = x
        rail.keyframe_insert("location", frame=frame)
    for curve in curves_of(rail):
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    copying = empty.constraints.new("COPY_LOCATION")
    copying.target, copying.use_x, copying.use_z = guide, False, False
    guide.location.y = 5.0
    scene.frame_set(5)
    rail.location.x = 99.0
    bpy.context.view_layer.update()
    target_samples.mark_dirty()
    targets = event_value(scene, scene.lappet.events[0]).targets
    expected = [(float(f), (f - 2.0, 5.0, 1.0)) for f in range(2, 9)]
    assert [time for time, _ in targets] == [time for time, _ in expected]
    np.testing.assert_allclose([p for _, p in targets], [p for _, p in expected], atol=1e-5)
    assert (scene.frame_current, rail.location.x) == (5, 99.0)
    assert len(bpy.data.scenes) == 1


def test_a_hook_whose_empty_was_deleted_is_refused_with_the_repair(scene: bpy.types.Scene) -> None:
    empty = hook_empty(scene, (2, (0, 0, 4)), (8, (6, 0, 4)))
    scene.collection.objects.unlink(empty)
    with pytest.raises(RefusedError) as caught:
        event_value(scene, scene.lappet.events[0])
    (problem,) = caught.value.problems
    assert (problem.code, problem.prim) == (ProblemCode.EVENT_TARGET_MISSING, "hook_1")


def test_names_are_usd_identifiers_and_never_given_twice(scene: bpy.types.Scene) -> None:
    names = [add_event(scene, "HOOK").name for _ in range(3)]
    assert names == ["hook_1", "hook_2", "hook_3"]
    remove_event(scene, find_event(scene, "hook_2"))
    assert add_event(scene, "HOOK").name == "hook_2"
    assert add_event(scene, "SUTURE", "hook_2").name == "hook_4"
    assert add_event(scene, "LANDMARK", "Crème brûlée!").name == "Creme_brulee_"
    assert add_event(scene, "LANDMARK", "3rd").name == "_3rd"
    event = find_event(scene, "hook_3")
    uid = event.uid
    assert rename_event(scene, event, "hook_1") == "hook_3"
    assert rename_event(scene, event, "  ") == "hook_3"
    event.title = "left flap"
    assert find_event(scene, uid).name == "left_flap"
    uids = [each.uid for each in scene.lappet.events]
    assert len(set(uids)) == len(uids)


def test_moving_an_event_moves_its_release_and_its_keyframes(scene: bpy.types.Scene) -> None:
    add(scene, HOOK)
    event = scene.lappet.events[0]
    event.moment = 10.5
    moved = event_value(scene, scene.lappet.events[0])
    assert (moved.start, moved.release) == (10.5, 40.5)
    assert moved.targets == tuple((round(time + 2.5, 4), place) for time, place in HOOK.targets)
    move_event(scene, event, 8.0)
    assert event_value(scene, scene.lappet.events[0]) == HOOK


def test_deleting_an_event_deletes_the_empty_that_was_made_for_it_and_no_other(scene: bpy.types.Scene) -> None:
    add(scene, HOOK)
    hook_empty(scene, (2, (0, 0, 4)), (8, (6, 0, 4)))
    actions = len(bpy.data.actions)
    for name in ("hook_1", "hook_2"):
        remove_event(scene, find_event(scene, name))
    assert [each.name for each in bpy.data.objects] == ["mine"]
    assert len(bpy.data.actions) == actions - 1
    assert len(scene.lappet.events) == 0


def test_the_list_is_ordered_by_time_and_ties_keep_their_order(scene: bpy.types.Scene) -> None:
    for kind, start in (("HOOK", 8), ("INCISION", 3), ("SUTURE", 8), ("UNDERMINE", 6)):
        add_event(scene, kind, start=start)
    assert event_list.sorted_events(scene) == [1, 3, 0, 2]


def test_numbers_that_blender_cannot_hold_come_back_as_long_as_nobody_changes_them(scene: bpy.types.Scene) -> None:
    """The frames of a procedure are found by it: the last digit of a design's stitches must not make them others."""
    ends = (((0.0, 1.0, TOP), (9.0, 1.0, TOP)), ((0.0, -1.0, TOP), (9.0, -1.0, TOP)))
    run = SutureRun("row", ends, 3.0, spacing=1.8234237920817506, margin=1.9599999999999997)
    set_event(scene, add_event(scene, "SUTURE_RUN", name="row"), run)
    event = find_event(scene, "row")
    assert event_value(scene, event) == run
    event.margin = 1.5
    assert event_value(scene, event) == replace(run, margin=1.5)
    set_event(scene, event, replace(run, spacing=float(np.float32(0.05))))
    assert event_value(scene, event) == replace(run, spacing=0.05), "as an operator's property gives it"
    set_event(scene, event, replace(run, spacing=2.0, margin=2.5))
    assert event_value(scene, event) == replace(run, spacing=2.0, margin=2.5)
    skin = replace(PRESETS["skin"].material, name="skin", youngs_modulus=1.5794000000000001)
    entry = scene.lappet.materials.add()
    set_material(scene, entry, skin)
    assert material_values(scene)[-1] == skin
    assert find_material(scene, skin) == "skin"
    entry.youngs_modulus = 20.0
    assert material_values(scene)[-1] == replace(skin, youngs_modulus=20.0)
