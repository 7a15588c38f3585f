"""The page of the flap library: every design with its measures, sources, filmstrip and what the atlas measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lappet.bench.tables import markdown_table
from lappet.designs.flap_plan import flap_plan
from lappet.designs.library import DESIGNS
from lappet.designs.library_design import LibraryDesign
from lappet.reports.report_files import described

_INTRODUCTION = """# The flap library

`make docs` writes this page from `shared/lappet/designs/` and from the last `make atlas`, which solves and draws every
design at its defaults on a flat patch of the default skin, 4 mm thick.

```
lappet flap list                                     # the designs
lappet flap show bilobed                             # its measures, their ranges and sources
lappet flap show bilobed --picture plan.svg          # its plan as a line drawing, to scale
lappet flap add limberg -o flap.usda                 # on a flat patch of its own
lappet flap add bilobed face.usda -o flap.usda --at 2 -10 -14 --direction 0 0 1 --set diameter=8
lappet flap add fusiform face.usda -o flap.usda --landmark lesion --lines along
lappet flap add limberg face.usda -o flap.usda --defect lesion --lines across  # as large as what is drawn
lappet flap edit limberg flap.usda -o flap.usda --set side=14 --mirrored       # laid anew, the rest as it was
```

`add` writes the whole operation: cuts, excision, undermining, hooks that carry the flap, three rows of sutures (deep,
dermal, skin), and landmarks on both lips of every seam. In Blender it is *Add > Lappet > Flap*, or *Flap Library* in
the timeline's panel. A design is laid on
curved skin by geodesics: lines from its middle stay straight and keep their lengths. Where it is larger than the
skin, it is refused with the place and the share that fits. With `--defect`, the name of a closed incision or of a
landmark of three points or more, or *region:* and the name of a face subset of the tissue, the design lies where that
is, as the smallest of its shape whose excision holds it, and its own excision takes the drawn one's place.

The procedure remembers how its flaps were laid (a prim with `LappetFlapAPI` for each; `lappet inspect` lists them), so
`lappet flap edit` and the handles in Blender can move, turn and change one later. Its events are then laid anew: what
was changed on them by hand is lost, and named. In Python:

```python
from lappet.designs import DESIGNS, fit_to_defect, flap_on_patch

print(*DESIGNS)
procedure = flap_on_patch("bilobed", {"diameter": 10.0})
print(procedure)
fitted = fit_to_defect(procedure.tissue, "limberg", [(0, 0, 4), (9, 0, 4), (9, 6, 4), (0, 6, 4)], (1, 0, 0))
print(fitted.at, fitted.values)
```

```python
from lappet.designs import changed_flap, flap_on_patch, relay

procedure = flap_on_patch("limberg")
print(relay(procedure, changed_flap(procedure, procedure.flaps[0], measures={"side": 14.0})).flaps)
```

Drawings and steps follow the sources given. The numbers are the program's own for its default skin, with their
estimated errors; they are not fitted to anything, and no design was compared with patients.
"""


def flap_page(results: Mapping[str, Any]) -> str:
    """Write the page of the flap library.

    Parameters
    ----------
    results
        What the last atlas wrote.

    Returns
    -------
    str
        The text of docs/flaps.md.
    """
    rows = {row["name"]: row for row in results["rows"]}
    parts = [_INTRODUCTION, _overview(rows, float(results["spacing_mm"])), _runs(results) + "\n"]
    return "\n".join([*parts, *(_section(design, rows.get(name)) for name, design in DESIGNS.items())])


def _runs(results: Mapping[str, Any]) -> str:
    """What the rows were taken on: a line for each run, the longest one without the names of its designs."""
    runs = results.get("runs")
    if runs is None or len(runs) == 1:
        return described(runs[0] if runs else results)
    first, *others = sorted(runs, key=lambda run: -len(run["designs"]))
    lines = [described(first), *(f"{', '.join(run['designs'])}: {described(run)}" for run in others)]
    return "\n\n".join(lines)


def _overview(rows: Mapping[str, Mapping[str, Any]], spacing: float) -> str:
    table = [
        [
            f"[{design.title}](#{design.name})",
            "not solved" if name not in rows else f"{rows[name]['frames']} of {rows[name]['of_frames']}",
            _measured(rows, name, "total_force"),
            _measured(rows, name, "greatest_force"),
            _measured(rows, name, "tension"),
            _plain(rows, name, "scar_length"),
            _plain(rows, name, "open_area"),
            _plain(rows, name, "overlap"),
        ]
        for name, design in DESIGNS.items()
    ]
    headings = [
        "design",
        "frames converged",
        "all sutures, mN",
        "greatest, mN",
        "tension, kPa",
        "scar, mm",
        "open, mm²",
        "tissue in tissue, mm",
    ]
    about = (
        f"## All designs\n\nAt the last frame, cells of {spacing:.3g} mm. *Tissue in tissue* is how deep some of it "
        "lies in other at the end: nothing keeps it apart without `--self-contact`.\n\n"
    )
    return about + markdown_table(headings, table) + "\n"


def _section(design: LibraryDesign, row: Mapping[str, Any] | None) -> str:
    measures = [
        [
            f"`{parameter.name}`",
            parameter.meaning,
            f"{parameter.default:g} {parameter.unit}".strip(),
            parameter.range_text,
            parameter.source,
        ]
        for parameter in design.parameters
    ]
    lines = [f"## {design.name}", "", f"**{design.title}.** {design.indication}", ""]
    lines += [f"![Plan: {design.title}](images/flaps/{design.name}_plan.svg)", "", *_meetings(design)]
    if row is not None:
        lines += [f"![{design.title}, step by step](images/flaps/{design.name}.jpg)", ""]
    lines += [f"`--at` is {design.center}, `--direction` {design.direction}.", ""]
    if design.lines:
        lines += [f"Surgeons lay the direction {design.lines} the lines of the skin: `--lines {design.lines}`.", ""]
    lines += [markdown_table(["measure", "what it is", "default", "range", "source"], measures), ""]
    lines += [f"Sources: {design.sources}", ""]
    return "\n".join(lines)


def _meetings(design: LibraryDesign) -> list[str]:
    pairs = [f"{flap} and {wound}" for flap, wound in flap_plan(design).meetings]
    return [f"In the end meet: {', '.join(pairs)}.", ""] if pairs else []


def _measured(rows: Mapping[str, Mapping[str, Any]], name: str, what: str) -> str:
    value = rows.get(name, {}).get(what)
    if value is None:
        return ""
    number, error = value
    return f"{number:.3g}" if error is None else f"{number:.3g} ± {error:.1g}"


def _plain(rows: Mapping[str, Mapping[str, Any]], name: str, what: str) -> str:
    value = rows.get(name, {}).get(what)
    return "" if value is None else f"{value:.2g}" if value < 10.0 else f"{value:.0f}"
