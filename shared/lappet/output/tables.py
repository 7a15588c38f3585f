"""Tables as CSV: a row for each value of a dataclass, its fields as columns."""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole


def write_table(path: str | os.PathLike[str], kind: type[Any], rows: Sequence[Any]) -> None:
    """Write rows as CSV, numbers with six digits; what is not known is left empty.

    Parameters
    ----------
    path
        The file.
    kind
        The dataclass of the rows, whose fields name the columns.
    rows
        The rows.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    text = io.StringIO(newline="")
    table = csv.writer(text)
    table.writerow([item.name for item in fields(kind)])
    for row in rows:
        table.writerow([f"{value:.6g}" if isinstance(value, float) else value for value in astuple(row)])
    write_whole(Path(path), text.getvalue().encode())
