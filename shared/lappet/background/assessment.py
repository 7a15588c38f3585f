"""What is to be known of solved frames besides themselves; kept in the store, for when they are found there again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lappet.core.digest import digest
from lappet.core.problem import Problem
from lappet.procedure import Hook, Procedure, Suture, SutureRun
from lappet.solve.error_estimate import FrameErrorEstimate
from lappet.solve.measures import FrameMeasures


@dataclass(frozen=True)
class Pull:
    """What a suture or a hook pulls with in one frame.

    Parameters
    ----------
    event
        Its name.
    force_mn
        Its force in mN, of a thread its tension.
    error_mn
        Estimated error of the force in mN, or None where there is none.
    resolved
        Whether the lattice parts its ends; the force is meaningless where it does not.
    """

    event: str
    force_mn: float
    error_mn: float | None
    resolved: bool = True


@dataclass(frozen=True)
class Assessment:
    """What is to be known of solved frames.

    Parameters
    ----------
    notes
        What was done otherwise than told, which frames are not to be trusted, and which sutures may cut through.
    errors
        Estimated error of each frame, None where there is none; empty where none was wanted.
    pulls
        What pulls in each frame.
    """

    notes: tuple[Problem, ...] = ()
    errors: tuple[FrameErrorEstimate | None, ...] = ()
    pulls: tuple[tuple[Pull, ...], ...] = ()


def pulls_of(measures: FrameMeasures) -> tuple[Pull, ...]:
    """List what pulls in a frame.

    Parameters
    ----------
    measures
        What is measured at the frame.

    Returns
    -------
    tuple[Pull, ...]
        The sutures that are placed and the hooks that act.
    """
    sutures = [Pull(row.suture, row.force_mn, row.force_error_mn, row.resolved) for row in measures.sutures]
    return (*sutures, *(Pull(row.hook, row.force_mn, row.force_error_mn) for row in measures.hooks))


def assessment_key(keys: Sequence[str], estimated: bool, procedure: Procedure) -> str:
    """Return the key of an assessment in the store.

    Parameters
    ----------
    keys
        Keys of the frames, at least one.
    estimated
        Whether errors were wanted.
    procedure
        Their procedure. The frames' keys do not tell what its sutures and hooks are called and what they hold at most.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    pulling = [event for event in procedure.events if isinstance(event, Suture | SutureRun | Hook)]
    return digest("assessment", keys[-1], len(keys), estimated, pulling).hex()
