"""Cuts the pictures of docs/blender_*.md out of a run of tutorial.py: `python tests/gui/tutorial_pictures.py`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

ROOT = Path(__file__).resolve().parent.parent.parent
RESULTS = ROOT / "build" / "gui" / "results"
IMAGES = ROOT / "docs" / "images"
LARGEST = 200_000  # bytes of a picture
WINDOW = None
SIDEBAR, SPOTS = "sidebar", "spots"  # found in the notes of the run
AROUND = 110  # pixels about the places to click
# name in the documents: the screenshot, what of it, its width
PICTURES = {
    "tab": ("tab", WINDOW, 1200),
    "panel_tissue": ("tissue_scale", SIDEBAR, 380),
    "tissue": ("tissue", WINDOW, 1200),
    "incision": ("incision", WINDOW, 1200),
    "undermine": ("undermine", WINDOW, 1200),
    "hook": ("hook", WINDOW, 1200),
    "sew_deep": ("sew_deep", WINDOW, 1200),
    "sew_skin": ("sew_skin", WINDOW, 1200),
    "solving": ("solving", WINDOW, 1200),
    "solved": ("solved_40", WINDOW, 1200),
    "lift": ("lift", WINDOW, 1200),
    "lifted": ("lifted", WINDOW, 1200),
    "compare": ("compare", WINDOW, 1200),
    "strain": ("strain", WINDOW, 1200),
    "stage": ("stage", WINDOW, 1200),
    "render": ("render", WINDOW, 1000),
    "timeline": ("stale", SIDEBAR, 380),
    "tools": ("sew_skin", (0, 27, 900, 1000), 800),
    "places_deep": ("places_deep", SPOTS, 640),
    "places_skin": ("places_skin", SPOTS, 640),
}


def numbered(picture: Image.Image, spots: list[tuple[int, int]]) -> None:
    """Writes 1, 2, 3 ... beside places (x, y from the lower left corner), away from the middle of their seam."""
    draw = ImageDraw.Draw(picture)
    font = ImageFont.load_default(15)
    for number, (x, y) in enumerate(spots, 1):
        place = (x, picture.height - y)
        draw.ellipse([place[0] - 3, place[1] - 3, place[0] + 3, place[1] + 3], fill="black", outline="white")
        other = spots[(number - 1) ^ 2]  # the place of the other edge that it is joined to
        way = (x - other[0], other[1] - y)
        size = max((way[0] ** 2 + way[1] ** 2) ** 0.5, 1.0)
        at = (place[0] + 15 * way[0] / size, place[1] + 15 * way[1] / size)
        draw.text(at, str(number), fill="white", stroke_width=2, stroke_fill="black", font=font, anchor="mm")


def main() -> int:
    """Writes them, each as small as it may be; 1 where one is missing."""
    notes = json.loads((RESULTS / "verdict.json").read_text(encoding="utf-8"))["notes"]
    missing = [source for source, _, _ in PICTURES.values() if not (RESULTS / f"{source}.png").is_file()]
    if missing:
        print(f"{RESULTS} lacks {', '.join(missing)}; run: python tests/gui/run.py tutorial.py", file=sys.stderr)
        return 1
    for name, (source, box, width) in PICTURES.items():
        picture = Image.open(RESULTS / f"{source}.png").convert("RGB")
        if source in notes:
            numbered(picture, [tuple(spot) for spot in notes[source]])
        if box == SPOTS:
            across, up = zip(*notes[source], strict=True)
            down = [picture.height - y for y in up]
            box = (min(across) - AROUND, min(down) - AROUND, max(across) + AROUND, max(down) + AROUND)
        elif box == SIDEBAR:
            left, bottom, width_of, height = notes["sidebar"]
            box = (left, picture.height - bottom - height, left + width_of, picture.height - bottom)
        picture = picture.crop(box) if box else picture
        if picture.width > width:
            picture = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
        path = IMAGES / f"blender_{name}.png"
        for colours in (256, 128, 64):
            picture.quantize(colours, dither=Image.Dither.NONE).save(path, optimize=True)
            if path.stat().st_size <= LARGEST:
                break
        print(f"{path.relative_to(ROOT)}: {picture.width} x {picture.height}, {path.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
