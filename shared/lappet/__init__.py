"""Lappet: plan a skin-flap operation as a timeline in USD, solve the tissue's response, render figures of it.

The names below are loaded when they are first used, so that `import lappet` costs nothing and works without USD.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lappet.core.lazy_exports import lazy_exports
from lappet.core.version import version

if TYPE_CHECKING:
    from lappet.checks.validation import check
    from lappet.core.problem import Problem, RefusedError
    from lappet.foreign.limits import ReadLimits
    from lappet.output.solve_to_cache import SolveResult, solve_procedure
    from lappet.procedure import (
        Bone,
        Excision,
        Hook,
        Incision,
        Landmark,
        Material,
        Plate,
        PlateAnnotation,
        PlatePanel,
        Pressure,
        Procedure,
        Region,
        Retractor,
        Roller,
        Section,
        Suture,
        SutureLayer,
        SutureRun,
        Tissue,
        Traction,
        Undermine,
        Vessel,
    )
    from lappet.procedure.history import History
    from lappet.program.settings import SolverSettings
    from lappet.solve.store import FrameStore
    from lappet.usd.stage import read_procedure, write_procedure

_HOMES = {
    "checks.validation": ("check",),
    "core.problem": ("Problem", "RefusedError"),
    "foreign.limits": ("ReadLimits",),
    "output.solve_to_cache": ("SolveResult", "solve_procedure"),
    "procedure": (
        "Bone",
        "Excision",
        "Hook",
        "Incision",
        "Landmark",
        "Material",
        "Plate",
        "PlateAnnotation",
        "PlatePanel",
        "Pressure",
        "Procedure",
        "Region",
        "Retractor",
        "Roller",
        "Section",
        "Suture",
        "SutureLayer",
        "SutureRun",
        "Tissue",
        "Thin",
        "Traction",
        "Undermine",
        "Vessel",
    ),
    "procedure.history": ("History",),
    "program.settings": ("SolverSettings",),
    "solve.store": ("FrameStore",),
    "usd.stage": ("read_procedure", "write_procedure"),
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
    "Plate",
    "PlateAnnotation",
    "PlatePanel",
    "Pressure",
    "Problem",
    "Procedure",
    "ReadLimits",
    "RefusedError",
    "Region",
    "Retractor",
    "Roller",
    "Section",
    "SolveResult",
    "SolverSettings",
    "Suture",
    "SutureLayer",
    "SutureRun",
    "Thin",
    "Tissue",
    "Traction",
    "Undermine",
    "Vessel",
    "__version__",
    "check",
    "read_procedure",
    "solve_procedure",
    "write_procedure",
]


_load, __dir__ = lazy_exports(__name__, _HOMES)


def __getattr__(name: str) -> Any:
    return version() if name == "__version__" else _load(name)
