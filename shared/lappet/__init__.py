"""Lappet: plan a skin-flap operation as a timeline in USD, solve the tissue's response, render figures of it.

The names below are loaded when they are first used, so that `import lappet` costs nothing and works without USD.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lappet.history import History
    from lappet.problem import Problem, ProcedureError
    from lappet.procedure import (
        Bone,
        Excision,
        Hook,
        Incision,
        Landmark,
        Material,
        Procedure,
        Region,
        Retractor,
        Suture,
        Tissue,
        Undermine,
    )
    from lappet.refused import RefusedError
    from lappet.solve import SolveResult, solve_procedure
    from lappet.store import FrameStore
    from lappet.usd_stage import read_procedure, write_procedure
    from lappet.validation import check

_HOMES = {
    "Bone": "procedure",
    "Excision": "procedure",
    "FrameStore": "store",
    "History": "history",
    "Hook": "procedure",
    "Incision": "procedure",
    "Landmark": "procedure",
    "Material": "procedure",
    "Problem": "problem",
    "Procedure": "procedure",
    "ProcedureError": "problem",
    "Region": "procedure",
    "RefusedError": "refused",
    "Retractor": "procedure",
    "SolveResult": "solve",
    "Suture": "procedure",
    "Tissue": "procedure",
    "Undermine": "procedure",
    "check": "validation",
    "read_procedure": "usd_stage",
    "solve_procedure": "solve",
    "write_procedure": "usd_stage",
}

__all__ = [
    "Bone",
    "Excision",
    "FrameStore",
    "History",
    "Hook",
    "Incision",
    "Landmark",
    "Material",
    "Problem",
    "Procedure",
    "ProcedureError",
    "RefusedError",
    "Region",
    "Retractor",
    "SolveResult",
    "Suture",
    "Tissue",
    "Undermine",
    "__version__",
    "check",
    "read_procedure",
    "solve_procedure",
    "write_procedure",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("lappet")
    except PackageNotFoundError:  # a checkout that is not installed
        return "0+unknown"
