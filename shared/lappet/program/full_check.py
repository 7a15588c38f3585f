"""What `lappet check` looks for: everything that would keep a procedure from being solved."""

from __future__ import annotations

import os

from lappet.checks.validation import check_file
from lappet.core.problem import Problem, RefusedError
from lappet.program.compile import compile_program
from lappet.usd.stage import read_procedure


def full_check(path: str | os.PathLike[str], notes: list[Problem] | None = None) -> list[Problem]:
    """Find everything that would keep a procedure from being solved; without errors the cuts are made and compiled too.

    Parameters
    ----------
    path
        The procedure's file.
    notes
        Gets a note of everything that was converted while reading, or that the solve leaves out.

    Returns
    -------
    list[Problem]
        The problems.

    Raises
    ------
    RefusedError
        If the file cannot be opened as USD.
    ValueError
        If an error arises that is no refusal.
    """
    notes = [] if notes is None else notes
    problems = check_file(path, notes)
    if any(each.severity == "error" for each in problems):
        return problems
    try:
        notes += compile_program(read_procedure(path)).notes
    except RefusedError as error:
        problems += error.problems
    return problems
