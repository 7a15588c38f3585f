"""What a solve leaves: skin cache, report, pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.output.render import render_cache
    from lappet.output.report import write_report
    from lappet.output.skin_cache import write_skin_cache
    from lappet.output.solve_to_cache import SolveResult, solve_procedure

__all__ = ["SolveResult", "render_cache", "solve_procedure", "write_report", "write_skin_cache"]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "render": ("render_cache",),
        "report": ("write_report",),
        "skin_cache": ("write_skin_cache",),
        "solve_to_cache": ("SolveResult", "solve_procedure"),
    },
)
