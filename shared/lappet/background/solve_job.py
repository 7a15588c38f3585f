"""Run a job of the worker: list the frames of a procedure, or solve them and tell of each."""

from __future__ import annotations

import time
import traceback
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.background.assessment import Assessment, assessment_key, pulls_of
from lappet.background.compilation import Compilation, up_to
from lappet.background.job import CancelledError, Job
from lappet.background.kept_frames import KeptFrames
from lappet.background.manifest import Manifest
from lappet.background.worker_events import (
    Assessed,
    Finished,
    FrameFailed,
    FrameReady,
    IterationDone,
    Listed,
    Note,
    Refused,
    WorkerEvent,
)
from lappet.core.problem import Problem, ProblemsError, RefusedError, file_problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.daemon.frame_solver import Connect, FrameSolver, Iteration
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.procedure.prim_paths import ROOT
from lappet.program.program import Bones, FrameConstraints, Landmarks, Program
from lappet.program.settings import SolverSettings
from lappet.solve.error_estimate import ErrorEstimate, estimate_errors
from lappet.solve.measure_errors import errors_of_measures
from lappet.solve.measures import Gauges
from lappet.solve.result_notes import result_notes
from lappet.solve.sensitive import several_notes
from lappet.solve.solve_frames import FrameResult, Frames, SolveObserver, solve_program
from lappet.solve.suture_forces import suture_warnings
from lappet.solve.untrusted import untrusted

Tell = Callable[[WorkerEvent], None]


class SolveJobs:
    """A runner of jobs, one after another on the thread that calls it.

    Parameters
    ----------
    compilation
        Where manifests and programs come from.
    store
        Where frames are kept.
    connect
        Makes the solver.
    tell
        Takes what happens.
    """

    def __init__(self, compilation: Compilation, store: KeptFrames, connect: Connect, tell: Tell) -> None:
        self.compilation = compilation
        self.store = store
        self.connect = connect
        self.tell = tell

    def run(self, job: Job) -> None:
        """Manifest, and solve where that is asked; end with `Finished` whatever happens.

        Parameters
        ----------
        job
            The job.
        """
        begun = time.perf_counter()
        done = 0
        try:
            job.step()
            self.store.try_again()
            done = self._run(job)
        except RefusedError as error:
            self.tell(Refused(job.number, error.problems))
        except CancelledError:
            pass
        except Exception as error:
            found = _problem(error)
            if job.at is None:
                self.tell(Refused(job.number, (found,)))
            else:
                self.tell(FrameFailed(job.number, job.at, found))
        self.tell(Finished(job.number, done, time.perf_counter() - begun, job.cancelled))

    def _run(self, job: Job) -> int:
        manifest = self.manifest(job)
        return 0 if job.kind == "manifest" else self.solve(job, manifest, job.ask.until)

    def manifest(self, job: Job) -> Manifest:
        """Make the manifest of a job and tell it to the owner.

        Parameters
        ----------
        job
            The job.

        Returns
        -------
        Manifest
            The manifest.
        """
        well = self.store.trouble is None
        manifest = self.compilation.manifest(job.ask.procedure, job.ask.settings, job.step)
        if well and self.store.trouble is not None:
            self.tell(Note(job.number, self.store.trouble))
        self.tell(Listed(job.number, manifest, tuple(frame.key in self.store for frame in manifest.frames)))
        job.at = job.ask.time if job.kind == "live" else manifest.frames[0].time
        return manifest

    def solve(self, job: Job, manifest: Manifest, until: int | None) -> int:
        """Get the frames of a manifest.

        Parameters
        ----------
        job
            The job.
        manifest
            Its manifest.
        until
            Last time code, or None for all.

        Returns
        -------
        int
            How many frames are there.
        """
        wanted = [frame for frame in manifest.frames if until is None or frame.time <= until]
        if all(frame.key in self.store for frame in wanted):
            key = assessment_key([frame.key for frame in wanted], job.ask.settings.correction, job.ask.procedure)
            known = self.store.get(key, Assessment)
            if known is not None:
                for frame in wanted:
                    job.step()
                    self.tell(FrameReady(job.number, frame.time, frame.key, True, self._held(frame.key)))
                self.tell(Assessed(job.number, known))
                return len(wanted)
        program = up_to(self.compilation.compiled(job.ask.procedure, job.ask.settings, job.step).program, until)
        frames = self.frames(job, program)
        if frames.reason is not None and not frames.interrupted:
            self.tell(FrameFailed(job.number, round(program.frames[len(frames.frames)].time), frames.reason))
        if job.kind == "solve" and frames.frames and not frames.interrupted:
            self.assess(job, program, frames.frames)
        return len(frames.frames)

    def assess(self, job: Job, program: Program, frames: Sequence[FrameResult]) -> None:
        """Tell what is to be known of the frames of a job, with their estimated errors where these are wanted.

        Parameters
        ----------
        job
            The job.
        program
            The program.
        frames
            Its frames, at least one.
        """
        procedure, errors = job.ask.procedure, ErrorEstimate((), 0.0, 0.0, 0.0)
        gauges, solved = Gauges(program), [frame.solved for frame in frames]
        measures = [gauges.measure(each) for each in solved]
        rows = [row for each in measures for row in each.sutures]
        notes = result_notes(program, frames)
        notes += suture_warnings(program, rows)
        wanted = job.ask.settings.correction
        if wanted:
            connect, identity = stoppable(self.connect, job), self.compilation.identity
            errors = estimate_errors(program, frames, self.store, connect, identity, _Stopping(job))
            job.step()
            notes += untrusted(program, frames, errors) + several_notes(frames, errors.frames)
            measures = errors_of_measures(program, gauges, solved, measures, errors)
        found = Assessment(tuple(notes), errors.frames, tuple(pulls_of(each) for each in measures))
        self.store.put(assessment_key([frame.key for frame in frames], wanted, procedure), found)
        self.tell(Assessed(job.number, found))

    def frames(self, job: Job, program: Program) -> Frames:
        """Solve a program and tell of each frame.

        Parameters
        ----------
        job
            The job.
        program
            The program.

        Returns
        -------
        Frames
            The frames.
        """
        connect = stoppable(self.connect, job)
        return solve_program(program, self.store, connect, self.compilation.identity, _Telling(job, self))

    def _held(self, key: str) -> SolvedFrame | None:
        """A frame that only this process has."""
        stored = self.store.get(key, SolvedFrame) if self.store.holds(key) else None
        return None if stored is None else stored.shown()


