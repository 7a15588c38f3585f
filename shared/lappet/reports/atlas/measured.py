"""What the atlas measured, as the pages show it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lappet.bench.tables import markdown_table
from lappet.core.value_with_error import with_error

# What is shown of a row of the atlas: a field, what it is, its unit, whether it has an error.
_MEASURED = (
    ("total_force", "force of all sutures", "mN", True),
    ("greatest_force", "greatest force of a suture", "mN", True),
    ("tension", "greatest mean tension of the skin", "kPa", True),
    ("scar_length", "length of the scar", "mm", False),
    ("open_area", "wound still open", "mm²", False),
    ("dog_ear", "greatest dog-ear", "mm", False),
    ("overlap", "tissue in tissue", "mm", False),
)


def measured_table(
    rows: Mapping[str, Mapping[str, Any]], name: str, contact: Mapping[str, Mapping[str, Any]] | None = None
) -> str:
    """Write what the atlas measured of an operation as a table.

    Parameters
    ----------
    rows
        The atlas's rows by name.
    name
        Name of the row.
    contact
        Rows that were solved with self-contact; if one has the name, it gets a column.

    Returns
    -------
    str
        The table in Markdown.
    """
    columns = {"here": rows}
    if contact is not None and name in contact:
        columns["with `--self-contact`"] = contact
    table = []
    for field, title, unit, has_error in _MEASURED:
        texts = [(measured_text if has_error else plain_text)(each, name, field) for each in columns.values()]
        table.append([f"{title}, {unit}", *(text or "not measured" for text in texts)])
    return markdown_table(["what", *columns], table)


def measured_text(rows: Mapping[str, Mapping[str, Any]], name: str, what: str) -> str:
    """Write what the atlas measured with its estimated error.

    Parameters
    ----------
    rows
        The atlas's rows by design.
    name
        Name of the design.
    what
        Name of the measure.

    Returns
    -------
    str
        The number and its error; nothing where it was not measured.
    """
    value = rows.get(name, {}).get(what)
    if value is None:
        return ""
    return with_error(*value)


def plain_text(rows: Mapping[str, Mapping[str, Any]], name: str, what: str) -> str:
    """Write what the atlas measured without an error.

    Parameters
    ----------
    rows
        The atlas's rows by design.
    name
        Name of the design.
    what
        Name of the measure.

    Returns
    -------
    str
        The number; nothing where it was not measured.
    """
    value = rows.get(name, {}).get(what)
    return "" if value is None else f"{value:.2g}" if value < 10.0 else f"{value:.0f}"
