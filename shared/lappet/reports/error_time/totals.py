"""What the report of error against time comes to: how many estimates hold, and which orders reach what they must."""

from __future__ import annotations

from collections.abc import Sequence

from lappet.reports.error_time.measurement import FACTOR, LEAST_ORDER, Measure, SceneReport


def outside(rows: Sequence[Measure]) -> list[Measure]:
    """List the rows whose estimate is not within a factor 3 of the true error, root mean square or greatest.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    list[Measure]
        Those outside.
    """
    return [row for row in rows if row.within_3 is False or row.max_within_3 is False]


def totals(reports: Sequence[SceneReport]) -> str:
    """Sum up the reports for people.

    Parameters
    ----------
    reports
        The reports.

    Returns
    -------
    str
        Sentences, one to a line.
    """
    rows = [row for report in reports for row in report.rows]
    lines = []
    for what, held in (
        ("Root mean square", [row.within_3 for row in rows]),
        ("Greatest", [row.max_within_3 for row in rows]),
    ):
        judged = [each for each in held if each is not None]
        lines.append(
            f"{what}: {sum(judged)} of {len(judged)} estimates lie within a factor {FACTOR:g} of the true error; "
            f"{len(held) - len(judged)} cannot be judged."
        )
    lines += [
        f"Outside: {row.scene} {row.spacing_mm:.3g} mm, quadrature {row.quadrature}, tolerance {row.tolerance:g}, "
        f"{row.precision}, {row.preconditioner}: {row.estimate_mm:.2g} mm rms and {row.estimate_max_mm:.2g} mm at most "
        f"are estimated, {row.error_mm:.2g} mm and {row.error_max_mm:.2g} mm are true."
        for row in outside(rows)
    ]
    smooth = [found for report in reports if report.scene.smooth for found in report.convergence]
    if smooth:
        low = [found for found in smooth if found.fitted < LEAST_ORDER]
        lines.append(
            f"Order: {len(smooth) - len(low)} of {len(smooth)} reach {LEAST_ORDER:g} where nothing lowers it"
            + "".join(f"; {each.scene} at quadrature {each.quadrature} {each.fitted:.2f}" for each in low)
            + "."
        )
    return "\n".join(lines)
