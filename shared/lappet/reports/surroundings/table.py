"""What the tissue beyond the rim would change, as a table for people."""

from __future__ import annotations

from collections.abc import Sequence

from lappet.bench.tables import markdown_table
from lappet.reports.surroundings.measurement import SurroundingsRow

_COLUMNS = [
    "operation", "model", "scar with the rim free, mm", "its root mean square", "force held, mN", "free",
    "reach", "scar of the wider cut-out, mm", "its root mean square", "force", "within the bound",
]  # fmt: skip


def surroundings_table(rows: Sequence[SurroundingsRow]) -> str:
    """Write rows as a table.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    str
        The table in Markdown.
    """
    return markdown_table(_COLUMNS, [_cells(row) for row in rows])


def _cells(row: SurroundingsRow) -> list[str]:
    asked = row.reach is not None
    return [
        row.name.replace("_", " "),
        row.model,
        _number(row.free_mm, 2, asked=True),
        _number(row.free_rms_mm, 2, asked=True),
        _number(row.held_mn, 0, asked=True),
        _number(row.free_mn, 0, asked=True),
        "" if row.reach is None else f"{row.reach:g}",
        _number(row.wider_mm, 2, asked=asked),
        _number(row.wider_rms_mm, 2, asked=asked),
        _number(row.wider_mn, 0, asked=asked),
        {None: "", True: "yes", False: "no"}[row.bounded],
    ]


def _number(value: float | None, digits: int, *, asked: bool) -> str:
    return f"{value:.{digits}f}" if value is not None else "not solved" if asked else ""
