"""What the owner asks of the worker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lappet.daemon.running_daemon import RunningDaemon
from lappet.procedure import Pose, Procedure
from lappet.program.settings import SolverSettings

JobKind = Literal["manifest", "solve", "live"]


@dataclass(frozen=True, eq=False)
class Ask:
    """A job.

    Parameters
    ----------
    job
        Number of the job.
    kind
        What is asked.
    procedure
        The procedure.
    settings
        How to solve.
    until
        Last frame to solve, or None for all.
    time
        Frame of live mode.
    held
        Hook or retractor of live mode.
    before
        Of live mode: the procedure without what is held, where a tool still places that. Its frames are where the
        tissue begins; None: those of the procedure.
    identity
        What identifies the solver, where the owner knows it.
    daemon
        The daemon that solves, where it runs already.
    """

    job: int
    kind: JobKind
    procedure: Procedure
    settings: SolverSettings
    until: int | None = None
    time: int = 0
    held: str = ""
    before: Procedure | None = None
    identity: str | None = None
    daemon: RunningDaemon | None = None


@dataclass(frozen=True)
class Aim:
    """The newest target of a live job.

    Parameters
    ----------
    job
        Number of the job.
    target
        Where it is, mm, and how it is turned.
    """

    job: int
    target: Pose


@dataclass(frozen=True)
class Cancel:
    """A job that is not wanted any more.

    Parameters
    ----------
    job
        Number of the job.
    """

    job: int


WorkerRequest = Ask | Aim | Cancel
