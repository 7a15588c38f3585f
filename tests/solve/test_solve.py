"""The solve looks up what is known, solves the rest once, and keeps what is done whatever happens."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.core.problem import Problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import FrameRefusedError, SolverDiedError
from lappet.procedure import Procedure, Suture
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.solve.solve_frames import FrameResult, Frames, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from small_procedure import TOP, FakeSolver, small_procedure


@pytest.fixture(scope="module")
def program() -> Program:
    return compile_program(small_procedure())


class Ear(SolveObserver):
    """Remembers what it was told."""

    def __init__(self) -> None:
        self.total = 0
        self.frames: list[FrameResult] = []
        self.notes: list[Problem] = []

    def begin(self, frames: int) -> None:
        self.total = frames

    def frame(self, frame: FrameResult) -> None:
        self.frames.append(frame)

    def note(self, note: Problem) -> None:
        self.notes.append(note)


def run(program: Program, store: FrameStore, solver: FakeSolver, ear: Ear | None = None) -> Frames:
    return solve_program(program, store, solver.connect, "fake 1", ear or Ear())


def edited(program: Program, procedure: Procedure) -> Program:
    return compile_program(procedure, program.epochs)


def same_points(a: Frames, b: Frames) -> bool:
    return all(np.array_equal(x.solved.points, y.solved.points) for x, y in zip(a.frames, b.frames, strict=True))


def test_a_first_solve_solves_every_frame_in_order_and_each_epoch_once(program: Program, tmp_path: Path) -> None:
    solver, ear = FakeSolver(), Ear()
    result = run(program, FrameStore(tmp_path), solver, ear)
    assert result.reason is None
    assert solver.times() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert [index for what, index in solver.log if what == "epoch"] == [0, 1]
    assert not [1 for what, _ in solver.log if what == "state"]
    assert ear.total == 8
    assert [frame.constraints.time for frame in ear.frames] == solver.times()
    assert (solver.opened, solver.closed) == (1, 1)
    assert not any(frame.looked_up for frame in result.frames)
    assert result.frames[0].solved.state is None


def test_solving_again_starts_no_solver_and_gives_the_same_frames(program: Program, tmp_path: Path) -> None:
    first = run(program, FrameStore(tmp_path), FakeSolver())
    solver = FakeSolver()
    again = run(program, FrameStore(tmp_path), solver)
    assert solver.opened == 0
    assert all(frame.looked_up for frame in again.frames)
    assert same_points(first, again)
    assert again.frames[-1].solved.lattice == first.frames[-1].solved.lattice


def test_an_edit_solves_from_its_frame_on_and_its_undoing_solves_nothing(program: Program, tmp_path: Path) -> None:
    store, procedure = FrameStore(tmp_path), small_procedure()
    original = run(program, store, FakeSolver())
    pulled = replace(procedure.event("hook"), targets=((4.0, (0.0, 2.0, TOP)), (6.0, (0.0, 5.0, TOP))))  # type: ignore[type-var]
    events = tuple(pulled if event.name == "hook" else event for event in procedure.events)
    solver = FakeSolver()
    run(edited(program, replace(procedure, events=events)), store, solver)
    assert solver.times() == [5, 6, 7, 8]
    assert [what for what, _ in solver.log[:2]] == ["epoch", "state"]
    undone = FakeSolver()
    back = run(edited(program, procedure), store, undone)
    assert undone.opened == 0
    assert same_points(original, back)


def test_an_edit_at_the_first_frame_of_an_epoch_starts_from_the_epoch_before(program: Program, tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    whole = run(program, store, FakeSolver())
    for frame in whole.frames[2:]:
        store.path(frame.key).unlink()
    solver = FakeSolver()
    again = run(program, store, solver)
    assert [what for what, _ in solver.log[:3]] == ["epoch", "state", "epoch"]
    assert [value for what, value in solver.log if what == "epoch"] == [0, 1]
    assert solver.times() == [3, 4, 5, 6, 7, 8]
    assert same_points(whole, again)


def test_a_hole_in_the_store_is_filled_and_what_follows_is_looked_up(program: Program, tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    whole = run(program, store, FakeSolver())
    for i in (1, 5):
        store.path(whole.frames[i].key).unlink()
    solver = FakeSolver()
    again = run(program, store, solver)
    assert solver.times() == [1, 2, 6]  # 2 asks for the same as 1, so it has the numbers of that one
    assert solver.opened == 1
    assert same_points(whole, again)


@pytest.mark.parametrize("more", [True, False])
def test_the_state_fits_when_a_later_suture_comes_or_goes(program: Program, tmp_path: Path, more: bool) -> None:
    late = Suture("late", ((4.0, -1.0, TOP), (4.0, 1.0, TOP)), 7.0, 1.0)
    one, two = program, edited(program, small_procedure().with_events(late))
    before, after = (one, two) if more else (two, one)
    store = FrameStore(tmp_path)
    run(before, store, FakeSolver())
    solver = FakeSolver()  # asserts the shapes of the state
    result = run(after, store, solver)
    assert result.reason is None
    assert solver.times() == [7, 8]


def test_a_daemon_that_dies_is_started_again_and_goes_on_from_the_last_frame(program: Program, tmp_path: Path) -> None:
    undisturbed = run(program, FrameStore(tmp_path / "a"), FakeSolver())
    deaths = [5.0, 5.0, 7.0]

    def die(time: float) -> None:
        if deaths and time == deaths[0]:
            deaths.pop(0)
            raise SolverDiedError.of(ProblemCode.DAEMON_DIED, "", "it was ended by SIGKILL.")

    solver, ear = FakeSolver(before=die), Ear()
    result = run(program, FrameStore(tmp_path / "b"), solver, ear)
    assert result.reason is None
    assert solver.times() == [1, 2, 3, 4, 5, 6, 7, 8]
    assert solver.opened == solver.closed == 4
    assert same_points(undisturbed, result)
    assert [note.code for note in ear.notes] == [ProblemCode.DAEMON_RESTARTED] * 3
    assert ear.notes[0].value == "5"
    assert "SIGKILL" in ear.notes[0].message


def test_it_goes_on_from_the_last_frame_without_a_store_too(program: Program, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    undisturbed = run(program, FrameStore(tmp_path / "a"), FakeSolver())
    deaths = [6.0]

    def die(time: float) -> None:
        if time in deaths:
            deaths.remove(time)
            raise SolverDiedError.of(ProblemCode.DAEMON_DIED, "", "gone.")

    solver, ear = FakeSolver(before=die), Ear()
    result = run(program, FrameStore(tmp_path / "file"), solver, ear)
    assert same_points(undisturbed, result)
    assert [note.code for note in ear.notes].count(ProblemCode.STORE_NOT_WRITABLE) == 1


def test_a_daemon_that_dies_three_times_over_one_frame_ends_the_solve(program: Program, tmp_path: Path) -> None:
    def die(time: float) -> None:
        if time == 4.0:
            raise SolverDiedError.of(ProblemCode.DAEMON_DIED, "", "it was ended by SIGSEGV.")

    solver = FakeSolver(before=die)
    result = run(program, FrameStore(tmp_path), solver)
    assert solver.opened == solver.closed == 3
    assert len(result.frames) == 3
    assert result.reason is not None
    assert result.reason.code is ProblemCode.DAEMON_DIED_AGAIN
    assert result.reason.prim == "Frame 4"
    assert "SIGSEGV" in result.reason.message


def test_a_frame_that_does_not_converge_ends_the_solve_and_is_not_kept(program: Program, tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    result = run(program, store, FakeSolver(unconverged=frozenset({6.0})))
    assert len(result.frames) == 5
    assert result.failed is not None
    assert result.failed.constraints.time == 6.0
    assert result.failed.key not in store
    assert result.reason is not None
    assert (result.reason.code, result.reason.prim) == (ProblemCode.FRAME_NOT_CONVERGED, "Frame 6")
    assert result.reason.value == "the line search found no decrease."
    solver = FakeSolver()
    assert run(program, store, solver).reason is None
    assert solver.times() == [6, 7, 8]


def test_ctrl_c_keeps_the_frames_that_are_done_and_ends_the_daemon(program: Program, tmp_path: Path) -> None:
    def stop(time: float) -> None:
        if time == 4.0:
            raise KeyboardInterrupt

    store, solver = FrameStore(tmp_path), FakeSolver(before=stop)
    result = run(program, store, solver)
    assert result.interrupted
    assert [frame.constraints.time for frame in result.frames] == [1, 2, 3]
    assert (solver.opened, solver.closed) == (1, 1)
    after = FakeSolver()
    assert run(program, store, after).reason is None
    assert after.times() == [4, 5, 6, 7, 8]


def test_what_the_daemon_refuses_ends_the_solve_with_its_sentence(program: Program, tmp_path: Path) -> None:
    def refuse(time: float) -> None:
        raise FrameRefusedError.of(
            ProblemCode.SOLVER_MEMORY_BUDGET, "", "the lattice needs 9 GiB; coarsen the spacing."
        )

    solver = FakeSolver(before=refuse)
    result = run(program, FrameStore(tmp_path), solver)
    assert result.frames == ()
    assert result.reason is not None
    assert (result.reason.code, result.reason.prim) == (ProblemCode.SOLVER_MEMORY_BUDGET, "Frame 1")
    assert result.reason.value == "the lattice needs 9 GiB; coarsen the spacing."
    assert (solver.opened, solver.closed) == (1, 1)


def test_a_daemon_that_cannot_be_started_is_a_reason(program: Program, tmp_path: Path) -> None:
    def missing(*_: object) -> None:
        raise refused(ProblemCode.DAEMON_MISSING, "lappet-solverd", "here")

    result = solve_program(program, FrameStore(tmp_path), missing, "x", Ear())  # type: ignore[arg-type]
    assert result.reason is not None
    assert (result.reason.code, result.reason.prim) == (ProblemCode.DAEMON_MISSING, "lappet-solverd")


def test_only_frames_up_to_the_last_one_wanted_are_solved(tmp_path: Path, program: Program) -> None:
    short = compile_program(small_procedure(), program.epochs, until=4)
    solver = FakeSolver()
    store = FrameStore(tmp_path)
    run(short, store, solver)
    assert solver.times() == [1, 2, 3, 4]
    rest = FakeSolver()
    run(program, store, rest)
    assert rest.times() == [5, 6, 7, 8]
