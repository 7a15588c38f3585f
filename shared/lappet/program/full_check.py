"""What `lappet check` looks for: what would keep a procedure from being solved, and what is suspicious in it."""

from __future__ import annotations

import os

from lappet.checks.validation import check_file
from lappet.core.problem import Problem, RefusedError
from lappet.program.compile import compile_program
from lappet.usd.stage import read_procedure


def full_check(path: str | os.PathLike[str], notes: list[Problem] | None = None) -> list[Problem]:
    """Find everything that is wrong or suspicious; without errors the cuts are made and compiled too.

    Parameters
    ----------
    path
        The procedure's file.
    notes
        Gets the notes: what was converted while reading, and what is done otherwise than the procedure says.

    Returns
    -------
    list[Problem]
        The errors and warnings.

    Raises
    ------
    RefusedError
        If the file cannot be opened as USD.
    ValueError
        If an error arises that is no refusal.
    """
    told: list[Problem] = []
    told += check_file(path, told)
    if not any(each.severity == "error" for each in told):
        try:
            told += compile_program(read_procedure(path)).notes
        except RefusedError as error:
            told += error.problems
    if notes is not None:
        notes += [each for each in told if each.severity == "note"]
    return [each for each in told if each.severity != "note"]
