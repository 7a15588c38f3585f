"""Runs the stability matrix: which cases there are, and the files of their report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from lappet.reports.report_error import ReportError
from lappet.reports.report_files import head, make_folder
from lappet.reports.stability import Case, Row, run_cases
from lappet.reports.stability_constraint_cases import constraint_cases
from lappet.reports.stability_cut_cases import cut_cases
from lappet.reports.stability_deformation_cases import deformation_cases
from lappet.reports.stability_files import write_stability
from lappet.reports.stability_material_cases import material_cases
from lappet.reports.stability_shape_cases import shape_cases


def all_cases() -> list[Case]:
    """The matrix."""
    return [*material_cases(), *deformation_cases(), *constraint_cases(), *shape_cases(), *cut_cases()]


def chosen_cases(only: Sequence[str], quick: bool) -> list[Case]:
    """The cases of these groups (all where none is named), without the slow ones where it is to be quick. Raises
    ReportError for a name that is none."""
    cases = all_cases()
    groups = list(dict.fromkeys(case.group for case in cases))
    for name in only:
        if name not in groups:
            raise ReportError(f"There is no group {name!r} of cases; there are {', '.join(groups)}.")
    return [case for case in cases if (not only or case.group in only) and not (quick and case.slow)]


def run_stability(
    folder: Path, cases: Sequence[Case], say: Callable[[str], None] = lambda _: None
) -> tuple[list[Row], list[Path]]:
    """Runs the cases and writes the files; returns both. Raises RefusedError where there is no daemon or no folder."""
    make_folder(folder)
    circumstances = head()
    rows = list(run_cases(cases, say))
    return rows, write_stability(folder, circumstances, rows)
