"""Keep the last atlas in the documents: `flap_pictures.py build/atlas` copies its results and filmstrips into docs/."""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

from PIL import Image

DOCS = Path(__file__).resolve().parent.parent / "docs"
QUALITY = 85


def main(folder: Path) -> None:
    """Copy the results, and the filmstrip of each design as JPEG."""
    results = json.loads((folder / "atlas.json").read_text(encoding="utf-8"))
    shutil.copyfile(folder / "atlas.json", DOCS / "atlas.json")
    pictures = DOCS / "images" / "flaps"
    pictures.mkdir(parents=True, exist_ok=True)
    for row in results["rows"]:
        strip = Image.open(folder / "pictures" / row["name"] / "filmstrip.png").convert("RGB")
        strip.save(pictures / f"{row['name']}.jpg", quality=QUALITY, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
