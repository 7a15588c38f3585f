"""Background solvers: one for each scene with a job; those that are free again wait for the next scene."""

from __future__ import annotations

import atexit
import contextlib
import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lappet.background.solver import BackgroundSolver
    from lappet.daemon.running_daemon import RunningDaemon

# What the worker imports; the folders they lie in go on its path, wherever Blender put them.
_PACKAGES = ("lappet", "numpy", "zmq", "msgpack", "manifold3d", "platformdirs")
_free: list[tuple[Path, RunningDaemon | None, BackgroundSolver]] = []
_lent: list[tuple[Path, RunningDaemon | None, BackgroundSolver]] = []


def import_folders() -> tuple[str, ...]:
    """The folders that the worker's packages lie in, in order, each once."""
    folders: dict[str, None] = {}
    for name in _PACKAGES:
        with contextlib.suppress(ImportError, ValueError):
            found = importlib.util.find_spec(name)
            for place in (found.submodule_search_locations or ()) if found is not None else ():
                folders[str(Path(place).parent)] = None
            if found is not None and found.origin and not found.submodule_search_locations:
                folders[str(Path(found.origin).parent)] = None
    return tuple(folders)


def _start(store: Path, daemon: RunningDaemon | None) -> BackgroundSolver:
    from lappet.background.solver import BackgroundSolver

    return BackgroundSolver(store=store, path=import_folders(), daemon=daemon)


create: Callable[[Path, RunningDaemon | None], BackgroundSolver] = _start


def borrow(store: Path, daemon: RunningDaemon | None = None) -> BackgroundSolver:
    """A solver whose frames go to the folder `store`; nobody else has it until it is given back.

    daemon: one that runs already; None: the solver starts its own.
    """
    for each in _free:
        if each[:2] == (store, daemon):
            _free.remove(each)
            _lent.append(each)
            return each[2]
    solver = create(store, daemon)
    _lent.append((store, daemon, solver))
    return solver


def give_back(solver: BackgroundSolver) -> None:
    """Take a solver back; its jobs must have been cancelled. One free solver is kept, others are closed."""
    for each in [each for each in _lent if each[2] is solver]:
        _lent.remove(each)
        if _free:
            each[2].close()
        else:
            _free.append(each)


def close_all() -> None:
    """End every worker."""
    for _, _, solver in [*_lent, *_free]:
        with contextlib.suppress(Exception):
            solver.close()
    _lent.clear()
    _free.clear()


atexit.register(close_all)
