"""Run the stability matrix: which cases there are, and the files of their report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.reports.report_files import head, make_folder, write_json
from lappet.reports.stability.buckling_cases import buckling_cases
from lappet.reports.stability.case import Case
from lappet.reports.stability.constraint_cases import constraint_cases
from lappet.reports.stability.cut_cases import cut_cases
from lappet.reports.stability.deformation_cases import deformation_cases
from lappet.reports.stability.files import totals_table, write_stability
from lappet.reports.stability.material_cases import material_cases
from lappet.reports.stability.measurement import run_cases
from lappet.reports.stability.shape_cases import shape_cases


def all_cases() -> list[Case]:
    """List the matrix.

    Returns
    -------
    list[Case]
        The cases.
    """
    return [
        *material_cases(),
        *deformation_cases(),
        *buckling_cases(),
        *constraint_cases(),
        *shape_cases(),
        *cut_cases(),
    ]


def chosen_cases(only: Sequence[str], quick: bool) -> list[Case]:
    """Choose cases by their groups.

    Parameters
    ----------
    only
        Names of groups; all where none is named.
    quick
        Whether to leave out the slow ones.

    Returns
    -------
    list[Case]
        The cases.

    Raises
    ------
    RefusedError
        If a name is no group.
    """
    cases = all_cases()
    groups = list(dict.fromkeys(case.group for case in cases))
    for name in only:
        if name not in groups:
            raise refused(ProblemCode.REPORT_UNKNOWN, "", name, what="group of cases", known=", ".join(groups))
    return [case for case in cases if (not only or case.group in only) and not (quick and case.slow)]


def run_stability(
    folder: Path, cases: Sequence[Case], say: Callable[[str], None] = lambda _: None
) -> tuple[str, bool, list[Path]]:
    """Run cases and write the files.

    Parameters
    ----------
    folder
        Folder of the files.
    cases
        The cases.
    say
        Is told of every case.

    Returns
    -------
    tuple[str, bool, list[Path]]
        The table of totals, whether every case is ok, and the files.

    Raises
    ------
    RefusedError
        If there is no daemon or no folder.
    """
    make_folder(folder)
    circumstances = head()
    rows = list(run_cases(cases, say))
    return totals_table(rows), all(row.ok for row in rows), write_stability(folder, circumstances, rows)


def run_fuzz(
    folder: Path, count: int, say: Callable[[str], None] = lambda _: None, jobs: int | None = None
) -> tuple[str, bool, list[Path]]:
    """Fuzz procedures and write stability_fuzz.json.

    Parameters
    ----------
    folder
        Folder of the file.
    count
        Number of procedures.
    say
        Is told how it goes.
    jobs
        How many at once; one per core when None.

    Returns
    -------
    tuple[str, bool, list[Path]]
        A sentence, whether all hold the property, and the file.

    Raises
    ------
    RefusedError
        If there is no daemon, no folder or no hypothesis.
    """
    from lappet.reports.stability.fuzz import fuzz

    make_folder(folder)
    circumstances = head()
    found = fuzz(count, say, jobs)
    file = folder / "stability_fuzz.json"
    write_json(file, circumstances, [], **found)
    failures = len(found["failures"])
    return (
        f"{found['procedures']} procedures: {found['solved']} solved to the end, "
        f"{sum(found['refused'].values())} refused with a reason, {failures} failures.",
        not failures,
        [file],
    )
