"""Follow a session that somebody else solves with a daemon: the frames that they get, one after the other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.connection import DaemonConnection
from lappet.daemon.frame_message import read_frame
from lappet.daemon.frame_solver import Iteration
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.running_daemon import RunningDaemon
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.wire import Message, WireError, read_fields
from lappet.program.program import Program


def follow_session(
    daemon: RunningDaemon,
    session: int,
    program: Program,
    on_frame: Callable[[SolvedFrame], None],
    on_progress: Callable[[Iteration], None] = lambda iteration: None,
) -> None:
    """Follow a session that was shared, or one of the same user, until it is over.

    Frames that were answered before are not seen. The daemon tells what the solver answers, not what it was asked: that
    is the follower's own program, which must be the author's.

    Parameters
    ----------
    daemon
        The daemon; it must have keys.
    session
        Number of the session, which its author knows.
    program
        What the session solves.
    on_frame
        Called with every frame, also one that did not converge; what it raises ends the following and is passed on.
    on_progress
        Called with where the solve of a frame stands.

    Raises
    ------
    DaemonDied
        If the daemon is gone or fell silent.
    RefusedError
        If the daemon refuses the user, there is no such session that they may follow, or it solves another program.
    """
    reader = _Reader(program, on_frame, on_progress)
    connection = DaemonConnection(daemon.address, keys=daemon.keys(), name="lappet follow")
    connection.connect()
    try:
        connection.follow(session, reader.read)
    finally:
        connection.close()


class _Reader:
    """What the messages of the session say of the program."""

    def __init__(
        self, program: Program, on_frame: Callable[[SolvedFrame], None], on_progress: Callable[[Iteration], None]
    ) -> None:
        self._program, self._on_frame, self._on_progress = program, on_frame, on_progress
        self._constraints = {frame.time: frame for frame in program.frames}
        self._position = {epoch.index: position for position, epoch in enumerate(program.epochs)}
        self._lattice: LatticeCounts | None = None

    def read(self, message: Message) -> None:
        if message.type == "lattice":
            self._lattice = read_fields(LatticeCounts, message.fields, "lattice")
        elif message.type == "progress":
            self._on_progress(read_fields(Iteration, message.fields, "progress"))
        elif message.type == "frame":
            self._on_frame(self._frame(message))
        else:
            raise WireError(f"The daemon sent '{message.type}' to a follower; install both from one release.")

    def _frame(self, message: Message) -> SolvedFrame:
        time = message.fields.get("time")
        constraints = self._constraints.get(time) if isinstance(time, float | int) else None
        if constraints is None:
            raise refused(ProblemCode.FOLLOWED_OTHER, "", f"{time!r:.40}")
        position = self._position[constraints.epoch]
        epoch, landmarks = self._program.epochs[position], self._program.landmarks_at[position]
        filled = {name for name, array in message.arrays.items() if len(array)}  # what an author left out is empty
        settings = replace(self._program.settings, strain="strain" in filled, correction="correction" in filled)
        sections = len(epoch.boundary.section_points)
        try:
            frame = read_frame(message, constraints, settings, landmarks, self._lattice, sections)
        except WireError as error:  # the counts of sutures, hooks, landmarks and sections are the program's
            raise refused(ProblemCode.FOLLOWED_OTHER, "", f"{time:g}") from error
        if len(frame.points) != len(epoch.surface.points):
            raise refused(ProblemCode.FOLLOWED_OTHER, "", f"{time:g}")
        return frame
