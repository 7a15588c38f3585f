"""What `lappet check` looks for: everything that would keep a procedure from being solved."""

from __future__ import annotations

import os

from lappet.checks.validation import check_file
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.program.compile import compile_program
from lappet.usd.stage import read_procedure


def full_check(path: str | os.PathLike[str], notes: list[str] | None = None) -> list[Problem]:
    """Every problem of a procedure file; where there is no error, the cuts are made and the program is compiled too.

    notes: gets a sentence for everything that was converted while reading, or that the solve leaves out. Raises
    RefusedError only where the file cannot be opened as USD.
    """
    notes = [] if notes is None else notes
    problems = check_file(path, notes)
    if any(problem.severity == "error" for problem in problems):
        return problems
    try:
        notes += compile_program(read_procedure(path)).notes
    except ValueError as error:
        if type(error).__module__.partition(".")[0] != "lappet":
            raise
        prim, _, sentence = str(error).partition(": ")
        if not prim.startswith("/"):
            prim, sentence = str(path), str(error)
        # The sentence of what is refused already ends with its remedy.
        problems.append(Problem(ProblemCode.UNSORTED, prim, "", sentence, ""))
    return problems
