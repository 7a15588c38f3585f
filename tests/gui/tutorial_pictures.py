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
SPOTS = "spots"  # found in the notes of the run, as the sidebar's place is
SEAMS = ("#b3261e", "#1d6f42", "#1b4f9c")
AROUND = 70  # pixels about the places to click
# name in the documents: the screenshot, what of it (a number: so many pixels of the sidebar), its width
PICTURES = {
    "tab": ("tab", WINDOW, 1200),
    "panel_tissue": ("tissue_scale", 323, 380),
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
    "render": ("render", WINDOW, 900),
    "timeline": ("stale", 550, 380),
    "places_deep": ("places_deep", SPOTS, 640),
    "places_skin": ("places_skin", SPOTS, 640),
}


def numbered(picture: Image.Image, spots: list[tuple[int, int]]) -> None:
    """Draws the seams, each in a color: along their two edges a line from number to number.

    spots: x, y from the lower left corner, four for each seam.
    """
    draw = ImageDraw.Draw(picture)
    font = ImageFont.load_default(17)
    places = [(x, picture.height - y) for x, y in spots]
    for first in range(0, len(places), 2):
        draw.line(places[first : first + 2], fill=SEAMS[first // 4], width=3)
    for number, (x, y) in enumerate(places, 1):
        draw.ellipse([x - 11, y - 11, x + 11, y + 11], fill=SEAMS[(number - 1) // 4], outline="white", width=2)
        draw.text((x, y), str(number), fill="white", font=font, anchor="mm")


def few_colors(picture: Image.Image, colors: int) -> Image.Image:
    """The picture in so many colors: most for its large areas, a quarter for small things of another color."""
    large = picture.quantize(colors * 3 // 4, Image.Quantize.MEDIANCUT).getpalette() or []
    small = picture.quantize(colors // 4, Image.Quantize.MAXCOVERAGE).getpalette() or []
    both = Image.new("P", (1, 1))
    both.putpalette(large[: colors * 9 // 4] + small[: colors * 3 // 4])
    return picture.quantize(palette=both, dither=Image.Dither.NONE)


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
        elif isinstance(box, int):
            left, bottom, across, height = notes["sidebar"]
            top = picture.height - bottom - height
            box = (left, top, left + across, top + box)
        picture = picture.crop(box) if box else picture
        if picture.width > width:
            picture = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
        path = IMAGES / f"blender_{name}.png"
        for colors in (256, 128, 64):
            few_colors(picture, colors).save(path, optimize=True)
            if path.stat().st_size <= LARGEST:
                break
        print(f"{path.relative_to(ROOT)}: {picture.width} x {picture.height}, {path.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
