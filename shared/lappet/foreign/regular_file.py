"""Files that are safe to open: regular ones of a known kind, no larger than is allowed."""

from __future__ import annotations

import stat
from collections.abc import Sequence
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits


def refuse_kind(file: Path, suffixes: Sequence[str]) -> None:
    """Refuse a file whose name says that it is of another kind.

    Parameters
    ----------
    file
        The file; it is not looked at.
    suffixes
        Suffixes that are read, in lower case with their dots.

    Raises
    ------
    RefusedError
        If it has none of the suffixes.
    """
    if file.suffix.lower() not in suffixes:
        raise refused(ProblemCode.READ_KIND, file, file.suffix, known=", ".join(suffixes))


def refuse_irregular(file: Path, limits: ReadLimits) -> None:
    """Refuse what is no regular file (a pipe, a device, a socket), or a larger one than is allowed; nothing is opened.

    Parameters
    ----------
    file
        The file; it may be named by a link.
    limits
        What reading may take.

    Raises
    ------
    RefusedError
        If it is no regular file, or too large.
    OSError
        If it is not there, or the file system refuses.
    """
    found = file.stat()
    if not stat.S_ISREG(found.st_mode):
        raise refused(ProblemCode.READ_NOT_REGULAR, file, stat.filemode(found.st_mode)[0])
    if found.st_size > limits.size:
        raise refused(ProblemCode.READ_SIZE, file, f"{found.st_size / 2**20:.1f}", limit=f"{limits.size / 2**20:g}")
