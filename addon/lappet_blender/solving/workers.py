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

# What the worker imports; the folders they lie in go on its path, wherever Blender put them.
_PACKAGES = ("lappet", "numpy", "zmq", "msgpack", "manifold3d", "platformdirs")
_free: list[tuple[Path, BackgroundSolver]] = []
_lent: list[tuple[Path, BackgroundSolver]] = []


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


def _start(store: Path) -> BackgroundSolver:
    from lappet.background.solver import BackgroundSolver

    return BackgroundSolver(store=store, path=import_folders())


create: Callable[[Path], BackgroundSolver] = _start


def borrow(store: Path) -> BackgroundSolver:
    """A solver whose frames go to the folder `store`; nobody else has it until it is given back."""
    for each in _free:
        if each[0] == store:
            _free.remove(each)
            _lent.append(each)
            return each[1]
    solver = create(store)
    _lent.append((store, solver))
    return solver


def give_back(solver: BackgroundSolver) -> None:
    """Take a solver back; its jobs must have been cancelled. One free solver is kept, others are closed."""
    for each in [each for each in _lent if each[1] is solver]:
        _lent.remove(each)
        if _free:
            each[1].close()
        else:
            _free.append(each)


def close_all() -> None:
    """End every worker."""
    for _, solver in [*_lent, *_free]:
        with contextlib.suppress(Exception):
            solver.close()
    _lent.clear()
    _free.clear()


atexit.register(close_all)
