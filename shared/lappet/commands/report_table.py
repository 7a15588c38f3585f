"""The table that `lappet new` prints: what was found in a mesh, what was repaired and what was taken."""

from __future__ import annotations

from lappet.core.printable import printable
from lappet.tissue.mesh_report import MeshReport, Stage

_WIDTH = 100  # columns, where the output is no terminal


def print_report(report: MeshReport) -> None:
    """Print a report as one table with a part for each stage.

    Parameters
    ----------
    report
        The report.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console()
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for column in ("", "what", "value"):
        table.add_column(column, overflow="fold")
    shown = None
    for note in sorted(report, key=lambda each: list(Stage).index(each.stage)):
        if shown is not None and note.stage is not shown:
            table.add_section()
        first = str(note.stage) if note.stage is not shown else ""
        table.add_row(*(Text(printable(text)) for text in (first, note.what, note.value)))
        shown = note.stage
    console.print(table, width=None if console.is_terminal else _WIDTH)
