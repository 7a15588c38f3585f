"""Live mode: a hook's target is dragged and the skin follows."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from fake_worker import Script
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Hook, Retractor, place_of, pose_at
from lappet_blender.model.event_list import add_event, find_event
from lappet_blender.model.keyframes import curves_of
from lappet_blender.solving import controller, frames
from lappet_blender.solving.placed_drag import end_placing, place_live, pull_live
from lappet_blender.solving.solve_timer import run_timer
from refusals import refusal_code
from solving_steps import QUIET, live_points, solve, states

pytest_plugins = ("solving_fixtures",)


def drag(z: float) -> None:
    """Moves the target as the mouse would."""
    bpy.data.objects["target"].location.z = z
    bpy.context.view_layer.update()


@pytest.fixture
def live(patch: bpy.types.Scene, script: Script) -> bpy.types.Scene:
    """Live mode on at frame 5, the frames solved."""
    bpy.ops.lappet.solve(wait=True)
    patch.frame_set(5)
    patch.lappet.active_event = 1
    assert bpy.ops.lappet.live() == {"FINISHED"}
    return patch


def test_the_skin_follows_the_target_and_only_the_frame_it_is_dragged_at(live: bpy.types.Scene, script: Script) -> None:
    for _ in range(4):
        run_timer()
    assert frames.progress_of(live).live
    assert frames.progress_of(live).job_kind == "live"
    for z in (4.0, 5.5, 7.0):
        drag(z)
        for _ in range(3):
            run_timer()
        np.testing.assert_allclose(live_points(live)[0], (0.0, 3.0, z), atol=1e-6)
        np.testing.assert_array_equal(frames.shown_at(live, 5).frame.points, live_points(live))
    assert [place_of(each) for each in script.workers[-1].targets] == [
        (0.0, 3.0, 4.0),
        (0.0, 3.0, 5.5),
        (0.0, 3.0, 7.0),
    ]
    assert frames.shown_at(live, 6).frame.points[0, 2] == 7.0
    assert states(live) == "ssssssss", "nothing is read anew while it is dragged"


def test_ending_it_leaves_the_target_where_it_is_and_makes_the_frames_stale(
    live: bpy.types.Scene, script: Script
) -> None:
    drag(6.0)
    for _ in range(4):
        run_timer()
    assert bpy.ops.lappet.live() == {"FINISHED"}
    assert live_points(live) is None
    assert not live.lappet.solving.live
    assert not run_timer(QUIET)
    assert bpy.data.objects["target"].location.z == 6.0
    assert bpy.data.objects["target"].animation_data is None, "what was not animated gets no keyframe"
    assert states(live) == "sssttttt"


def test_changing_how_it_looks_does_not_end_it(live: bpy.types.Scene, script: Script) -> None:
    drag(6.0)
    run_timer()
    live.lappet.look.color = "STRAIN"
    for _ in range(3):
        run_timer()
    assert controller.controller_of(live).live is not None
    drag(7.0)
    for _ in range(3):
        run_timer()
    assert live_points(live)[0, 2] == 7.0


def test_switching_the_property_off_going_to_another_frame_or_editing_ends_it(
    live: bpy.types.Scene, script: Script
) -> None:
    live.lappet.solving.live = False
    run_timer(QUIET)
    assert controller.controller_of(live).live is None
    assert controller.controller_of(live).job is None
    bpy.ops.lappet.live()
    live.frame_set(6)
    run_timer(QUIET)
    assert controller.controller_of(live).live is None
    bpy.ops.lappet.live()
    find_event(live, "hook_1").stiffness = 70.0
    run_timer(QUIET)
    assert controller.controller_of(live).live is None
    assert not live.lappet.solving.live
    assert script.count("live") == 3


@pytest.mark.parametrize("leaves", [True, False], ids=["going to another frame ends it", "the button ends it"])
def test_an_animated_target_is_keyed_where_it_was_dragged(patch: bpy.types.Scene, script: Script, leaves: bool) -> None:
    target = bpy.data.objects["target"]
    for frame, z in ((4, 2.0), (8, 6.0)):
        target.location.z = z
        target.keyframe_insert("location", frame=frame)
    patch.frame_set(6)
    bpy.ops.lappet.live(hook="hook_1")
    for _ in range(4):
        run_timer()
    drag(9.0)
    for _ in range(4):
        run_timer()
    if leaves:
        patch.frame_set(5)
        run_timer()
    else:
        bpy.ops.lappet.live()
        patch.frame_set(5)
    assert controller.controller_of(patch).live is None
    patch.frame_set(6)
    assert abs(target.location.z - 9.0) < 1e-5


def test_a_target_that_was_not_dragged_is_not_keyed(patch: bpy.types.Scene, script: Script) -> None:
    target = bpy.data.objects["target"]
    for frame, z in ((4, 2.0), (8, 6.0)):
        target.location.z = z
        target.keyframe_insert("location", frame=frame)
    patch.frame_set(6)
    bpy.ops.lappet.live(hook="hook_1")
    for _ in range(4):
        run_timer()
    bpy.ops.lappet.live()
    assert all(len(curve.keyframe_points) == 2 for curve in curves_of(target))


def test_only_a_hook_that_pulls_at_this_frame_can_be_dragged(patch: bpy.types.Scene, script: Script) -> None:
    patch.frame_set(2)
    assert refusal_code(lambda: bpy.ops.lappet.live(hook="hook_1")) is ProblemCode.HOOK_NOT_PULLING
    assert refusal_code(lambda: bpy.ops.lappet.live(hook="incision_1")) is ProblemCode.LIVE_NOT_A_HOOK
    assert refusal_code(lambda: bpy.ops.lappet.live(hook="nobody")) is ProblemCode.LIVE_NO_EVENT
    patch.frame_set(5)
    find_event(patch, "hook_1").enabled = False
    assert refusal_code(lambda: bpy.ops.lappet.live(hook="hook_1")) is ProblemCode.HOOK_NOT_PULLING
    find_event(patch, "hook_1").enabled = True
    bpy.ops.lappet.solve()
    assert refusal_code(lambda: bpy.ops.lappet.live(hook="hook_1")) is ProblemCode.SOLVE_RUNNING
    assert script.count("live") == 0


def test_undo_ends_it(live: bpy.types.Scene, script: Script) -> None:
    bpy.ops.ed.undo_push(message="one")
    add_event(live, "SUTURE", start=5, points=[(2, -1, 2), (2, 1, 2)])
    bpy.ops.ed.undo_push(message="two")
    run_timer(QUIET)
    bpy.ops.lappet.live(hook="hook_1")
    run_timer()
    bpy.ops.ed.undo()
    scene = bpy.context.scene
    assert controller.controller_of(scene).live is None
    run_timer(QUIET)
    assert states(scene) == "ssssssss"


HELD = Hook("hook_2", (-2.0, 2.0, 2.0), ((5.0, (-2.0, 2.0, 2.0)),), 5.0, 9.0)


def test_the_skin_follows_a_hook_that_is_still_being_placed_and_no_event_is_made(
    patch: bpy.types.Scene, script: Script
) -> None:
    solve(patch)
    patch.frame_set(5)
    before = frames.shown_at(patch, 5).frame.points
    placing = place_live(patch, HELD)
    for z in (3.0, 6.0):
        pull_live(patch, placing, pose_at((-2.0, 2.0, z)))
        for _ in range(4):
            run_timer()
        np.testing.assert_allclose(live_points(patch)[0], (-2.0, 2.0, z), atol=1e-6)
        np.testing.assert_array_equal(frames.shown_at(patch, 5).frame.points, live_points(patch))
    assert len(patch.lappet.events) == 2
    assert states(patch) == "ssssssss", "the hook is no part of the scene's procedure"
    end_placing(patch, placing)
    run_timer(QUIET)
    assert live_points(patch) is None
    assert states(patch) == "ssssssss"
    np.testing.assert_array_equal(frames.shown_at(patch, 5).frame.points, before)
    assert not patch.lappet.solving.live


def test_a_retractor_is_placed_with_its_faces_as_a_group_that_only_the_solver_knows(
    patch: bpy.types.Scene, script: Script
) -> None:
    solve(patch)
    patch.frame_set(5)
    tissue = controller.controller_of(patch).procedure.tissue
    held = Retractor("retractor_1", "grip_1", ((5.0, pose_at((-2.0, 2.0, 2.0))),), 5.0, 9.0)
    placing = place_live(patch, held, np.array([0, 2]))
    asked = controller.controller_of(patch).job.procedure
    assert asked.tissue.subsets["grip_1"].tolist() == [0, 2]
    assert asked.events[-1] == held
    assert "grip_1" not in tissue.subsets
    end_placing(patch, placing)
    run_timer(QUIET)
    assert states(patch) == "ssssssss"


def test_a_hook_is_placed_without_the_skin_where_somebody_would_wait_for_it(
    patch: bpy.types.Scene, script: Script
) -> None:
    patch.frame_set(5)
    run_timer(QUIET)
    assert place_live(patch, HELD) is None, "the frame before is not solved"
    solve(patch)
    placing = place_live(patch, HELD)
    assert placing is not None
    assert place_live(patch, HELD) is None, "another hook is dragged"
    patch.frame_set(6)
    run_timer(QUIET)
    assert controller.controller_of(patch).live is None, "it went to another frame"
    pull_live(patch, placing, pose_at((0.0, 0.0, 9.0)))
    assert pose_at((0.0, 0.0, 9.0)) not in script.workers[-1].targets
    find_event(patch, "hook_1").stiffness = 33.0
    bpy.ops.lappet.solve()
    assert place_live(patch, HELD) is None, "a solve is under way"


def test_a_frame_without_a_hook_numbers_the_others_as_a_program_without_it() -> None:
    index = np.array([0, 2, 3], np.int32)
    frame = SolvedFrame(
        5.0, np.zeros((1, 3), np.float32), hook_index=index, hook_points=np.eye(3), hook_forces=2.0 * np.eye(3)
    )
    left = frame.without_hook(2)
    assert left.hook_index.tolist() == [0, 2]
    np.testing.assert_array_equal(left.hook_points, np.eye(3)[[0, 2]])
    np.testing.assert_array_equal(left.hook_forces, 2.0 * np.eye(3)[[0, 2]])
    assert frame.without_hook(1).hook_index.tolist() == [0, 1, 2]
