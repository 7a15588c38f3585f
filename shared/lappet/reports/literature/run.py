"""Solve the operations of the literature's rows and compare what they give with what was published."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lappet.bench.tables import markdown_table
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.library_operation import SPACING
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.reports.literature.measured import Measured
from lappet.reports.literature.operations import OPERATIONS
from lappet.reports.literature.published import Published, Verdict
from lappet.reports.literature.rows import ROWS
from lappet.reports.report_files import head, make_folder, write_csv, write_json
from lappet.reports.report_progress import ReportProgress

RESULTS = "literature.json"


@dataclass(frozen=True)
class Compared:
    """A published number and the program's.

    Parameters
    ----------
    name
        Name of the row.
    value
        What the program gives; None where an operation was not solved to its end.
    error
        Its estimated error; None without one.
    verdict
        Whether they agree.
    """

    name: str
    value: float | None
    error: float | None
    verdict: str


def chosen_rows(names: Sequence[str]) -> tuple[Published, ...]:
    """Choose rows.

    Parameters
    ----------
    names
        Their names; none for all of them.

    Returns
    -------
    tuple[Published, ...]
        The rows, in the order of the report.

    Raises
    ------
    RefusedError
        If there is no row of a name.
    """
    known = {row.name for row in ROWS}
    for name in names:
        if name not in known:
            raise refused(ProblemCode.REPORT_UNKNOWN, "", name, what="row", known=", ".join(row.name for row in ROWS))
    return tuple(row for row in ROWS if not names or row.name in names)


def run_literature(
    names: Sequence[str], folder: Path, progress: ReportProgress, *, spacing: float = SPACING
) -> tuple[str, list[Path]]:
    """Solve what the rows need, compare, and write the results.

    Parameters
    ----------
    names
        Names of rows; none for all of them.
    folder
        Where to; made if needed. Known frames are looked up, so that a stopped run goes on.
    progress
        Is told how the solves go, with a line of text for every operation.
    spacing
        Edge of the lattice's cells in mm.

    Returns
    -------
    tuple[str, list[Path]]
        The table as text, and the files that were written.

    Raises
    ------
    RefusedError
        If there is no row of a name, or an operation is refused.
    """
    rows = chosen_rows(names)
    make_folder(folder)
    solved: dict[str, SolveResult] = {}
    operations = dict.fromkeys(name for row in rows for name in row.measure.operations)
    progress.begin(len(operations))
    for name in operations:
        result = solve_procedure(OPERATIONS[name](spacing), folder / f"{name}.usdc", observer=progress.solve(name))
        converged = sum(frame.solved.converged for frame in result.frames)
        progress.say(f"{name}: {converged} of {len(list(result.procedure.frames()))} frames converged.")
        if result.complete:
            solved[name] = result
    compared = [compare(row, solved) for row in rows]
    results, table = folder / RESULTS, folder / "literature.csv"
    write_json(results, head(), compared, spacing_mm=spacing)
    write_csv(table, compared)
    text = markdown_table(
        ["row", "published", "here", ""],
        [
            [row.name, row.range_text, value_text(each.value, each.error, row.unit), each.verdict]
            for row, each in zip(rows, compared, strict=True)
        ],
    )
    return text, [results, table]


def compare(row: Published, solved: dict[str, SolveResult]) -> Compared:
    """Measure a row at solved operations and compare.

    Parameters
    ----------
    row
        The row.
    solved
        Solves by the names of their operations; those that ended early are left out.

    Returns
    -------
    Compared
        What the program gives, and whether it agrees.
    """
    if not all(name in solved for name in row.measure.operations):
        return Compared(row.name, None, None, Verdict.NOT_SOLVED.value)
    found: Measured = row.measure.of(*(solved[name] for name in row.measure.operations))
    return Compared(row.name, found.value, found.error, row.verdict(found.value, found.error).value)


def value_text(value: float | None, error: float | None, unit: str) -> str:
    """Write a number with its error.

    Parameters
    ----------
    value
        The number; None for none.
    error
        Its error; None without one.
    unit
        Its unit; empty for a ratio.

    Returns
    -------
    str
        Text, empty for none.
    """
    if value is None:
        return ""
    return (f"{value:.3g}" if error is None else f"{value:.3g} ± {float(f'{error:.1g}'):g}") + (
        f" {unit}" if unit else ""
    )
