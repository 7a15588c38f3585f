"""Write the report of economy: economy.json, .csv and .md."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.reports.economy.instructions import isa_to_count, valgrind_version
from lappet.reports.economy.measurement import AGREEMENT, Cost, EconomyReport
from lappet.reports.economy.scenes import BAR, FEATURES
from lappet.reports.report_files import described, markdown_table, write_csv, write_json


def write_economy(folder: Path, head: Mapping[str, Any], report: EconomyReport) -> list[Path]:
    """Write the files of the report.

    Parameters
    ----------
    folder
        A folder that is there.
    head
        What each starts with.
    report
        What was measured.

    Returns
    -------
    list[Path]
        The files.
    """
    files = [folder / f"economy.{suffix}" for suffix in ("json", "csv", "md")]
    absences = [{**asdict(each), "share": each.share, "ok": each.share <= AGREEMENT} for each in report.absences]
    write_json(
        files[0],
        head,
        report.rows,
        scene=BAR.what,
        counted_by=valgrind_version(),
        counted_isa=isa_to_count(),
        uncounted=report.uncounted,
        absence=absences,
    )
    write_csv(files[1], report.rows)
    write_whole(files[2], markdown(head, report).encode())
    return files


def markdown(head: Mapping[str, Any], report: EconomyReport) -> str:
    """Write the report for people.

    Parameters
    ----------
    head
        What it starts with.
    report
        What was measured.

    Returns
    -------
    str
        Markdown.
    """
    parts = [
        "# Economy\n",
        described(head) + "\n",
        f"One frame of {BAR.what}, on one thread. Instructions: {valgrind_version() or 'not counted'}"
        f"{f', {isa_to_count()}' if isa_to_count() else ''}. Bytes: what the session holds and the frame carries. "
        "A feature changes the motion, and so the number of products: instructions of the kernels are therefore given "
        "a pass and a cell too.\n",
    ]
    if report.uncounted:
        parts.append(report.uncounted + "\n")
    columns = [
        "feature", "seconds without", "with", "instructions without", "with", "change", "bytes without", "with",
        "product a cell without", "with", "evaluation a cell without", "with", "products without", "with",
    ]  # fmt: skip
    body = []
    for feature in FEATURES:
        absent = next((row for row in report.rows if row.feature == feature.name and not row.present), None)
        present = next((row for row in report.rows if row.feature == feature.name and row.present), None)
        if absent is not None:
            body.append([feature.name.replace("_", " "), *_cells(absent, present)])
    parts.append(markdown_table(columns, body))
    parts.append("\n".join(f"- {each.name.replace('_', ' ')}: {each.what}." for each in FEATURES) + "\n")
    if report.absences:
        parts.append("## Absent features against builds without them\n")
        parts.append(
            markdown_table(
                ["left out", "scene", "instructions of the hot loops", "of the build without", "difference"],
                [
                    [each.left_out, each.scene, f"{each.instructions:,}", f"{each.yardstick_instructions:,}",
                     f"{100.0 * each.share:+.3f} %"]
                    for each in report.absences
                ],
            )
        )  # fmt: skip
    return "\n".join(parts)


def _cells(absent: Cost, present: Cost | None) -> list[Any]:
    """Without and with, side by side; empty where there is no number."""

    def pair(name: str, grouped: bool = False) -> list[Any]:
        values = [getattr(absent, name), None if present is None else getattr(present, name)]
        return ["" if value is None else f"{value:,}" if grouped else value for value in values]

    change = ""
    if present is not None and absent.instructions and present.instructions:
        change = f"{100.0 * (present.instructions / absent.instructions - 1.0):+.1f} %"
    return [
        *pair("seconds"), *pair("instructions", True), change, *pair("bytes", True), *pair("product_per_cell"),
        *pair("evaluation_per_cell"), *pair("products", True),
    ]  # fmt: skip
