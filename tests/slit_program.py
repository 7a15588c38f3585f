"""Programs of the slit patch with other events."""

from __future__ import annotations

from typing import Any

from lappet.procedure import Event
from lappet.program.compile import compile_program
from lappet.program.program import Program
from small_procedure import small_procedure


def compiled(program: Program, *events: Event, **changes: Any) -> Program:
    """The program of the slit patch with these events added to the slit alone."""
    slit = small_procedure().event("slit")
    return compile_program(small_procedure(events=(slit, *events), **changes), program.epochs)
