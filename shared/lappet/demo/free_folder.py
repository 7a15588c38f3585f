"""Where the demo's files go where the user names no folder."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterable
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

NAME = "lappet-demo"
_MOST = 9


def free_folder(bases: Iterable[Path] | None = None, mark: str = "z_plasty.usda") -> Path:
    """Make a folder for the demo, or find that of an earlier one.

    Parameters
    ----------
    bases
        Folders to make it in, the first that can be written counts; the current one, the user's documents and the
        system's temporary files when None.
    mark
        A file that a folder of an earlier demo has.

    Returns
    -------
    Path
        The folder: `lappet-demo`, or with a number where that is something else.

    Raises
    ------
    RefusedError
        If none of the folders can be written.
    """
    tried = list(_bases() if bases is None else bases)
    for base in tried:
        for number in range(1, _MOST + 1):
            folder = base / (NAME if number == 1 else f"{NAME}-{number}")
            if not folder.exists() and folder.is_symlink():
                continue  # of a folder that is gone
            if folder.exists() and not (folder / mark).is_file() and (not folder.is_dir() or any(folder.iterdir())):
                continue  # somebody else's
            if _writable(folder):
                return folder
            break
    raise refused(ProblemCode.FILE_ERROR, tried[0] / NAME, "no folder can be written")


def _bases() -> list[Path]:
    from platformdirs import user_documents_path

    here = []
    with contextlib.suppress(OSError):  # a shell may stand in a folder that is gone
        here.append(Path.cwd())
    return [*here, user_documents_path(), Path(tempfile.gettempdir())]


def _writable(folder: Path) -> bool:
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder):
            return True
    return False
