"""What publishers ask of figures, from `journals.toml`: width and height, text, pixels, letters, fonts and formats."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.plate_style import PlateStyle, Shading
from lappet.procedure.plate import JOURNALS

_NEAR = 0.5  # mm: a printed width is not kept more exactly
_VECTORS = (".svg", ".pdf")
_CAPTION = 1.0  # pt: captions are so much larger than labels


@dataclass(frozen=True)
class Journal:
    """What a publisher asks of figures.

    Parameters
    ----------
    name
        Its name.
    source
        Address of the page that says so.
    pages
        Least width, greatest width and greatest height in mm, a row each.
    text
        Least and greatest size of text in points.
    line_dpi, combination_dpi, halftone_dpi
        Least pixels per inch of line drawings, of lines over shading, and of shading.
    most_dpi
        Greatest pixels per inch.
    small_letters
        Whether panels are called a, b, c.
    fonts
        The fonts that it names.
    suffixes
        The formats of files that it takes.
    most_megabytes
        Greatest size of a file in megabytes, 0 for any.
    """

    name: str
    source: str
    pages: tuple[tuple[float, float, float], ...]
    text: tuple[float, float]
    line_dpi: int
    combination_dpi: int
    halftone_dpi: int
    most_dpi: int
    small_letters: bool
    fonts: tuple[str, ...]
    suffixes: tuple[str, ...]
    most_megabytes: float

    @property
    def widths(self) -> str:
        """Its widths in mm, for sentences."""
        return ", ".join(f"{low:g}" if low == high else f"{low:g} to {high:g}" for low, high, _ in self.pages)

    def dpi(self, style: PlateStyle) -> int:
        """Choose the pixels per inch of a plate.

        Parameters
        ----------
        style
            How the plate looks.

        Returns
        -------
        int
            The least that it asks of such a figure.
        """
        return self.line_dpi if style.shading in (Shading.NONE, Shading.FILLS) else self.combination_dpi

    def check(self, width: float, text: float, dpi: int, style: PlateStyle, pictures: tuple[Path, ...]) -> None:
        """Refuse a plate that the publisher would send back, before it is drawn.

        Parameters
        ----------
        width
            Width of the page in mm.
        text
            Size of labels in points.
        dpi
            Pixels per inch.
        style
            How the plate looks.
        pictures
            The files to write.

        Raises
        ------
        RefusedError
            If the width, the text or the resolution is none that it takes.
        """
        if not any(low - _NEAR <= width <= high + _NEAR for low, high, _ in self.pages):
            raise refused(ProblemCode.PLATE_JOURNAL_WIDTH, self.name, f"{width:g}", known=self.widths)
        least, most = self.text
        if not least <= text <= most - _CAPTION:
            wanted = f"{least:g} to {most - _CAPTION:g}"
            raise refused(ProblemCode.PLATE_JOURNAL_TEXT, self.name, f"{text:g}", wanted=wanted)
        needed = self.halftone_dpi if all(each.suffix.lower() in _VECTORS for each in pictures) else self.dpi(style)
        if not needed <= dpi <= self.most_dpi:
            wanted = f"{needed} to {self.most_dpi}"
            raise refused(ProblemCode.PLATE_JOURNAL_DPI, self.name, dpi, wanted=wanted)

    def check_height(self, size: tuple[float, float]) -> None:
        """Refuse a page that is higher than the publisher's.

        Parameters
        ----------
        size
            Width and height of the page in mm.

        Raises
        ------
        RefusedError
            If it is.
        """
        most = max(high for low, wide, high in self.pages if low - _NEAR <= size[0] <= wide + _NEAR)
        if size[1] > most:
            raise refused(ProblemCode.PLATE_JOURNAL_HEIGHT, self.name, f"{size[1]:.0f}", most=f"{most:g}")

    def notes(self, family: str, pictures: tuple[Path, ...]) -> list[Problem]:
        """Say what of the files the publisher would ask about.

        Parameters
        ----------
        family
            Name of the plate's font.
        pictures
            The files that have been written.

        Returns
        -------
        list[Problem]
            A note for the font, and for each file in a format that it does not take or that is too large.
        """
        found = []
        if not family.startswith(self.fonts):
            found.append(problem(ProblemCode.PLATE_JOURNAL_FONT, self.name, family, known=", ".join(self.fonts)))
        for picture in pictures:
            if picture.suffix.lower() not in self.suffixes:
                known = ", ".join(self.suffixes)
                found.append(problem(ProblemCode.PLATE_JOURNAL_FORMAT, self.name, picture.suffix, known=known))
            megabytes = picture.stat().st_size / 1e6
            if self.most_megabytes and megabytes > self.most_megabytes:
                most = f"{self.most_megabytes:g}"
                found.append(problem(ProblemCode.PLATE_JOURNAL_SIZE, self.name, f"{megabytes:.1f}", most=most))
        return found


@cache
def _rows() -> dict[str, Journal]:
    rows = tomllib.loads((files("lappet.plates") / "journals.toml").read_text(encoding="utf-8"))
    made = {}
    for key, row in rows.items():
        row["pages"] = tuple(map(tuple, row["pages"]))
        for name in ("text", "fonts", "suffixes"):
            row[name] = tuple(row[name])
        made[key] = Journal(**row)
    return made


def journal_of(name: str) -> Journal:
    """Find what a publisher asks.

    Parameters
    ----------
    name
        One of `JOURNALS`.

    Returns
    -------
    Journal
        What it asks.

    Raises
    ------
    RefusedError
        If the publisher is not known.
    """
    found = _rows().get(name)
    if found is None:
        raise refused(ProblemCode.PLATE_JOURNAL, name, name, known=", ".join(JOURNALS))
    return found
