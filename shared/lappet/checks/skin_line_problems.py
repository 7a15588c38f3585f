"""What is wrong with the lines of the skin."""

from __future__ import annotations

from lappet.checks.material_problems import LEAST_PRESTRETCH, MOST_PRESTRETCH
from lappet.core.problem import Problem, RefusedError, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.curve import sample_curve
from lappet.procedure import Material, Procedure, SkinLine
from lappet.procedure.prim_paths import SKIN_LINES
from lappet.tissue.skin_lines import STEP, line_stretch


def skin_line_problems(procedure: Procedure) -> list[Problem]:
    """Find every problem of a procedure's skin lines but for their names.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    list[Problem]
        The problems.
    """
    problems: list[Problem] = []
    materials = {material.name: material for material in procedure.materials}
    skin = materials.get(procedure.tissue.material)
    for line in procedure.skin_lines:
        path = f"{SKIN_LINES}/{line.name}"
        try:
            sample_curve(line.points, line.basis, False, STEP, path)
        except RefusedError as error:
            problems += error.problems
        if skin is not None and line.tension is not None and not _has_stretch(line, skin):
            shown = "(" + ", ".join(f"{value:g}" for value in line.tension) + ")"
            problems.append(problem(ProblemCode.SKIN_LINE_TENSION, path, shown, material=skin.name))
    return problems


def _has_stretch(line: SkinLine, skin: Material) -> bool:
    """Whether the skin's law has a state of the line's tension that the solver takes."""
    try:
        return all(LEAST_PRESTRETCH <= value <= MOST_PRESTRETCH for value in line_stretch(line, skin))
    except ArithmeticError:  # no such state, or numbers that the law cannot be worked out for
        return False
