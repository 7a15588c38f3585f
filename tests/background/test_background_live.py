"""Live mode: the skin follows a hook's target, and nothing of it is kept."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from background_owner import SETTINGS, Owner, daemon_of, kill, owner
from lappet.background.held import HeldHook, held_in
from lappet.background.live_session import LiveSession
from lappet.background.worker_events import Finished, FrameFailed, FrameReady, LiveFrame, Refused, WorkerEvent
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import SolverDiedError
from lappet.daemon.solved_frame import SCALARS, SolvedFrame
from lappet.output.solve_to_cache import solve_procedure
from lappet.procedure import Hook, Incision, Point, Procedure, Retractor, matrix_pose, pose_at
from lappet.program.compile import compile_program
from lappet.program.program import Bones
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore
from small_procedure import TOP, FakeSolver, small_procedure


def pulled(own: Owner, job: int, target: Point) -> LiveFrame:
    """Moves the hook and waits for the skin at that target."""
    own.solver.live_target(job, pose_at(target))

    def there(each: WorkerEvent) -> bool:
        return isinstance(each, LiveFrame) and each.job == job and each.target == pose_at(target)

    found = own.until(there)
    assert isinstance(found, LiveFrame)
    return found


def opened(own: Owner, job: int) -> LiveFrame:
    """Waits for the first live frame."""
    found = own.until(lambda each: isinstance(each, LiveFrame | Finished) and each.job == job)
    assert isinstance(found, LiveFrame), own.happened
    return found


@pytest.mark.slow
def test_the_hooked_point_follows_the_target_until_it_is_let_go(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.live(small_procedure(), SETTINGS, 5, "hook")
        first = opened(own, job)
        assert first.time == 5
        # The frames before were solved on the way, and told as such; the frame itself was not.
        assert list(own.frames(job)) == [1, 2, 3, 4]
        assert first.converged
        reached = [first.frame.hook_points[0]]
        for k in range(1, 9):
            live = pulled(own, job, (0.0, 3.0 + 0.25 * k, 3.0 + 0.25 * k))
            assert live.converged
            assert live.frame.points.shape == first.frame.points.shape
            reached.append(live.frame.hook_points[0])
        way = np.array(reached)
        assert (np.diff(way[:, 1:], axis=0) > 0.1).all()
        assert np.linalg.norm(way[-1] - [0.0, 5.0, 5.0]) < 1.0
        moved = np.linalg.norm(live.frame.points - first.frame.points, axis=1)
        assert moved.max() > 1.0
        assert all(live.frame.scalar(name) is None for name in SCALARS)
        own.solver.cancel(job)
        assert own.finished(job).cancelled
        assert own.solver.running == ()


@pytest.mark.slow
def test_live_mode_finds_the_frame_that_a_solve_finds(tmp_path: Path, binary: Path) -> None:
    """Away and back again: an elastic tissue has one equilibrium, whatever the way there."""
    result = solve_procedure(small_procedure(), tmp_path / "c.usdc", store=FrameStore(tmp_path / "store"))
    solved = result.frames[5].solved.points
    target = (0.0, 4.0, TOP + 2.0)
    with owner(tmp_path / "store") as own:
        job = own.solver.live(small_procedure(), SETTINGS, 6, "hook")
        first = opened(own, job)
        assert not own.of(FrameReady, job)
        np.testing.assert_allclose(first.frame.points, solved, atol=0.02)
        away = pulled(own, job, (1.0, 1.0, TOP + 4.0))
        assert np.abs(away.frame.points - solved).max() > 1.0
        back = pulled(own, job, target)
        np.testing.assert_allclose(back.frame.points, solved, atol=0.05)


@pytest.mark.slow
def test_live_states_never_enter_the_store(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.live(small_procedure(), SETTINGS, 5, "hook")
        opened(own, job)
        files = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
        pulled(own, job, (0.0, 5.0, 5.0))
        pulled(own, job, (0.0, 5.0, 6.0))
        own.solver.cancel(job)
        own.finished(job)
        assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == files
        assert own.manifest(job).manifest.frames[4].key not in FrameStore(tmp_path)


@pytest.mark.slow
def test_a_target_out_of_reach_leaves_the_tissue_where_it_was(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.live(small_procedure(), SETTINGS, 5, "hook")
        opened(own, job)
        good = pulled(own, job, (0.0, 4.0, 4.0))
        far, infinite = ProblemCode.FRAME_UNREACHABLE, ProblemCode.SOLVER_INVALID_INPUT
        for target, code in (((0.0, 1e5, 4.0), far), ((float("inf"), 0.0, 0.0), infinite)):
            bad = pulled(own, job, target)
            assert bad.problem is not None
            assert (bad.problem.code, bad.problem.prim) == (code, "Frame 5")
            assert not bad.frame.converged
            np.testing.assert_array_equal(bad.frame.points, good.frame.points)
        again = pulled(own, job, (0.0, 4.0, 4.5))
        assert again.converged
        assert again.frame.hook_points[0, 2] > good.frame.hook_points[0, 2]


@pytest.mark.slow
def test_live_mode_outlives_its_daemon_and_its_worker(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.live(small_procedure(), SETTINGS, 5, "hook")
        opened(own, job)
        before = pulled(own, job, (0.0, 4.0, 4.0))
        worker = own.solver.worker
        assert worker is not None
        kill(daemon_of(worker))
        after = pulled(own, job, (0.0, 4.0, 4.1))
        assert after.converged
        assert np.abs(after.frame.points - before.frame.points).max() < 0.5
        assert [note.code for note in own.notes(job)] == [ProblemCode.DAEMON_RESTARTED]
        kill(worker)
        last = pulled(own, job, (0.0, 4.0, 4.2))
        assert last.converged
        restarted = [ProblemCode.DAEMON_RESTARTED, ProblemCode.BACKGROUND_RESTARTED]
        assert [note.code for note in own.notes(job)] == restarted
        assert len(own.of(Finished, job)) == 0


@pytest.mark.slow
def test_live_mode_waits_for_no_solve_and_only_the_newest_one_runs(tmp_path: Path, binary: Path) -> None:
    samples = tuple((float(t), (0.3 * (-1) ** t, 3.0, TOP + 1.0)) for t in range(3, 301))
    busy = small_procedure(
        events=(
            Incision("slit", 1.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1),
            Hook("hook", (0.0, 2.0, TOP), samples, 3.0, 1e6),
        ),
        end_time=300.0,
    )
    with owner(tmp_path) as own:
        solve = own.solver.solve(busy, SETTINGS)
        own.until(lambda each: isinstance(each, FrameReady))
        live = own.solver.live(small_procedure(), SETTINGS, 5, "hook")
        opened(own, live)
        newer = own.solver.live(small_procedure(), SETTINGS, 6, "hook")
        opened(own, newer)
        assert own.of(Finished, live)[0].cancelled
        assert solve in own.solver.running
        for job in (solve, newer):
            own.solver.cancel(job)
            own.finished(job)


@pytest.mark.slow
def test_a_hook_that_does_not_pull_there_is_refused_with_its_frames(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        for time, hook, says in ((7, "hook", "from 4 to 6"), (99, "hook", "from 1 to 8"), (5, "other", "no hook")):
            job = own.solver.live(small_procedure(), SETTINGS, time, hook)
            own.finished(job)
            (refused,) = own.of(Refused, job)
            assert refused.problems[0].prim == f"/Procedure/Timeline/{hook}"
            assert says in refused.problems[0].message


@pytest.mark.slow
def test_a_frame_before_that_fails_ends_live_mode_with_its_reason(tmp_path: Path, binary: Path) -> None:
    far = Hook("far", (4.0, 2.0, TOP), ((3.0, (4.0, 2.0, 1e6)),), 3.0, 4.0)
    with owner(tmp_path) as own:
        job = own.solver.live(small_procedure().with_events(far), SETTINGS, 5, "hook")
        assert not own.finished(job).cancelled
        (failed,) = own.of(FrameFailed, job)
        assert failed.time == 3
        assert not own.of(LiveFrame, job)


def session(solver: FakeSolver, notes: list[Problem]) -> LiveSession:
    """A session at the slit's first pulled frame, from the frame before it."""
    return LiveSession(compile_program(small_procedure()), 3, HeldHook(0), None, solver.connect, notes.append)


