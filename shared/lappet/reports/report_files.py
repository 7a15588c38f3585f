"""Files of a report: JSON, CSV and Markdown, each with what the numbers were taken on."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, is_dataclass
from pathlib import Path
from typing import Any

from lappet.bench.circumstances import circumstances, cores
from lappet.bench.tables import markdown_table
from lappet.core.durable import write_whole
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import SolverClient

__all__ = ["described", "head", "make_folder", "markdown_table", "write_csv", "write_json"]


def head() -> dict[str, Any]:
    """Gather machine, compiler, instruction set, threads, revision and date, as the installed daemon says.

    Returns
    -------
    dict[str, Any]
        Values that JSON can hold.
    """
    with SolverClient() as client:
        welcome = client.welcome
    return circumstances({name: str(welcome[name]) for name in ("compiler", "isa")}, cores())


def described(head: Mapping[str, Any]) -> str:
    """Say the same for people.

    Parameters
    ----------
    head
        What a report starts with.

    Returns
    -------
    str
        A line of text.
    """
    machine = head["machine"]
    return (
        f"{machine['processor']}, {machine['cores']} cores, {machine['memory_bytes'] / 2**30:.0f} GiB; "
        f"{head['compiler']}; {head['isa']}, {head['threads']} threads; revision {head['revision']}; {head['date']}."
    )


def make_folder(folder: Path) -> None:
    """Make the folder of a report.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    RefusedError
        If it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise refused(ProblemCode.REPORT_FOLDER, folder, error.strerror) from error


def write_json(path: Path, head: Mapping[str, Any], rows: Sequence[Any], **more: Any) -> None:
    """Write a report's JSON; numbers that are not finite become null.

    Parameters
    ----------
    path
        The file.
    head
        What it starts with.
    rows
        Rows, written as maps.
    **more
        What else there is.
    """
    values = _plain({**head, "rows": list(rows), **more})
    write_whole(path, (json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode())


def write_csv(path: Path, rows: Sequence[Any]) -> None:
    """Write rows, a line each.

    Parameters
    ----------
    path
        The file.
    rows
        Rows of one dataclass.
    """
    text = io.StringIO(newline="")
    lines = [_plain(row) for row in rows]
    if lines:
        writer = csv.DictWriter(text, list(lines[0]))
        writer.writeheader()
        writer.writerows(lines)
    write_whole(path, text.getvalue().encode())


def _plain(value: Any) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, Mapping):
        return {str(name): _plain(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if hasattr(value, "item") and not hasattr(value, "__len__"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
