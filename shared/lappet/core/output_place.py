"""Whether a file can be written, before the work that is to go into it."""

from __future__ import annotations

import tempfile
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


def check_place(target: Path) -> None:
    """Refuse a place where no file can be written.

    Parameters
    ----------
    target
        The file to write.

    Raises
    ------
    RefusedError
        If its folder is not there or cannot be written, or a folder has its name.
    """
    folder = target.absolute().parent
    if not folder.is_dir():
        raise refused(ProblemCode.EXPORT_FOLDER, target, folder)
    if target.is_dir() and target.suffix:
        raise refused(ProblemCode.EXPORT_PLACE, target, folder)
    try:
        with tempfile.TemporaryFile(prefix=".lappet-", dir=folder):  # rights alone do not tell: /proc, a full disk
            pass
    except OSError as error:
        raise refused(ProblemCode.EXPORT_PLACE, target, folder) from error