class _Stopping(SolveObserver):
    """Stop a solve once it is cancelled."""

    def __init__(self, job: Job) -> None:
        self._job = job

    def iteration(self, iteration: Iteration) -> None:
        """A Newton iteration is done."""
        self._stop()

    def frame(self, frame: FrameResult) -> None:
        """A frame is there."""
        self._stop()

    def _stop(self) -> None:
        if self._job.cancelled:
            raise KeyboardInterrupt  # what ends a solve and keeps what is done


class _Telling(SolveObserver):
    """Tell the owner how a solve goes, and stop it once it is cancelled."""

    def __init__(self, job: Job, jobs: SolveJobs) -> None:
        self._job = job
        self._jobs = jobs

    def iteration(self, iteration: Iteration) -> None:
        """A Newton iteration is done."""
        self._stop()
        self._job.at = round(iteration.time)
        self._jobs.tell(
            IterationDone(self._job.number, iteration.time, iteration.newton, iteration.residual, iteration.gap)
        )

    def frame(self, frame: FrameResult) -> None:
        """A frame is there: told whole, unless the owner finds it in the store."""
        found = frame.looked_up and not self._jobs.store.holds(frame.key)
        shown = None if found else frame.solved.shown()
        self._jobs.tell(FrameReady(self._job.number, round(frame.constraints.time), frame.key, frame.looked_up, shown))
        self._stop()

    def note(self, note: Problem) -> None:
        """Something that the user should know."""
        self._jobs.tell(Note(self._job.number, note))

    def _stop(self) -> None:
        if self._job.cancelled:
            raise KeyboardInterrupt  # what ends a solve and keeps what is done


def _problem(error: Exception) -> Problem:
    """Return what a refusal, or an error of our own, is told as."""
    if isinstance(error, ProblemsError):
        return error.problems[0]
    if isinstance(error, OSError):
        return file_problem(error)
    traceback.print_exception(error)
    return problem(ProblemCode.BACKGROUND_INTERNAL, ROOT, f"{type(error).__name__}: {error}")


def stoppable(connect: Connect, job: Job) -> Connect:
    """Make sessions that end with KeyboardInterrupt at the next request, or Newton iteration, after a cancel.

    Parameters
    ----------
    connect
        Makes the solver.
    job
        The job that may be cancelled.

    Returns
    -------
    Connect
        The function that opens such sessions.
    """
    return lambda settings, bones: _Stoppable(connect, settings, bones, job)


class _Stoppable:
    """A `FrameSolver` that looks, before each request, whether its job is still wanted."""

    def __init__(self, connect: Connect, settings: SolverSettings, bones: Bones, job: Job) -> None:
        self._job = job
        self._stop()
        self._solver: FrameSolver = connect(settings, bones)

    def set_epoch(self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> LatticeCounts:
        self._stop()
        return self._solver.set_epoch(epoch, grip, landmarks)

    def set_epoch_with_nodes(
        self, epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks
    ) -> tuple[LatticeCounts, NDArray[np.float64]]:
        self._stop()
        return self._solver.set_epoch_with_nodes(epoch, grip, landmarks)

    def set_state(self, state: SolverState) -> None:
        self._stop()
        self._solver.set_state(state)

    def solve(self, frame: FrameConstraints, progress: Callable[[Iteration], None]) -> SolvedFrame:
        self._stop()

        def seen(iteration: Iteration) -> None:
            self._stop()
            progress(iteration)

        return self._solver.solve(frame, seen)

    def close(self) -> None:
        self._solver.close()

    def _stop(self) -> None:
        if self._job.cancelled:
            raise KeyboardInterrupt
