"""Write the report of the error estimate: error_estimate.json, .csv and .md, and error_estimate_values.csv."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from lappet.core.durable import write_whole
from lappet.reports.error_estimate.fit_orders import fit_orders
from lappet.reports.error_estimate.measured_values import FACTOR, FORCES, ValueRow, groups_of, shares
from lappet.reports.error_estimate.measurement import SHARE, EstimateRow
from lappet.reports.error_estimate.scene import EstimateScene
from lappet.reports.report_files import described, markdown_table, write_csv, write_json

_ANSWERS = {True: "yes", False: "no", None: ""}


def write_error_estimate(
    folder: Path,
    head: Mapping[str, Any],
    scenes: Sequence[EstimateScene],
    rows: Sequence[EstimateRow],
    values: Sequence[ValueRow] = (),
) -> list[Path]:
    """Write the files of the report.

    Parameters
    ----------
    folder
        A folder that is there.
    head
        What each starts with.
    scenes
        What was solved.
    rows
        What was measured.
    values
        Forces, tensions and measures of seams, with their errors.

    Returns
    -------
    list[Path]
        The files.
    """
    files = [folder / f"error_estimate{suffix}" for suffix in (".json", ".csv", ".md", "_values.csv")]
    write_json(files[0], head, rows, scenes={scene.name: scene.what for scene in scenes})
    write_csv(files[1], rows)
    write_whole(files[2], markdown(head, scenes, rows, values).encode())
    write_csv(files[3], values)
    return files


def totals(rows: Sequence[EstimateRow]) -> list[str]:
    """Sum up the rows for people.

    Parameters
    ----------
    rows
        The rows.

    Returns
    -------
    list[str]
        Sentences.
    """
    judged = [row for row in rows if row.ratios or row.reason is not None]
    within = [row for row in judged if row.is_within]
    low = [row for row in judged if row.is_too_small]
    share = len(within) / len(judged) if judged else 1.0
    return [
        f"{len(within)} of {len(judged)} rows ({share:.0%}; {SHARE:.0%} are asked for) lie within a factor {FACTOR:g} "
        f"of the true error, root mean square and greatest; {len(rows) - len(judged)} cannot be judged.",
        f"{len(low)} {'row lies' if len(low) == 1 else 'rows lie'} below a third of the true error; none may.",
        *(
            f"Outside: {row.scene} at {row.spacing_mm:.3g} mm, "
            + (row.reason or " and ".join(f"{each:.2g}" for each in row.ratios) + " times the true error.")
            for row in judged
            if not row.is_within
        ),
    ]


def fitted_totals(rows: Sequence[EstimateRow]) -> list[str]:
    """Say which orders would have served the rows best.

    Parameters
    ----------
    rows
        The rows of the scenes that orders are fitted on.

    Returns
    -------
    list[str]
        Sentences.
    """
    return [
        f"Order {each.order:.3g}: {each.within} of {each.rows} rows within, {each.too_small} below a third; with "
        f"{each.best:.3g} most would be within: {each.within_best}, {each.too_small_best} below a third."
        for each in fit_orders(rows)
    ]


def value_totals(values: Sequence[ValueRow]) -> list[str]:
    """Sum up the errors of forces, tensions and seams for people.

    Parameters
    ----------
    values
        The values.

    Returns
    -------
    list[str]
        Sentences; none where there is no value.
    """
    groups = groups_of(values)
    said = []
    for what, own in (
        ("forces and closing tensions", [each for each in groups if each.quantity in FORCES]),
        ("measures of seams and the mean tension", [each for each in groups if each.quantity not in FORCES]),
    ):
        if own:
            within, low = sum(each.is_within for each in own), sum(each.is_too_small for each in own)
            said.append(
                f"Of {what}, {within} of {len(own)} groups ({within / len(own):.0%}) lie within a factor {FACTOR:g} of "
                f"the true error, root mean square and greatest; {low} lie below a third of it."
            )
    return said


def _value_section(values: Sequence[ValueRow]) -> list[str]:
    """What the report has of forces, tensions and seams."""
    groups = groups_of(values)
    if not groups:
        return []
    table = markdown_table(
        ["quantity", f"groups within {FACTOR:g}", "below a third", "of", "median estimate / error", "of single values"],
        [
            [
                quantity,
                within,
                low,
                count,
                _short(_median([each.ratios[0] for each in groups if each.quantity == quantity and each.ratios])),
                _short(_median([row.estimate / row.error for row in values if row.quantity == quantity and row.is_judged
                                and row.estimate is not None])),
            ]
            for quantity, (within, low, count) in shares(groups).items()
        ],
    )  # fmt: skip
    outside = markdown_table(
        ["outside", "spacing mm", "quantity", "values", "root mean square", "error rms", "max", "estimate rms", "max"],
        [
            [
                each.scene, f"{each.spacing_mm:.3g}", each.quantity, each.count, f"{_short(each.value)} {each.unit}",
                _short(each.error), _short(each.error_max), _short(each.estimate), _short(each.estimate_max),
            ]
            for each in groups
            if each.quantity in FORCES and not each.is_within
        ],
    )  # fmt: skip
    return [
        "## Forces, tensions and seams\n",
        *(f"{line}\n" for line in value_totals(values)),
        "A group is the values of a quantity in a scene at a spacing, as the forces of all its sutures. The truth is "
        "the finest solve of the scene; what differs from it by less than that does from the solve on twice its "
        "spacing is left out. Every value is in error_estimate_values.csv.\n",
        table,
        "The groups of forces and closing tensions outside:\n",
        outside,
    ]


def markdown(
    head: Mapping[str, Any],
    scenes: Sequence[EstimateScene],
    rows: Sequence[EstimateRow],
    values: Sequence[ValueRow] = (),
) -> str:
    """Write the report for people.

    Parameters
    ----------
    head
        What it starts with.
    scenes
        What was solved.
    rows
        What was measured.
    values
        Forces, tensions and measures of seams, with their errors.

    Returns
    -------
    str
        Markdown.
    """
    what = markdown_table(
        ["scene", "what it is", "reference at mm"],
        [[scene.name, scene.what, ", ".join(f"{h:.3g}" for h in scene.reference)] for scene in scenes],
    )
    table = markdown_table(
        [
            "scene", "spacing mm", "cells", "error rms mm", "max", "estimate rms mm", "max", "estimate / error rms",
            "max", "order", f"within {FACTOR:g}", "trusted", "reference rms ±", "max ±", "its order", "",
        ],
        [
            [
                row.scene, f"{row.spacing_mm:.3g}", row.cells, _short(row.error_mm), _short(row.error_max_mm),
                _short(row.estimate_mm), _short(row.estimate_max_mm), _short(row.ratio), _short(row.max_ratio),
                _short(row.order), _ANSWERS[row.is_within if row.ratios or row.reason is not None else None],
                _ANSWERS[row.is_trusted], _short(row.uncertainty_mm), _short(row.uncertainty_max_mm),
                f"{row.reference_order:.2f}", row.reason or "",
            ]
            for row in rows
        ],
    )  # fmt: skip
    return "\n".join(
        [
            "# The printed error on scenes that it was not fitted on\n",
            described(head) + "\n",
            *(f"{line}\n" for line in totals(rows)),
            "Default settings, the last frame of each scene, errors over the vertices of the skin. A ratio is left out "
            "where the error is below the uncertainty of the reference.\n",
            table,
            what,
            *_value_section(values),
        ]
    )


def _median(ratios: Sequence[float]) -> float | None:
    return median(ratios) if ratios else None


def _short(value: float | None) -> str:
    return "" if value is None else f"{value:.2g}"
