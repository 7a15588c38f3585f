"""The Python that runs the worker: this process's own, or the one that comes with the program that embeds it."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from lappet.core.problem import RefusedError


def find_python() -> Path:
    """The interpreter's program. Raises RefusedError, saying where it looked."""
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
    raise RefusedError(
        f"There is no Python to solve in the background with; looked for {version} under {sys.prefix}. "
        "Install Blender again from blender.org."
    )


def worker_environment(environment: Mapping[str, str], path: Sequence[str], solverd: Path | None) -> dict[str, str]:
    """The variables of the worker's process: none that change Python but the search path.

    path: folders to import from; that of this very package is added.
    """
    own = str(Path(__file__).resolve().parents[2])
    clean = {name: value for name, value in environment.items() if not name.upper().startswith("PYTHON")}
    clean["PYTHONPATH"] = os.pathsep.join(dict.fromkeys([*map(str, path), own]))
    if solverd is not None:
        clean["LAPPET_SOLVERD"] = str(solverd)
    return clean
