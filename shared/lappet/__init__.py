"""Lappet: plan a skin-flap operation as a timeline in USD, solve the tissue's response, render figures of it.

The names below are loaded when they are first used, so that `import lappet` costs nothing and works without USD.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lappet.checks.validation import check
    from lappet.core.problem import Problem, RefusedError
    from lappet.output.solve_procedure import SolveResult, solve_procedure
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
    from lappet.procedure.history import History
    from lappet.solve.store import FrameStore
    from lappet.usd.stage import read_procedure, write_procedure

_HOMES = {
    "Bone": "procedure",
    "Excision": "procedure",
    "FrameStore": "solve.store",
    "History": "procedure.history",
    "Hook": "procedure",
    "Incision": "procedure",
    "Landmark": "procedure",
    "Material": "procedure",
    "Problem": "core.problem",
    "Procedure": "procedure",
    "RefusedError": "core.problem",
    "Region": "procedure",
    "Retractor": "procedure",
    "SolveResult": "output.solve_procedure",
    "Suture": "procedure",
    "Tissue": "procedure",
    "Undermine": "procedure",
    "check": "checks.validation",
    "read_procedure": "usd.stage",
    "solve_procedure": "output.solve_procedure",
    "write_procedure": "usd.stage",
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
        from lappet.core.version import version

        return version()
    home = _HOMES.get(name)
    if home is None:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(f"{__name__}.{home}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
