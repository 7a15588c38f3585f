"""What is wrong with the scene of a procedure, and the operator that repairs it."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.core.problem import Problem, Severity
from lappet.core.problem_code import ProblemCode


@dataclass(frozen=True)
class SceneProblem(Problem):
    """A `lappet.core.problem.Problem` found in a Blender scene; `prim` is the name of the object or event.

    operator: the bl_idname of the operator that repairs it, called with `arguments`; "" where nothing can.
    """

    operator: str = ""
    arguments: tuple[tuple[str, str | int | float], ...] = ()


def problem(
    path: str,
    value: object,
    sentence: str,
    remedy: str,
    operator: str = "",
    severity: Severity = "error",
    **arguments: str | int | float,
) -> SceneProblem:
    """A `SceneProblem` in one line. sentence and remedy may be halves of one; each becomes a sentence."""
    what, then = _ended(sentence), _ended(remedy[:1].upper() + remedy[1:])
    return SceneProblem(
        ProblemCode.UNSORTED, path, str(value), what, then, severity, None, operator, tuple(arguments.items())
    )


def _ended(words: str) -> str:
    return words if not words or words.endswith((".", "?", "!")) else f"{words}."
