"""A procedure's file that a child process reads. Light, so that the child starts before all else is loaded."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Self

from lappet.core.problem import Problem, RefusedError
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess

if TYPE_CHECKING:
    from lappet.procedure import Procedure
    from lappet.usd.stage_procedure import StageProcedure

CHILD = "lappet.usd.child"


class ProcedureFile:
    """A procedure's file, which is read once, from now on.

    Parameters
    ----------
    path
        A .usda, .usdc or .usd file.
    limits
        What reading may take.

    Raises
    ------
    RefusedError
        If the process that reads cannot be started.
    """

    def __init__(self, path: str | os.PathLike[str], limits: ReadLimits = DEFAULT_LIMITS) -> None:
        self.path = Path(path)
        self._process = ReadingProcess(CHILD, "procedure", self.path, limits)
        self._read: StageProcedure | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.close()

    def procedure(self, notes: list[Problem] | None = None) -> Procedure:
        """Wait for the procedure.

        Parameters
        ----------
        notes
            Gets a note of everything that was converted or left aside.

        Returns
        -------
        Procedure
            The procedure.

        Raises
        ------
        RefusedError
            If something kept the file from being read; holds every such problem.
        """
        read = self.what_can_be(notes)
        if read.procedure is None or read.problems:
            raise RefusedError(read.problems)
        return read.procedure

    def what_can_be(self, notes: list[Problem] | None = None) -> StageProcedure:
        """Wait for what can be read.

        Parameters
        ----------
        notes
            Gets a note of everything that was converted or left aside.

        Returns
        -------
        StageProcedure
            What was read.

        Raises
        ------
        RefusedError
            If the file cannot be opened, or takes more than it may.
        """
        if self._read is None:
            from lappet.usd.stage_procedure import StageProcedure  # not before the child runs

            self._read = self._process.result(StageProcedure)
        if notes is not None:
            notes += self._read.notes
        return self._read
