"""Write the report of convergence: convergence.json, .csv and .md."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.reports.convergence.measurement import ConvergenceRow
from lappet.reports.report_files import described, markdown_table, write_csv, write_json


def write_convergence(folder: Path, head: Mapping[str, Any], rows: Sequence[ConvergenceRow]) -> list[Path]:
    """Write the files of the report.

    Parameters
    ----------
    folder
        A folder that is there.
    head
        What each starts with.
    rows
        The rows.

    Returns
    -------
    list[Path]
        The files.
    """
    files = [folder / f"convergence.{suffix}" for suffix in ("json", "csv", "md")]
    write_json(files[0], head, rows, totals=totals(rows))
    write_csv(files[1], rows)
    write_whole(files[2], markdown(head, rows).encode())
    return files


def totals(rows: Sequence[ConvergenceRow]) -> dict[str, dict[str, float]]:
    """Sum the rows up by what happens in them.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    dict[str, dict[str, float]]
        For each kind of scene and for all: frames, those that are right, and the largest errors in mm and as a share
        of what is allowed.
    """
    kinds = {kind: [row for row in rows if row.kind == kind] for kind in dict.fromkeys(row.kind for row in rows)}
    return {
        kind: {
            "frames": len(of),
            "ok": sum(row.ok for row in of),
            "error_mm": max(row.error_mm for row in of),
            "share": max(row.error_mm / row.allowed_mm for row in of),
        }
        for kind, of in {**kinds, "all": list(rows)}.items()
        if of
    }


def totals_table(rows: Sequence[ConvergenceRow]) -> str:
    """Write the totals.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    str
        A table of Markdown.
    """
    return markdown_table(
        ["scenes", "frames", "within what is allowed", "largest error mm", "as a share of what is allowed"],
        [[kind, t["frames"], t["ok"], t["error_mm"], t["share"]] for kind, t in totals(rows).items()],
    )


def markdown(head: Mapping[str, Any], rows: Sequence[ConvergenceRow]) -> str:
    """Write the report for people.

    Parameters
    ----------
    head
        What it starts with.
    rows
        The rows.

    Returns
    -------
    str
        Markdown.
    """
    table = markdown_table(
        ["scene", "frame", "moved mm", "error mm", "to come mm", "Newton", "of the exact", "seconds", "ok"],
        [
            [
                row.scene,
                row.frame,
                row.moved_mm,
                row.error_mm,
                row.to_come_mm,
                row.newton,
                row.newton_exact,
                row.seconds,
                "yes" if row.ok else f"NO {row.reason}".strip(),
            ]
            for row in rows
        ],
    )
    return "\n".join(["# Convergence\n", described(head) + "\n", totals_table(rows), "## Frames\n", table])
