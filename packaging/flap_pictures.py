"""Draw the plans of all designs into docs/, and keep the last atlas there: `flap_pictures.py [build/atlas]`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

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
    """Copy the results, and the filmstrip of each design as JPEG; designs that the run left out keep their rows."""
    results = json.loads((folder / "atlas.json").read_text(encoding="utf-8"))
    before = json.loads((DOCS / "atlas.json").read_text(encoding="utf-8"))
    solved = {row["name"] for row in results["rows"]}
    kept = [row for row in before["rows"] if row["name"] not in solved]
    if kept and before["spacing_mm"] != results["spacing_mm"]:
        sys.exit(f"The rows kept are at {before['spacing_mm']} mm: run the atlas at that spacing, or for all designs.")
    together = json.dumps({**results, "rows": [*kept, *results["rows"]]}, indent=1, ensure_ascii=False)
    (DOCS / "atlas.json").write_text(together + "\n", encoding="utf-8")
    for row in results["rows"]:
        strip = Image.open(folder / "pictures" / row["name"] / "filmstrip.png").convert("RGB")
        strip.save(PICTURES / f"{row['name']}.jpg", quality=QUALITY, optimize=True)


if __name__ == "__main__":
    draw_plans()
    for argument in sys.argv[1:]:
        keep_atlas(Path(argument))
