"""What a stage gives: its procedure, and all that was found while it was read."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.core.problem import Problem
from lappet.procedure import Procedure


@dataclass(frozen=True, eq=False)
class StageProcedure:
    """A procedure as far as it could be read.

    Parameters
    ----------
    procedure
        The procedure, or None without a tissue. A value that could not be read is NaN or empty.
    problems
        What kept something from being read.
    notes
        What was converted or left aside.
    """

    procedure: Procedure | None
    problems: tuple[Problem, ...] = ()
    notes: tuple[Problem, ...] = ()
