"""Solving a program, the frame store and the estimate of the error."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.solve.error_estimate import estimate_errors
    from lappet.solve.solve_frames import SolveObserver, solve_program
    from lappet.solve.store import FrameStore
    from lappet.solve.target_error import choose

__all__ = ["FrameStore", "SolveObserver", "choose", "estimate_errors", "solve_program"]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "error_estimate": ("estimate_errors",),
        "solve_frames": ("SolveObserver", "solve_program"),
        "store": ("FrameStore",),
        "target_error": ("choose",),
    },
)
