"""What was measured as files: JSON and CSV for programs, Markdown for people, ours beside what others published."""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lappet.bench.kernels import KernelMeasure, Suite
from lappet.bench.pipeline import StageMeasure
from lappet.bench.scenes import SceneMeasure
from lappet.bench.sheets import SheetMeasure, summary

MODES = ("cache", "stream")


def published() -> dict[str, Any]:
    """Read the figures of others, `published.toml`.

    Returns
    -------
    dict[str, Any]
        The tables.
    """
    return tomllib.loads(Path(__file__).with_name("published.toml").read_text("utf-8"))


def write_json(path: Path, head: Mapping[str, Any], **tables: Any) -> None:
    """Write a file of results.

    Parameters
    ----------
    path
        The file.
    head
        What it starts with.
    **tables
        Rows by name, written as maps.

    Raises
    ------
    OSError
        If the file system refuses.
    ValueError
        If a number is not finite.
    """
    values = {**head, **{name: _plain(table) for name, table in tables.items()}}
    path.write_text(json.dumps(values, indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


def write_csv(path: Path, rows: Sequence[Any], head: Mapping[str, Any]) -> None:
    """Write rows with the machine, compiler and revision at the end of each.

    Parameters
    ----------
    path
        The file.
    rows
        Rows of one dataclass.
    head
        What each file of results starts with.
    """
    names = ("compiler", "revision", "date")
    extra = {"processor": head["machine"]["processor"], **{name: head[name] for name in names}}
    with path.open("w", newline="", encoding="utf-8") as file:
        writer: csv.DictWriter[str] | None = None
        for row in rows:
            values = {**asdict(row), **extra}
            if writer is None:
                writer = csv.DictWriter(file, list(values))
                writer.writeheader()
            writer.writerow(values)


def markdown_table(columns: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Write a table of GitHub-flavored Markdown.

    Parameters
    ----------
    columns
        Titles of the columns.
    rows
        Rows; the first column is text, numbers are rounded to four digits.

    Returns
    -------
    str
        The table.
    """
    lines = ["| " + " | ".join(columns) + " |", "|---|" + "---:|" * (len(columns) - 1)]
    lines += ["| " + " | ".join(_cell(value) for value in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"


def scenes_markdown(rows: Sequence[SceneMeasure]) -> str:
    """Write Table 1 of the paper, with our scenes below its own.

    Parameters
    ----------
    rows
        Our scenes.

    Returns
    -------
    str
        The table.
    """
    table = published()["table_1"]
    columns = [*table["columns"], "Newton", "PCG", "residual", "bytes per cell", "search for saddles"]
    body = [[*row, "", "", "", "", ""] for row in table["rows"]]
    for r in rows:
        body.append(
            [
                f"**{r.scene}** ({r.threads} threads, {r.isa}){'' if r.converged else ' — not converged'}",
                r.cells,
                r.grid_cells,
                r.mesh_cells,
                r.blocks,
                r.newton_iteration_s,
                r.update_state_ms,
                "",
                r.product_ms,
                "",
                "",
                r.newton_iterations,
                r.pcg_iterations,
                r.residual,
                r.bytes_per_cell,
                f"{100.0 * r.stability_seconds / max(r.solver_seconds, 1e-9):.1f} %",
            ]
        )
    return (
        f"{table['source']}\n\nOurs in bold, every Newton iteration with its linear system solved. Their update of the "
        "state adds no forces, ours does; our product is one pass that gathers, differentiates, stabilizes and "
        "scatters, where theirs are three: add differential, compact and uncompact.\n\n" + markdown_table(columns, body)
    )


def kernels_markdown(suite: Suite) -> str:
    """Write the kernels by instruction set, ns per cell and in brackets the share of the roofline.

    Parameters
    ----------
    suite
        The measured kernels.

    Returns
    -------
    str
        The table.
    """
    sets = list(dict.fromkeys(row.isa for row in suite.rows))
    found = {(r.kernel, r.precision, r.isa, r.mode): r for r in suite.rows}
    body = []
    for kernel, precision in dict.fromkeys((r.kernel, r.precision) for r in suite.rows):
        cells = [_kernel_cell(found.get((kernel, precision, isa, mode))) for mode in MODES for isa in sets]
        some = next(r for r in suite.rows if (r.kernel, r.precision, r.mode) == (kernel, precision, "stream"))
        body.append([f"{kernel} ({precision})", *cells, some.bytes_per_cell, some.operations_per_cell])
    columns = ["kernel", *(f"{isa} {mode}" for mode in MODES for isa in sets), "bytes", "operations"]
    limits = suite.limits
    rates = ", ".join(f"{isa} {precision} {rate / 1e9:.0f}" for (precision, isa), rate in limits.multiply_add.items())
    text = (
        "Nanoseconds per cell on one thread, and the share of the roofline. Bytes and operations are per cell, "
        f"streaming. Copy bandwidth {limits.copy['stream'] / 1e9:.1f} GB/s streaming, "
        f"{limits.copy['cache'] / 1e9:.0f} GB/s in cache; 10⁹ operations/s of multiply-adds: {rates}.\n\n"
        + markdown_table(columns, body)
    )
    if suite.parallel:
        rows = [[f"{p.threads}", p.isa, p.cells, p.ms, p.speedup] for p in suite.parallel]
        text += "\n" + markdown_table(["threads", "set", "cells", "product ms", "over one thread"], rows)
    table = published()["kernels"]
    return text + f"\n{table['source']}\n\n" + markdown_table(table["columns"], table["rows"])


def sheets_markdown(rows: Sequence[SheetMeasure]) -> str:
    """Write the plain sheets, and what they say together.

    Parameters
    ----------
    rows
        The sheets.

    Returns
    -------
    str
        The tables.
    """
    names = (
        "benchmark", "spacing_mm", "poissons_ratio", "precision", "tolerance", "threads", "cells", "seconds",
        "newton_iterations", "pcg_iterations", "load_steps", "residual", "update_state_ms", "product_ms",
        "bytes_per_cell",
    )  # fmt: skip
    body = [
        [getattr(row, name) for name in names] + ["" if row.converged else f"not converged: {row.reason}"]
        for row in rows
    ]
    said = "".join(f"\n- {name.replace('_', ' ')}: {value:.3g}" for name, value in summary(rows).items())
    return markdown_table([*(name.replace("_", " ") for name in names), ""], body) + said + "\n"


def pipeline_markdown(rows: Sequence[StageMeasure]) -> str:
    """Write the stages of the solves as Markdown.

    Parameters
    ----------
    rows
        The rows, those of a scene together.

    Returns
    -------
    str
        The text.
    """
    scenes = dict.fromkeys((row.scene, row.spacing_mm, row.cells, row.frames, row.threads) for row in rows)
    stages = list(dict.fromkeys(row.stage for row in rows))
    found = {(row.scene, row.spacing_mm, row.stage): row for row in rows}
    body = []
    for scene, spacing, cells, frames, threads in scenes:
        own = [found[scene, spacing, stage] for stage in stages]
        body.append(
            [f"{scene} at {spacing:g} mm", cells, frames, threads]
            + [f"{row.seconds:.2f} ({row.own_seconds:.2f}, {100 * row.share:.0f} %)" for row in own]
        )
    text = "Seconds; in brackets those on a processor without the daemon's, and the share of the whole solve.\n\n"
    return text + markdown_table(["scene", "cells", "frames", "threads", *stages], body)


def _kernel_cell(row: KernelMeasure | None) -> str:
    return "" if row is None else f"{row.ns_per_cell:.1f} ({100 * row.roofline_fraction:.0f} %)"


def _cell(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return f"{value:,}".replace(",", " ") if isinstance(value, int) else str(value)


def _plain(table: Any) -> Any:
    if isinstance(table, (list, tuple)):
        return [_plain(row) for row in table]
    return asdict(table) if hasattr(table, "__dataclass_fields__") else table
