"""Writes the report of error against time: error_time.json, .csv, .md and a picture per scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lappet.reports.error_time import SceneReport
from lappet.reports.report_files import described, markdown_table, write_csv, write_json
from lappet.reports.work_precision import plot_scene


def write_error_time(folder: Path, head: Mapping[str, Any], reports: Sequence[SceneReport]) -> list[Path]:
    """Writes the files into `folder`, which is there, and returns them."""
    rows = [row for report in reports for row in report.rows]
    orders = [found for report in reports for found in report.convergence]
    references = [
        {
            "scene": report.scene.name,
            "spacings_mm": report.scene.reference,
            "observed_order": report.reference.order,
            "uncertainty_mm": report.reference.uncertainty,
        }
        for report in reports
    ]
    files = [folder / f"error_time.{suffix}" for suffix in ("json", "csv", "md")]
    write_json(files[0], head, rows, convergence=orders, references=references)
    write_csv(files[1], rows)
    pictures = []
    for report in reports:
        pictures.append(folder / f"error_time_{report.scene.name}.png")
        plot_scene(report, pictures[-1])
    files[2].write_text(markdown(head, reports), encoding="utf-8")
    return [*files, *pictures]


def markdown(head: Mapping[str, Any], reports: Sequence[SceneReport]) -> str:
    """The report for people."""
    parts = ["# Error against run time\n", described(head) + "\n"]
    for report in reports:
        scene, reference = report.scene, report.reference
        parts.append(f"## {scene.name}\n\n{scene.what}\n")
        parts.append(f"![{scene.name}](error_time_{scene.name}.png)\n")
        fine = ", ".join(f"{h:.3g}" for h in reference_spacings(report))
        parts.append(
            f"Errors are against the extrapolation of {fine} mm (observed order {reference.order:.2f}), which may "
            f"itself be off by {reference.uncertainty:.2g} mm root mean square.\n"
        )
        defaults = [row for row in report.rows if row.default]
        parts.append(
            markdown_table(
                ["spacing mm", "cells", "seconds", "error rms", "max", "estimate rms", "max", "estimate s", ""],
                [
                    [
                        f"{row.spacing_mm:.3g}", row.cells, row.seconds, *(
                            "" if value is None else value
                            for value in (
                                row.error_mm, row.error_max_mm, row.estimate_mm, row.estimate_max_mm,
                                row.estimate_seconds,
                            )
                        ), row.reason or "",
                    ]
                    for row in defaults
                ],
            )
        )  # fmt: skip
        if report.convergence:
            parts.append("Convergence, the tolerance out of the way:\n")
            parts.append(
                markdown_table(
                    ["quadrature", "spacings mm", "errors mm", "orders between them", "fitted order"],
                    [
                        [
                            f"{found.quadrature}",
                            ", ".join(f"{h:.3g}" for h in found.spacings),
                            ", ".join(f"{e:.2g}" for e in found.errors_mm),
                            ", ".join(f"{p:.2f}" for p in found.orders),
                            f"{found.fitted:.2f}",
                        ]
                        for found in report.convergence
                    ],
                )
            )
    return "\n".join(parts)


def reference_spacings(report: SceneReport) -> tuple[float, float, float]:
    """The spacings that the reference was extrapolated from, mm."""
    return report.scene.reference
