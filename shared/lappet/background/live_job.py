"""Run live mode: bring the tissue to a frame, then follow the newest target of a hook or retractor."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import NoReturn

from lappet.background.compilation import Compiled
from lappet.background.held import Held, held_in
from lappet.background.job import CancelledError, Job
from lappet.background.live_session import LiveSession
from lappet.background.manifest import Manifest
from lappet.background.solve_job import SolveJobs, stoppable
from lappet.background.worker_events import FrameFailed, Listed, LiveFrame, Note
from lappet.background.worker_requests import Ask
from lappet.core.problem import Problem, RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import FrameRefusedError, SolverDiedError
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure.prim_paths import TIMELINE
from lappet.program.program import Program
from lappet.solve.solve_frames import at_frame, not_converged


class LiveJobs(SolveJobs):
    """A runner of live jobs; each lasts until it is cancelled."""

    def _run(self, job: Job) -> int:
        compiled = self._compiled(job)
        index = _index(compiled.manifest, job.ask)
        held = held_in(compiled.program, job.ask.procedure, job.ask.held)
        _check_pulls(compiled.program, index, held, job.ask)
        try:
            start = self._start(job, compiled, index)
        except _UnsolvedError:
            return 0
        session = LiveSession(
            compiled.program,
            index,
            held,
            start,
            stoppable(self.connect, job),
            lambda note: self.tell(Note(job.number, note)),
        )
        try:
            self._follow(job, session)
        except KeyboardInterrupt:
            raise CancelledError from None
        except (RefusedError, SolverDiedError) as error:
            self.tell(FrameFailed(job.number, job.ask.time, at_frame(job.ask.time, error)))
            return 0
        finally:
            session.close()

    def _compiled(self, job: Job) -> Compiled:
        """The program to pull in, its manifest told to the owner."""
        ask = job.ask
        if ask.before is None:
            self.manifest(job)
            return self.compilation.compiled(ask.procedure, ask.settings, job.step)
        compiled = self.compilation.placed(ask.before, ask.procedure, ask.settings, job.step)
        self.tell(Listed(job.number, compiled.manifest, (False,) * len(compiled.manifest.frames)))
        job.at = ask.time
        return compiled

    def _start(self, job: Job, compiled: Compiled, index: int) -> tuple[int, SolvedFrame] | None:
        """The epoch and the state to begin with; None: at rest. Raises _UnsolvedError."""
        if job.ask.before is not None:
            return self._start_before(job, compiled, index)
        program, listed = compiled.program, compiled.manifest.frames
        for at in (index, index - 1):
            if at < 0:
                return None
            stored = self.store.get(listed[at].key, SolvedFrame)
            if stored is None and at < index:
                if self.solve(job, compiled.manifest, listed[at].time) < index:
                    job.step()
                    raise _UnsolvedError
                stored = self.store.get(listed[at].key, SolvedFrame)
            if stored is not None:
                return program.frames[at].epoch, stored
        raise _UnsolvedError

    def _start_before(self, job: Job, compiled: Compiled, index: int) -> tuple[int, SolvedFrame] | None:
        """The same where what is held is no part yet of the procedure whose frames are known.

        The tissue is the same and so are its nodes, but where a retractor grips an epoch the keys of all its frames
        differ.
        """
        if index == 0 or job.ask.before is None:
            return None
        known = self.compilation.manifest(job.ask.before, job.ask.settings, job.step).frames[index - 1]
        stored = self.store.get(known.key, SolvedFrame)
        if stored is None:
            raise _UnsolvedError
        return compiled.program.frames[index - 1].epoch, stored

    def _follow(self, job: Job, session: LiveSession) -> NoReturn:
        target = session.own_target
        shown: SolvedFrame | None = None
        while True:
            begun = time.perf_counter()
            stayed: Problem | None = None
            try:
                solved = session.pull(target, lambda _: None)
                stayed = None if solved.converged else not_converged(solved)
                if stayed is None or shown is None:
                    shown = solved.without_scalars().shown()  # not worth sending while the mouse moves
            except FrameRefusedError as error:
                if shown is None:
                    raise
                stayed = at_frame(job.ask.time, error)
            if stayed is not None:
                shown = replace(shown, diagnostics=replace(shown.diagnostics, converged=False))
            seconds = time.perf_counter() - begun
            self.tell(LiveFrame(job.number, job.ask.time, target, shown, stayed, seconds))
            target = job.next_target()


class _UnsolvedError(Exception):
    """A frame before the one that is pulled was not found; its FrameFailed says why."""


def _index(manifest: Manifest, ask: Ask) -> int:
    """The index of the frame."""
    index = next((i for i, frame in enumerate(manifest.frames) if frame.time == ask.time), None)
    if index is None:
        start, end = manifest.frames[0].time, manifest.frames[-1].time
        raise refused(ProblemCode.LIVE_NO_FRAME, f"{TIMELINE}/{ask.held}", ask.time, start=start, end=end)
    return index


def _check_pulls(program: Program, index: int, held: Held, ask: Ask) -> None:
    """Refuse to drag what does not pull at the frame."""
    if held.pulls(program.frames[index]):
        return
    times = [round(frame.time) for frame in program.frames if held.pulls(frame)]
    when = f"it pulls from {times[0]} to {times[-1]}" if times else "it pulls at no frame"
    raise refused(ProblemCode.LIVE_NOT_PULLING, f"{TIMELINE}/{ask.held}", ask.time, when=when)
