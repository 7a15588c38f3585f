"""What is to be known of solved frames besides themselves; kept in the store, for when they are found there again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from lappet.core.digest import digest
from lappet.core.problem import Problem
from lappet.procedure import Procedure, Suture
from lappet.solve.error_estimate import FrameErrorEstimate


@dataclass(frozen=True)
class Assessment:
    """What is to be known of solved frames.

    Parameters
    ----------
    notes
        What was done otherwise than told, which frames are not to be trusted, and which sutures may cut through.
    errors
        Estimated error of each frame, None where there is none; empty where none was wanted.
    """

    notes: tuple[Problem, ...] = ()
    errors: tuple[FrameErrorEstimate | None, ...] = ()


def assessment_key(keys: Sequence[str], estimated: bool, procedure: Procedure) -> str:
    """Return the key of an assessment in the store.

    Parameters
    ----------
    keys
        Keys of the frames, at least one.
    estimated
        Whether errors were wanted.
    procedure
        Their procedure. The frames' keys do not tell what its sutures are called and hold at most.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    sutures = [event for event in procedure.events if isinstance(event, Suture)]
    return digest("assessment", keys[-1], len(keys), estimated, sutures).hex()
