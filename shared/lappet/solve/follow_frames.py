"""Follow a session that somebody else solves: their frames of a program, as they come."""

from __future__ import annotations

import time
from dataclasses import replace

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import solver_identity
from lappet.daemon.follower import follow_session
from lappet.daemon.frame_solver import SolverDiedError
from lappet.daemon.running_daemon import RunningDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.keys import frame_keys
from lappet.program.program import Program
from lappet.solve.solve_frames import FrameResult, Frames, SolveObserver, not_converged


def follow_program(program: Program, daemon: RunningDaemon, session: int, watch: SolveObserver) -> Frames:
    """See the frames of a program that somebody else has a daemon solve, until their session is over.

    Parameters
    ----------
    program
        The program, the same as the author's.
    daemon
        The daemon.
    session
        Number of the author's session.
    watch
        Is told how their solve goes.

    Returns
    -------
    Frames
        The frames in order: without a gap, those up to the last one that was seen. And why they are not all.

    Raises
    ------
    RefusedError
        If the daemon refuses the user, there is no such session that they may follow, or it solves another program.
    DaemonDied
        If the daemon is gone before anything was seen.
    """
    seen = _Seen(program, frame_keys(program, solver_identity(daemon)), watch)
    watch.begin(len(program.frames))
    interrupted, died = False, None
    try:
        follow_session(daemon, session, program, seen.take, watch.iteration)
    except KeyboardInterrupt:
        if not seen.results:
            raise
        interrupted = True
    except SolverDiedError as error:
        if not seen.results:
            raise
        died = error.problems[0]
    frames = seen.unbroken()
    return Frames(frames, died or seen.missing(session, len(frames)), interrupted, seen.failed)


class _Seen:
    """The frames that came, by their position in the program."""

    def __init__(self, program: Program, keys: tuple[str, ...], watch: SolveObserver) -> None:
        self._program, self._keys, self._watch = program, keys, watch
        self._position = {frame.time: position for position, frame in enumerate(program.frames)}
        self._before = time.perf_counter()
        self.results: dict[int, FrameResult] = {}
        self.failed: FrameResult | None = None

    def take(self, solved: SolvedFrame) -> None:
        """Keep a frame; one that comes again, as after the author's daemon was started anew, has the same numbers."""
        now = time.perf_counter()
        at = self._position[solved.time]
        bare = replace(solved, state=None)
        result = FrameResult(self._program.frames[at], self._keys[at], bare, False, now - self._before)
        self._before = now
        if not solved.converged:
            self.failed = result
        elif at not in self.results:
            self.failed = None
            self.results[at] = result
            self._watch.frame(result)

    def unbroken(self) -> tuple[FrameResult, ...]:
        """The last frames between which none is missing."""
        last = max(self.results, default=-1)
        first = last
        while first - 1 in self.results:
            first -= 1
        return tuple(self.results[at] for at in range(first, last + 1) if at >= 0)

    def missing(self, session: int, frames: int) -> Problem | None:
        """Why there are not all frames."""
        if self.failed is not None:
            return not_converged(self.failed.solved)
        if frames == len(self._keys):
            return None
        if not self.results:
            return problem(ProblemCode.FOLLOWED_NONE, "", session)
        return problem(ProblemCode.FOLLOWED_PART, "", frames, frames=len(self._keys))
