"""A film's contact sheet: the picture of each step in the film's order, with the time at which it is shown."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from lappet.core.durable import write_whole
from lappet.core.output_place import check_place
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.page_ground import PageGround

_FORMATS = {".png": "PNG", ".tif": "TIFF", ".tiff": "TIFF"}
SUFFIXES = tuple(_FORMATS)
_WIDTH = 640  # pixels of a picture
_COLUMNS = 3
_GAP = 24  # pixels
_LINE = 34  # pixels of the line below a picture
_LETTER = 22  # pixels


def check_sheet(path: Path) -> str:
    """Refuse a contact sheet that cannot be written, before the film is drawn.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    str
        Its suffix, in lower case.

    Raises
    ------
    RefusedError
        If its suffix is none of `SUFFIXES` or its folder is missing.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise refused(ProblemCode.PLATE_SUFFIX, path, path.suffix, known=", ".join(SUFFIXES))
    if not path.absolute().parent.is_dir():
        raise refused(ProblemCode.PLATE_FOLDER, path, path.parent)
    check_place(path)
    return suffix


def write_contact_sheet(pictures: Sequence[tuple[Path, float]], path: Path, font: Path, ground: PageGround) -> None:
    """Write a contact sheet.

    Parameters
    ----------
    pictures
        A picture of each step, all of one size, and the second of the film at which it is shown.
    path
        The file (`check_sheet`); it appears whole or not at all.
    font
        The file of the font in which the times are written.
    ground
        Color of the sheet and of the times; where the ground is left out it is white.

    Raises
    ------
    RefusedError
        If the file's suffix is none of `SUFFIXES` or its folder is missing.
    OSError
        If the file cannot be written.
    """
    suffix = check_sheet(path)
    with Image.open(pictures[0][0]) as first:
        height = round(_WIDTH * first.height / first.width)
    columns = min(_COLUMNS, len(pictures))
    rows = -(-len(pictures) // columns)
    size = (_GAP + columns * (_WIDTH + _GAP), _GAP + rows * (height + _LINE + _GAP))
    sheet = Image.new("RGB", size, ground.paper or "#ffffff")
    draw, letters = ImageDraw.Draw(sheet), ImageFont.truetype(font, _LETTER)
    for number, (picture, second) in enumerate(pictures):
        corner = (_GAP + number % columns * (_WIDTH + _GAP), _GAP + number // columns * (height + _LINE + _GAP))
        with Image.open(picture) as whole:
            small = whole.convert("RGBA").resize((_WIDTH, height), Image.Resampling.LANCZOS)
        sheet.paste(small, corner, small)
        draw.rectangle((corner[0] - 1, corner[1] - 1, corner[0] + _WIDTH, corner[1] + height), outline=ground.quiet)
        draw.text((corner[0], corner[1] + height + 0.5 * _LINE), _clock(second), ground.ink, letters, "lm")
    buffer = io.BytesIO()
    sheet.save(buffer, _FORMATS[suffix])
    write_whole(path, buffer.getvalue())


def _clock(second: float) -> str:
    return f"{int(second) // 60}:{second % 60:04.1f}"
