"""Write the report of error against time: error_time.json, .csv, .md and a picture per scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lappet.core.durable import write_whole
from lappet.reports.error_time.measurement import FACTOR, LEAST_ORDER, Convergence, SceneReport
from lappet.reports.error_time.totals import totals
from lappet.reports.error_time.work_precision import plot_scene
from lappet.reports.report_files import described, markdown_table, write_csv, write_json

_ANSWERS = {True: "yes", False: "no", None: "cannot be judged"}


def write_error_time(folder: Path, head: Mapping[str, Any], reports: Sequence[SceneReport]) -> list[Path]:
    """Write the files of the report.

    Parameters
    ----------
    folder
        A folder that is there.
    head
        What each starts with.
    reports
        What was measured.

    Returns
    -------
    list[Path]
        The files.
    """
    rows = [row for report in reports for row in report.rows]
    orders = [found for report in reports for found in report.convergence]
    references = [
        {
            "scene": report.scene.name,
            "spacings_mm": report.scene.reference,
            "observed_order": report.reference.order,
            "uncertainty_mm": report.reference.uncertainty,
            "uncertainty_max_mm": report.reference.uncertainty_max,
            "edge_exponent": report.scene.edge_exponent,
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
    write_whole(files[2], markdown(head, reports).encode())
    return [*files, *pictures]


def markdown(head: Mapping[str, Any], reports: Sequence[SceneReport]) -> str:
    """Write the report for people.

    Parameters
    ----------
    head
        What it starts with.
    reports
        What was measured.

    Returns
    -------
    str
        Markdown.
    """
    parts = ["# Error against run time\n", described(head) + "\n"]
    parts += [f"{line}\n" for line in totals(reports).splitlines()]
    for report in reports:
        scene, reference = report.scene, report.reference
        parts.append(f"## {scene.name}\n\n{scene.what}\n")
        parts.append(f"![{scene.name}](error_time_{scene.name}.png)\n")
        fine = ", ".join(f"{h:.3g}" for h in reference_spacings(report))
        parts.append(
            f"Errors are against the extrapolation of {fine} mm (observed order {reference.order:.2f}), which may "
            f"itself be off by {reference.uncertainty:.2g} mm root mean square.\n"
        )
        parts.append(
            markdown_table(
                [
                    "spacing mm", "quadrature", "tolerance", "precision", "preconditioner", "cells", "seconds",
                    "error rms", "max", "estimate rms", "max", f"within {FACTOR:g} rms", "max", "estimate s", "",
                ],
                [
                    [
                        f"{row.spacing_mm:.3g}", row.quadrature, f"{row.tolerance:g}", row.precision,
                        row.preconditioner, row.cells, row.seconds, *(
                            "" if value is None else value
                            for value in (row.error_mm, row.error_max_mm, row.estimate_mm, row.estimate_max_mm)
                        ), *(_ANSWERS[held] for held in (row.within_3, row.max_within_3)),
                        "" if row.estimate_seconds is None else row.estimate_seconds, row.reason or "",
                    ]
                    for row in report.rows
                ],
            )
        )  # fmt: skip
        if report.convergence:
            parts.append(_about_order(report))
            parts.append(
                markdown_table(
                    [
                        "quadrature",
                        "spacings mm",
                        "errors mm",
                        "orders between them",
                        "fitted",
                        "away from what is held",
                    ],
                    [_order_row(found) for found in report.convergence],
                )
            )
    return "\n".join(parts)


def _about_order(report: SceneReport) -> str:
    sentences = ["Convergence, the tolerance out of the way."]
    exponent = report.scene.edge_exponent
    if exponent is not None and exponent < 1.0:
        sentences.append(
            f"Where a held side meets a free one displacements vary as r^{exponent:.2f} with the distance: that leaves "
            f"an order of {2.0 * exponent:.2f} in the limit, away from there too."
        )
    if report.scene.smooth:
        sentences.append(f"Nothing lowers the order: it must be at least {LEAST_ORDER:g}.")
    return " ".join(sentences) + "\n"


def _order_row(found: Convergence) -> list[str]:
    return [
        f"{found.quadrature}",
        ", ".join(f"{h:.3g}" for h in found.spacings),
        ", ".join(f"{e:.2g}" for e in found.errors_mm),
        ", ".join(f"{p:.2f}" for p in found.orders),
        f"{found.fitted:.2f}",
        "" if found.away_fitted is None else f"{found.away_fitted:.2f}",
    ]


def reference_spacings(report: SceneReport) -> tuple[float, float, float]:
    """List the spacings that the reference was extrapolated from.

    Parameters
    ----------
    report
        A scene's report.

    Returns
    -------
    tuple[float, float, float]
        Spacings in mm.
    """
    return report.scene.reference
