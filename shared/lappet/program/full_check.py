"""What `lappet check` looks for: what would keep a procedure from being solved, and what is suspicious in it."""

from __future__ import annotations

import os

from lappet.checks.validation import check_read
from lappet.core.problem import Problem, RefusedError
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.program.compile import compile_program
from lappet.usd.procedure_file import ProcedureFile


def full_check(
    path: str | os.PathLike[str], notes: list[Problem] | None = None, limits: ReadLimits = DEFAULT_LIMITS
) -> list[Problem]:
    """Find everything that is wrong or suspicious; without errors the cuts are made and compiled too.

    Parameters
    ----------
    path
        The procedure's file.
    notes
        Gets the notes: what was converted while reading, and what is done otherwise than the procedure says.
    limits
        What reading may take.

    Returns
    -------
    list[Problem]
        The errors and warnings.

    Raises
    ------
    RefusedError
        If the file cannot be opened as USD, or takes more than it may.
    ValueError
        If an error arises that is no refusal.
    """
    told: list[Problem] = []
    with ProcedureFile(path, limits) as file:
        read = file.what_can_be(told)
    told += check_read(read)
    if read.procedure is not None and not any(each.severity == "error" for each in told):
        try:
            told += compile_program(read.procedure).notes
        except RefusedError as error:
            told += error.problems
    if notes is not None:
        notes += [each for each in told if each.severity == "note"]
    return [each for each in told if each.severity != "note"]
