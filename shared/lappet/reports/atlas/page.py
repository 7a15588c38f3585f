"""The page of the flap library: how it is used, and every design with what the atlas measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from lappet.bench.tables import markdown_table
from lappet.designs.library import DESIGNS
from lappet.reports.atlas.measured import measured_text, plain_text
from lappet.reports.atlas.model_section import model_overview
from lappet.reports.atlas.rows import CONTACT_ROWS, MODEL_ROWS
from lappet.reports.report_files import described

FOLDER = "flaps"  # beside the page, with a page of each design

_INTRODUCTION = """# The flap library

`make docs` writes this page, and one for each design, from `shared/lappet/designs/` and from the last `make atlas`,
which solves and draws every design at its defaults on a flat patch of the default skin, 4 mm thick, and those that
belong to a region of the body on a [model](models.md) of it. On the site (`make site`) the page of a design also offers
its operations as files.

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
skin, it is refused with the place and the share that fits. The Karapandzic flap goes round a mouth: on a model that has
one it is laid at its distances from the lips' border, elsewhere the mouth is cut as a slit. A flap with a pedicle over
skin (`paramedian-forehead`) has its second stage in the same timeline, and with `--set thinned=2.8` a third that thins
it.

With `--defect`, the name of a closed incision or of a landmark of three points or more, or *region:* and the name of a
face subset of the tissue, the design lies where that is, as the smallest of its shape whose excision holds it, and its
own excision takes the drawn one's place.

The procedure remembers how its flaps were laid (a prim with `LappetFlapAPI` for each; `lappet inspect` lists them), so
`lappet flap edit` and the handles in Blender can move, turn and change one later. Its events are then laid anew: what
was changed on them by hand is lost, and named.

`lappet compare one.usdc other.usdc` holds solved operations beside each other: closing force, greatest and mean tension
of the skin as a whole, near the scar and in each face subset, scar length and its direction against the skin lines,
dog-ear, undermined area, and where landmarks went; `-o` draws it as bars, `--plate` as a plate of plans and results.

In Python:

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
    """Write the page of the flap library, from which each design has a page of its own.

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
    on_models, contact = ({row["name"]: row for row in results.get(rows, [])} for rows in (MODEL_ROWS, CONTACT_ROWS))
    flat = [_overview(rows, float(results["spacing_mm"])), _runs(results, "runs") + "\n"]
    models = [model_overview(on_models, contact), _runs(results, "model_runs") + "\n"]
    if contact:
        models.append(f"With `--self-contact`: {_runs(results, 'contact_runs')}\n")
    return "\n".join([_INTRODUCTION, *flat, *models])


def _runs(results: Mapping[str, Any], key: str) -> str:
    """What the rows were taken on: a line for each run, the longest one without the names of its operations."""
    runs = results.get(key)
    if not runs:
        return described(results) if "machine" in results else ""
    if len(runs) == 1:
        return described(runs[0])
    first, *others = sorted(runs, key=lambda run: -len(run["designs"]))
    lines = [described(first), *(f"{', '.join(run['designs'])}: {described(run)}" for run in others)]
    return "\n\n".join(lines)


def _overview(rows: Mapping[str, Mapping[str, Any]], spacing: float) -> str:
    table = [
        [
            f"[{design.title}]({FOLDER}/{design.name}.md)",
            "not solved" if name not in rows else f"{rows[name]['frames']} of {rows[name]['of_frames']}",
            measured_text(rows, name, "total_force"),
            measured_text(rows, name, "greatest_force"),
            measured_text(rows, name, "tension"),
            plain_text(rows, name, "scar_length"),
            plain_text(rows, name, "open_area"),
            plain_text(rows, name, "overlap"),
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
