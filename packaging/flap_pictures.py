"""Keep the last atlas in the documents: `flap_pictures.py build/atlas` copies its results and filmstrips into docs/."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent.parent / "docs"
QUALITY = 85


def main(folder: Path) -> None:
    """Copy the results, and the filmstrip of each design as JPEG; designs that the run left out keep their rows."""
    results = json.loads((folder / "atlas.json").read_text(encoding="utf-8"))
    before = json.loads((DOCS / "atlas.json").read_text(encoding="utf-8"))
    solved = {row["name"] for row in results["rows"]}
    kept = [row for row in before["rows"] if row["name"] not in solved]
    if kept and before["spacing_mm"] != results["spacing_mm"]:
        sys.exit(f"The rows kept are at {before['spacing_mm']} mm: run the atlas at that spacing, or for all designs.")
    together = json.dumps({**results, "rows": [*kept, *results["rows"]]}, indent=1, ensure_ascii=False)
    (DOCS / "atlas.json").write_text(together + "\n", encoding="utf-8")
    pictures = DOCS / "images" / "flaps"
    pictures.mkdir(parents=True, exist_ok=True)
    for row in results["rows"]:
        strip = Image.open(folder / "pictures" / row["name"] / "filmstrip.png").convert("RGB")
        strip.save(pictures / f"{row['name']}.jpg", quality=QUALITY, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
