"""What a report tells of its solves while they run."""

from __future__ import annotations

from lappet.solve.solve_frames import SolveObserver


class ReportProgress:
    """An observer of a report's solves; this one keeps silent."""

    def begin(self, solves: int) -> None:
        """Hear how many solves are to come.

        Parameters
        ----------
        solves
            Number of solves.
        """

    def solve(self, name: str) -> SolveObserver:
        """Hear that the next solve begins.

        Parameters
        ----------
        name
            What is solved, for people.

        Returns
        -------
        SolveObserver
            Is told how this solve goes.
        """
        return SolveObserver()

    def say(self, line: str) -> None:
        """Hear what came of a solve, or why there is none.

        Parameters
        ----------
        line
            A line of text.
        """
