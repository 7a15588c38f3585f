"""What a design's page says of it on a body: how it is made there, what was measured, which landmarks moved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lappet.bench.tables import markdown_table
from lappet.core.value_with_error import with_error
from lappet.designs.library import DESIGNS
from lappet.models.regional_flaps import REGIONAL_FLAPS, RegionalFlap, regional_flaps
from lappet.reports.atlas.measured import measured_table, measured_text, plain_text

_MOVED = 0.2  # mm: landmarks that move less are not named
_NAMED = 6  # landmarks that are named, those that moved most
_PICTURES = "../images/flaps"


def model_sections(
    design: str, rows: Mapping[str, Mapping[str, Any]], contact: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    """Write a section for each place on a body where a design belongs.

    Parameters
    ----------
    design
        Name of the design.
    rows
        The atlas's rows on models by operation.
    contact
        Those with self-contact.

    Returns
    -------
    list[str]
        Lines of Markdown; none for a design that belongs to no region.
    """
    return [line for flap in regional_flaps(design) for line in _section(flap, rows, contact)]


def model_overview(rows: Mapping[str, Mapping[str, Any]], contact: Mapping[str, Mapping[str, Any]]) -> str:
    """Write a table of all operations on a body.

    Parameters
    ----------
    rows
        The atlas's rows on models by operation.
    contact
        Those with self-contact.

    Returns
    -------
    str
        The section of the page of the flap library.
    """
    table = [
        [
            f"[on {flap.place}](flaps/{flap.design}.md#on-{flap.place.replace(' ', '-').lower()})",
            f"`{flap.design}`",
            f"`{flap.model}`",
            "not solved" if name not in rows else f"{rows[name]['frames']} of {rows[name]['of_frames']}",
            measured_text(rows, name, "total_force"),
            measured_text(rows, name, "greatest_force"),
            plain_text(rows, name, "scar_length"),
            plain_text(rows, name, "open_area"),
            plain_text(rows, name, "overlap"),
            f"{contact[name]['frames']} of {contact[name]['of_frames']}" if name in contact else "",
            plain_text(contact, name, "overlap"),
        ]
        for name, flap in REGIONAL_FLAPS.items()
    ]
    headings = ["operation", "design", "model", "frames converged", "all sutures, mN", "greatest, mN", "scar, mm"]
    about = (
        "## On a body\n\nDesigns that belong to a region, on the [model](models.md) that holds it, at the model's own "
        "spacing. `shared/lappet/models/regional_flaps.py` says where each lies and with which measures.\n\n"
    )
    headings += ["open, mm²", "tissue in tissue, mm", "frames with `--self-contact`", "tissue in tissue"]
    return about + markdown_table(headings, table) + "\n"


def _section(
    flap: RegionalFlap, rows: Mapping[str, Mapping[str, Any]], contact: Mapping[str, Mapping[str, Any]]
) -> list[str]:
    name, row = flap.name, rows.get(flap.name)
    lines = [f"## On {flap.place}", ""]
    if row is None:
        return [*lines, "The last atlas does not have this operation.", "", *_made(flap)]
    if row["frames"]:
        lines += [f"![{DESIGNS[flap.design].title} on {flap.place}, step by step]({_PICTURES}/{name}.jpg)", ""]
    lines += [*_made(flap), _about(flap, row), "", *_with_contact(contact.get(name))]
    lines += [measured_table(rows, name, contact), "", *_moved(row)]
    return [*lines, *([flap.remark, ""] if flap.remark else [])]


def _about(flap: RegionalFlap, row: Mapping[str, Any]) -> str:
    cells = f"{row['cells']:_}".replace("_", " ")
    text = (
        f"On the model [`{flap.model}`](../models.md#the-models), {cells} cells of {row['spacing']:.3g} mm, in "
        f"the last frame ({row['frames']} of {row['of_frames']} frames converged, {row['newton']} Newton iterations in "
        "all)."
    )
    if row["frames"] < row["of_frames"]:
        text += f" **It does not come to its end**: {row['reason'] or 'a frame did not converge.'}"
    suture = row.get("greatest_suture")
    return text + (f" The suture that pulls most is `{suture}`." if suture else "")


def _with_contact(row: Mapping[str, Any] | None) -> list[str]:
    """What keeping tissue from passing through tissue takes; nothing where it was not tried."""
    if row is None:
        return []
    frames = f"{row['frames']} of {row['of_frames']} frames converge, {row['newton']} Newton iterations in all"
    text = f"With [`--self-contact`](../self_contact.md) {frames}"
    if row["frames"] < row["of_frames"]:
        return [f"{text}. {row['reason']}".rstrip(), ""]
    return [f"{text}; the picture shows that solve.", ""]


def _made(flap: RegionalFlap) -> list[str]:
    """The commands that make the operation."""
    file, operation = f"{flap.model}.usda", f"{flap.name}.usda"
    if flap.scar is not None:
        return ["```", f"python examples/faces/build.py {flap.name} {operation}", "```", ""]
    model = [f"lappet models new {flap.model} -o {file}", *(f"--target {name}={by:g}" for name, by in flap.targets)]
    if flap.spacing is not None:
        model.append(f"--spacing {flap.spacing:g}")
    model += ["--gravity 0"] * flap.weightless + ["--self-contact"] * flap.self_contact
    at = " ".join(f"{each:g}" for each in flap.at)
    if isinstance(flap.direction, str):
        way = f"--lines {flap.direction}"
    else:
        way = "--direction " + " ".join(f"{each:g}" for each in flap.direction)
    add = [f"lappet flap add {flap.design} {file} -o {operation}", f"--at {at} {way}"]
    add += ["--mirrored"] * flap.mirrored + [f"--set {name}={value:g}" for name, value in flap.measures.items()]
    return ["```", " ".join(model), " ".join(add), "```", ""]


def _moved(row: Mapping[str, Any]) -> list[str]:
    """Which landmarks of the model moved, the farthest first."""
    moved = [(name, value) for name, value in row["moved"].items() if value[0] >= _MOVED]
    far = sorted(moved, key=lambda each: -each[1][0])
    if not far:
        return [f"No landmark of the model moves by {_MOVED:g} mm or more.", ""] if row["moved"] else []
    named = ", ".join(f"{name} {with_error(*value)}" for name, value in far[:_NAMED])
    more = f" and {len(far) - _NAMED} more" if len(far) > _NAMED else ""
    return [f"Landmarks that move by {_MOVED:g} mm or more, those on the flap with it, in mm: {named}{more}.", ""]
