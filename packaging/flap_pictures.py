"""Draw the plans of all designs into docs/, and keep the last atlas there: `flap_pictures.py [build/atlas]`."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from PIL import Image

from lappet.designs.flap_plan import flap_plan
from lappet.designs.library import DESIGNS
from lappet.output.plan_figure import write_plan_figure

DOCS = Path(__file__).resolve().parent.parent / "docs"
PICTURES = DOCS / "images" / "flaps"
QUALITY = 85


def draw_plans() -> None:
    """Draw the plan of every design at its defaults."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for design in DESIGNS.values():
        write_plan_figure(flap_plan(design), design.lines, PICTURES / f"{design.name}_plan.svg")


def keep_atlas(folder: Path) -> None:
    """Copy the results, and the plate of each operation as JPEG; those that the run left out keep their rows."""
    results = json.loads((folder / "atlas.json").read_text(encoding="utf-8"))
    before = json.loads((DOCS / "atlas.json").read_text(encoding="utf-8"))
    if before["spacing_mm"] != results["spacing_mm"] and results["rows"] and len(kept_rows(before, results)):
        sys.exit(f"The rows kept are at {before['spacing_mm']} mm: run the atlas at that spacing, or for all designs.")
    together = json.dumps(merged(before, results), indent=1, ensure_ascii=False)
    (DOCS / "atlas.json").write_text(together + "\n", encoding="utf-8")
    free = without_contact(merged(before, results))
    models = [row for row in results.get("model_rows", []) if row["name"] in free]
    for row in [*results["rows"], *models, *results.get("contact_rows", [])]:
        plate = Image.open(folder / f"{row['name']}.png").convert("RGB")
        plate.save(PICTURES / f"{row['name']}.jpg", quality=QUALITY, optimize=True)


def without_contact(results: Mapping[str, Any]) -> set[str]:
    """The operations on models whose picture is that of the solve without self-contact: with it they did not end."""
    ended = {row["name"] for row in results.get("contact_rows", []) if row["frames"] == row["of_frames"]}
    return {row["name"] for row in results["model_rows"]} - ended


def kept_rows(before: Mapping[str, Any], results: Mapping[str, Any], rows: str = "rows") -> list[Any]:
    """The rows of operations that a run left out."""
    solved = {row["name"] for row in results.get(rows, [])}
    return [row for row in before.get(rows, []) if row["name"] not in solved]


def merged(before: Mapping[str, Any], results: Mapping[str, Any]) -> dict[str, Any]:
    """The results of a run with the rows that it left out, each run with what it was taken on and its operations."""
    spacing = (results if results["rows"] else before)["spacing_mm"]
    together: dict[str, Any] = {}
    for name in ("", "model_", "contact_"):
        together |= _together(before, results, f"{name}runs", f"{name}rows")
    return {"spacing_mm": spacing, **together}


def _together(before: Mapping[str, Any], results: Mapping[str, Any], runs: str, rows: str) -> dict[str, Any]:
    kept, new = kept_rows(before, results, rows), results.get(rows, [])
    names = {row["name"] for row in kept}
    first = {**_head(before), "designs": [row["name"] for row in before.get(rows, [])]}
    own = [{**run, "designs": [name for name in run["designs"] if name in names]} for run in before.get(runs, [first])]
    own.append({**_head(results), "designs": [row["name"] for row in new]})
    return {runs: _joined([run for run in own if run["designs"]]), rows: [*kept, *new]}


def _joined(runs: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The runs, those that were taken on the same machine and revision as one, with the date of the last."""
    found: list[dict[str, Any]] = []
    for run in runs:
        same = [each for each in found if {**each, "designs": [], "date": ""} == {**run, "designs": [], "date": ""}]
        for each in same:
            found.remove(each)
        found.append({**run, "designs": [*(name for each in same for name in each["designs"]), *run["designs"]]})
    return found


def _head(results: Mapping[str, Any]) -> dict[str, Any]:
    apart = ("runs", "rows", "model_runs", "model_rows", "contact_runs", "contact_rows", "spacing_mm")
    return {name: value for name, value in results.items() if name not in apart}


if __name__ == "__main__":
    draw_plans()
    for argument in sys.argv[1:]:
        keep_atlas(Path(argument))
