"""A page for each design of the flap library: its plan, its strip, its measures, what was measured and published."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lappet.bench.tables import markdown_table
from lappet.designs.flap_plan import flap_plan
from lappet.designs.library import DESIGNS
from lappet.designs.library_design import LibraryDesign
from lappet.reports.atlas.measured import measured_table
from lappet.reports.atlas.model_section import model_sections
from lappet.reports.atlas.rows import CONTACT_ROWS, MODEL_ROWS
from lappet.reports.literature.published import Published, Verdict
from lappet.reports.literature.rows import ROWS
from lappet.reports.literature.run import value_text


def design_pages(results: Mapping[str, Any], literature: Mapping[str, Any]) -> dict[str, str]:
    """Write the page of every design.

    Parameters
    ----------
    results
        What the last atlas wrote.
    literature
        What the last run of the literature's rows wrote.

    Returns
    -------
    dict[str, str]
        The text of docs/flaps/NAME.md by the name of the design.
    """
    rows = {row["name"]: row for row in results["rows"]}
    found = {row["name"]: row for row in literature["rows"]}
    on_models, contact = ({row["name"]: row for row in results.get(rows, [])} for rows in (MODEL_ROWS, CONTACT_ROWS))
    spacing = float(results["spacing_mm"])
    return {
        name: _page(
            design, _results(design, rows, spacing) + model_sections(name, on_models, contact), name in rows, found
        )
        for name, design in DESIGNS.items()
    }


def rows_of(design: str) -> list[Published]:
    """List the published numbers that are measured in operations of a design.

    Parameters
    ----------
    design
        Name of the design.

    Returns
    -------
    list[Published]
        The rows, in the order of the report.
    """
    return [row for row in ROWS if design in {_design_of(operation) for operation in row.measure.operations}]


def _design_of(operation: str) -> str:
    """The design whose name an operation of the literature has, or has before a hyphen: the longest; "" for none."""
    names = [name for name in DESIGNS if operation == name or operation.startswith(f"{name}-")]
    return max(names, key=len, default="")


def _page(design: LibraryDesign, results: list[str], is_solved: bool, found: Mapping[str, Mapping[str, Any]]) -> str:
    name, pictures = design.name, "../images/flaps"
    lines = ["<!-- Written by `make docs`. -->", f"# {design.title}", "", design.indication, ""]
    if is_solved:
        lines += [f"![{design.title}, step by step]({pictures}/{name}.jpg)", ""]
    lines += ["## The plan", "", f"![Plan: {design.title}]({pictures}/{name}_plan.svg)", "", *_meetings(design)]
    lines += [f"`--at` is {design.center}, `--direction` {design.direction}.", ""]
    if design.lines:
        lines += [f"Surgeons lay the direction {design.lines} the lines of the skin: `--lines {design.lines}`.", ""]
    lines += [f"```\nlappet flap add {name} -o {name}.usda\n```", "", "## Its measures", "", _measures(design), ""]
    lines += [f"Sources: {design.sources}", "", *results, *_literature(design, found)]
    lines += ["[All designs](../flaps.md)", ""]
    return "\n".join(lines)


def _measures(design: LibraryDesign) -> str:
    table = [
        [
            f"`{parameter.name}`",
            parameter.meaning,
            f"{parameter.default:g} {parameter.unit}".strip(),
            parameter.range_text,
            parameter.source,
        ]
        for parameter in design.parameters
    ]
    return markdown_table(["measure", "what it is", "default", "range", "source"], table)


def _meetings(design: LibraryDesign) -> list[str]:
    pairs = [f"{flap} and {wound}" for flap, wound in flap_plan(design).meetings]
    return [f"In the end meet: {', '.join(pairs)}.", ""] if pairs else []


def _results(design: LibraryDesign, rows: Mapping[str, Mapping[str, Any]], spacing: float) -> list[str]:
    """What the atlas measured in its last frame."""
    row = rows.get(design.name)
    if row is None:
        return ["## What was measured", "", "The last atlas does not have this design.", ""]
    suture = row.get("greatest_suture")
    about = (
        f"At its defaults on a flat patch of the default skin, 4 mm thick, cells of {spacing:.3g} mm, in the last "
        f"frame ({row['frames']} of {row['of_frames']} frames converged)."
    )
    about += f" The suture that pulls most is `{suture}`." if suture else ""
    remark = [design.remark, ""] if design.remark else []
    return ["## What was measured", "", about, "", *remark, measured_table(rows, design.name), ""]


def _literature(design: LibraryDesign, found: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The published numbers that the program measures with this design."""
    shown = [row for row in rows_of(design.name) if row.name in found]
    heading = ["## Beside the literature", ""]
    if not shown:
        return [*heading, "No published number is measured with this design yet.", ""]
    table = [
        [
            row.quantity,
            f"{row.range_text} ({row.source})",
            value_text(found[row.name]["value"], found[row.name]["error"], row.unit),
            f"[{found[row.name]['verdict']}](../literature.md#{row.name})",
        ]
        for row in shown
    ]
    reasons = [row.why for row in shown if found[row.name]["verdict"] == Verdict.DISAGREES.value and row.why]
    known = [f"Where it disagrees: {'; '.join(dict.fromkeys(reasons))}.", ""] if reasons else []
    return [*heading, markdown_table(["what", "published", "here", ""], table), "", *known]
