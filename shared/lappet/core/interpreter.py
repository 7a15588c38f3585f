"""The Python that runs child processes: this process's own, or the one that comes with the program that embeds it."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


def find_python() -> Path:
    """Find the Python interpreter that runs child processes.

    Returns
    -------
    Path
        The program.

    Raises
    ------
    RefusedError
        If there is none; the message says where it was looked for.
    """
    if sys.executable and Path(sys.executable).stem.lower().startswith("python"):
        return Path(sys.executable)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    places = []
    for prefix in dict.fromkeys((sys.prefix, sys.exec_prefix, sys.base_prefix)):
        for name in (version, "python3", "python"):
            places += [Path(prefix) / "bin" / name, Path(prefix) / "bin" / f"{name}.exe", Path(prefix) / f"{name}.exe"]
    for place in places:
        if place.is_file() and os.access(place, os.X_OK):
            return place
    raise refused(ProblemCode.BACKGROUND_NO_PYTHON, sys.prefix, version, prefix=sys.prefix)


def child_environment(environment: Mapping[str, str], path: Sequence[str], solverd: Path | None) -> dict[str, str]:
    """Make the variables of a child process: none that change Python but the search path.

    Parameters
    ----------
    environment
        Variables of this process.
    path
        Folders to import from; that of this very package is added.
    solverd
        The daemon's program, or None.

    Returns
    -------
    dict[str, str]
        The variables.
    """
    own = str(Path(__file__).resolve().parents[2])
    clean = {name: value for name, value in environment.items() if not name.upper().startswith("PYTHON")}
    clean["PYTHONPATH"] = os.pathsep.join(dict.fromkeys([*map(str, path), own]))
    if solverd is not None:
        clean["LAPPET_SOLVERD"] = str(solverd)
    return clean