def test_a_session_solves_one_frame_at_a_relaxed_tolerance_with_the_hook_moved() -> None:
    asked: list[Any] = []

    class Recording(FakeSolver):
        def connect(self, settings: SolverSettings, bones: Bones) -> Any:
            asked.append(settings)
            inner = super().connect(settings, bones)
            solve = inner.solve

            def recorded(frame: Any, progress: Any) -> SolvedFrame:
                asked.append(frame)
                return solve(frame, progress)

            inner.solve = recorded  # type: ignore[method-assign]
            return inner

    live = session(Recording(), [])
    live.pull(pose_at((1.0, 2.0, 3.0)), lambda _: None)
    live.pull(pose_at((4.0, 5.0, 6.0)), lambda _: None)
    settings, *frames = asked
    assert settings.tolerance == 1e-2
    assert settings.live
    assert not settings.strain
    assert [frame.hook_targets.tolist() for frame in frames] == [[[1.0, 2.0, 3.0]], [[4.0, 5.0, 6.0]]]
    assert replace(frames[0], hook_targets=frames[1].hook_targets).time == 4.0


def gripped() -> Procedure:
    """The small procedure with a group of faces at its end, which nothing holds yet."""
    given = small_procedure()
    tissue = given.tissue
    ends = np.cumsum(tissue.face_vertex_counts)
    corners = [
        tissue.face_vertex_indices[end - count : end]
        for end, count in zip(ends, tissue.face_vertex_counts, strict=True)
    ]
    middles = np.array([tissue.points[each].mean(axis=0) for each in corners])
    near = (np.abs(middles[:, :2] - (0.0, 2.0)) < 2.0).all(axis=1) & (middles[:, 2] > TOP - 0.1)
    faces = np.flatnonzero(near).astype(np.int32)
    assert len(faces)
    return replace(given, tissue=replace(tissue, subsets={**tissue.subsets, "grip": faces}))


