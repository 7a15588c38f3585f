"""Write the report of stability: stability.json, .csv and .md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.reports.report_files import described, markdown_table, write_csv, write_json
from lappet.reports.stability.case import Row, totals

COLUMNS = ("cases", "ok", "converged", "buckled", "refused")


def write_stability(folder: Path, head: Mapping[str, Any], rows: Sequence[Row]) -> list[Path]:
    """Write the files of the report.

    Parameters
    ----------
    folder
        A folder that is there.
    head
        What each starts with.
    rows
        What became of the cases.

    Returns
    -------
    list[Path]
        The files.
    """
    files = [folder / f"stability.{suffix}" for suffix in ("json", "csv", "md")]
    write_json(files[0], head, rows, totals=totals(rows))
    write_csv(files[1], rows)
    write_whole(files[2], markdown(head, rows).encode())
    return files


def totals_table(rows: Sequence[Row]) -> str:
    """Write the groups' totals.

    Parameters
    ----------
    rows
        What became of the cases.

    Returns
    -------
    str
        A table of Markdown.
    """
    return markdown_table(
        ["group", "cases", "as demanded", "converged", "of these buckled", "refused with the reason"],
        [[group, *(t[name] for name in COLUMNS)] for group, t in totals(rows).items()],
    )


def markdown(head: Mapping[str, Any], rows: Sequence[Row]) -> str:
    """Write the report for people.

    Parameters
    ----------
    head
        What it starts with.
    rows
        What became of the cases.

    Returns
    -------
    str
        Markdown.
    """
    failures = [row for row in rows if not row.ok]
    parts = ["# Stability\n", described(head) + "\n", totals_table(rows)]
    if failures:
        parts.append("## Not as demanded\n")
        parts.append("\n".join(f"- **{row.case}**: {row.outcome}. {row.reason}" for row in failures) + "\n")
    parts.append("## Cases\n")
    parts.append(
        markdown_table(
            ["case", "demanded", "outcome", "residual", "gap mm", "stiffness left", "cells", "seconds", "ok"],
            [
                [
                    f"{row.group}: {row.case}",
                    row.expected,
                    row.outcome,
                    "" if row.residual is None else row.residual,
                    "" if row.gap_mm is None else row.gap_mm,
                    "" if row.lowest_stiffness is None else row.lowest_stiffness,
                    row.cells,
                    row.seconds,
                    "yes" if row.ok else "NO",
                ]
                for row in rows
            ],
        )
    )
    return "\n".join(parts)
