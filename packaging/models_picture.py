"""Draw the picture of the anatomical models: `models_picture.py [docs/images/models.png]`.

Every model is solved for its first frame on a coarse lattice and drawn in its surroundings. It takes a few minutes, and
needs Blender's module and pillow (`lappet[render]`) and the package of the body models (`lappet models fetch`).
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "docs" / "images" / "models.png"
COARSE = 2.5  # times the spacing of the model
SIZE, COLUMNS, CAPTION, MARGIN = (300, 260), 6, 22, 6  # pixels


def lappet(*arguments: object) -> None:
    """Run a command of Lappet; raises CalledProcessError if it fails."""
    subprocess.run([sys.executable, "-m", "lappet", *map(str, arguments)], check=True, capture_output=True, text=True)


def draw(name: str, spacing: float, folder: Path) -> Path:
    """Draw a model and return the picture."""
    procedure, cache = folder / f"{name}.usda", folder / f"{name}.usdc"
    lappet("models", "new", name, "-o", procedure, "--spacing", COARSE * spacing)
    lappet("solve", procedure, "-o", cache, "--no-error-estimate")
    size = ("--size", f"{2 * SIZE[0]}x{2 * SIZE[1]}", "--view", "top")
    lappet("render", cache, "-o", folder / name, "--no-filmstrip", *size)
    (picture,) = (folder / name).glob("frame_*.png")
    return picture


def sheet(pictures: dict[str, Path], path: Path) -> None:
    """Put pictures on one sheet, each with its name."""
    from PIL import Image, ImageDraw, ImageFont

    rows = -(-len(pictures) // COLUMNS)
    width, height = SIZE[0] + MARGIN, SIZE[1] + CAPTION + MARGIN
    paper = Image.new("RGB", (COLUMNS * width + MARGIN, rows * height + MARGIN), "white")
    pen, font = ImageDraw.Draw(paper), ImageFont.load_default(14)
    for number, (name, picture) in enumerate(pictures.items()):
        x, y = MARGIN + number % COLUMNS * width, MARGIN + number // COLUMNS * height
        paper.paste(Image.open(picture).resize(SIZE, Image.Resampling.LANCZOS), (x, y))
        pen.text((x + 2, y + SIZE[1] + 2), name, fill=(40, 40, 40), font=font)
    paper.save(path, optimize=True)


def main(arguments: list[str]) -> int:
    """Draw all models."""
    from lappet.models.new_model import MODELS

    path = Path(arguments[0]) if arguments else PICTURE
    with tempfile.TemporaryDirectory() as folder:
        pictures = {}
        for name, model in MODELS.items():
            pictures[name] = draw(name, model.spacing, Path(folder))
            print(name, flush=True)
        sheet(pictures, path)
    print(path)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