def retractor(start: float = 5.0) -> Retractor:
    """It holds that group."""
    return Retractor("retractor", "grip", ((start, pose_at((0.0, 2.0, TOP))),), start, 9.0)


def test_a_retractor_moves_by_its_pose_from_where_it_took_hold() -> None:
    given = gripped().with_events(retractor())
    program = compile_program(given)
    held = held_in(program, given, "retractor")
    frame = program.frames[4]
    assert held.own_target(frame) == pytest.approx(pose_at((0.0, 2.0, TOP)))
    assert [held.pulls(each) for each in program.frames] == [False] * 4 + [True] * 4
    angle = 0.3
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1.0]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, (1.0, 3.0, TOP + 2.0)
    (motion,) = held.moved(frame, matrix_pose(pose)).retractor_motion
    place = np.array([0.0, 2.0, TOP])
    for offset in ((0.0, 0.0, 0.0), (1.5, 0.0, 0.0)):
        moved = motion @ np.append(place + offset, 1.0)
        np.testing.assert_allclose(moved[:3], pose[:3, 3] + turn @ offset, atol=1e-12)


@pytest.mark.slow
def test_the_skin_follows_a_retractor_that_a_tool_still_places_from_the_frames_without_it(
    tmp_path: Path, binary: Path
) -> None:
    """In its epoch the keys of all frames differ, since it grips the epoch; none of them is solved again."""
    known = small_procedure(events=small_procedure().events[:1])
    tissue = gripped().tissue
    with owner(tmp_path) as own:
        solve = own.solver.solve(known, SETTINGS, until=4)
        own.finished(solve)
        asked = replace(known, tissue=tissue).with_events(retractor())
        job = own.solver.live(asked, SETTINGS, 5, "retractor", before=known)
        first = opened(own, job)
        assert not own.of(FrameReady, job)
        for shown, placed in zip(own.manifest(solve).manifest.epochs, own.manifest(job).manifest.epochs, strict=True):
            assert shown.key == placed.key, "the window has one picture for both"
        live = pulled(own, job, (0.0, 3.0, TOP + 2.0))
        assert live.converged
        way = live.frame.points - first.frame.points
        lifted = np.linalg.norm(way, axis=1).argmax()
        np.testing.assert_allclose(way[lifted], (0.0, 1.0, 2.0), atol=0.3)


def test_a_session_whose_solver_died_goes_on_from_the_last_good_state() -> None:
    solver, notes = FakeSolver(), []
    live = session(solver, notes)
    value = float(live.pull(pose_at((1.0, 2.0, 3.0)), lambda _: None).state.nodes[0, 0])
    deaths = [SolverDiedError.of(ProblemCode.DAEMON_DIED, "", "it was ended by SIGKILL.")]

    def dies_once(_: float) -> None:
        if deaths:
            raise deaths.pop()

    solver.before = dies_once
    live.pull(pose_at((1.0, 2.0, 4.0)), lambda _: None)
    assert ("state", value) in solver.log
    (note,) = notes
    assert note.code == ProblemCode.DAEMON_RESTARTED
    assert note.prim == "Frame 4"
    live.close()
    assert solver.opened == solver.closed == 2


def test_a_session_whose_solver_dies_three_times_gives_up() -> None:
    def dies(_: float) -> None:
        raise SolverDiedError.of(ProblemCode.DAEMON_DIED, "", "The daemon died.")

    solver = FakeSolver(before=dies)
    with pytest.raises(SolverDiedError):
        session(solver, []).pull(pose_at((1.0, 2.0, 3.0)), lambda _: None)
    assert solver.opened == solver.closed == 3


def test_a_state_of_the_epoch_before_is_carried_into_the_frames_own() -> None:
    program = compile_program(small_procedure(start_time=2.0))
    solver = FakeSolver()
    frame = solver.connect(program.settings, program.bones)
    frame.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
    before = frame.solve(program.frames[0], lambda _: None)
    solver.log.clear()

    moved = replace(program, frames=(program.frames[0], *program.frames[2:]))
    live = LiveSession(moved, 1, HeldHook(0), (0, before), solver.connect, lambda _: None)
    live.pull(pose_at((0.0, 3.0, 3.0)), lambda _: None)
    assert [what for what, _ in solver.log] == ["epoch", "state", "epoch", "solve"]
