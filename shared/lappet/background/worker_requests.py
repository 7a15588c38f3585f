"""What the owner asks of the worker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lappet.procedure import Point, Procedure
from lappet.program.settings import SolverSettings

JobKind = Literal["plan", "solve", "live"]


@dataclass(frozen=True, eq=False)
class Ask:
    """A job. until: last frame to solve. time, hook: of live mode. identity: of the solver, where its owner knows."""

    job: int
    kind: JobKind
    procedure: Procedure
    settings: SolverSettings
    until: int | None = None
    time: int = 0
    hook: str = ""
    identity: str | None = None


@dataclass(frozen=True)
class Aim:
    """The newest target of a live job, mm."""

    job: int
    target: Point


@dataclass(frozen=True)
class Cancel:
    """A job is not wanted any more."""

    job: int


WorkerRequest = Ask | Aim | Cancel
