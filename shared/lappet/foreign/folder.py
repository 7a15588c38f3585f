"""The folder beyond which a file may not refer."""

from __future__ import annotations

import os
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits


class Folder:
    """The folder of the file that is read, in which everything lies that it may refer to.

    Parameters
    ----------
    file
        The file.
    limits
        Say whether it may refer to files outside.
    """

    def __init__(self, file: Path, limits: ReadLimits) -> None:
        self._file, self._open = file, limits.allow_external
        self._folder = Path(os.path.realpath(file)).parent

    def refuse_outside(self, path: Path, named: str) -> None:
        """Refuse a path outside the folder, with the same words whether there is a file or not.

        Parameters
        ----------
        path
            What the file refers to.
        named
            How it is named there.

        Raises
        ------
        RefusedError
            If it lies outside and that is not allowed.
        """
        if not self._open and not self._holds(path):
            raise refused(ProblemCode.READ_OUTSIDE, self._file, named, folder=self._folder)

    def _holds(self, path: Path) -> bool:
        """Whether the path lies inside: links are looked up only where it does as it is written."""
        if not Path(os.path.normpath(self._folder / path)).is_relative_to(self._folder):
            return False
        return Path(os.path.realpath(self._folder / path)).is_relative_to(self._folder)
