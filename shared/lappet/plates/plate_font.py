"""The font of a plate: widths of its texts, the characters that it lacks, and the part of it that an SVG carries."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.plates.installed_fonts import chinese_font

_FAMILY = 16  # name table: typographic family, then family
_PLAIN_FAMILY = 1


def plate_font(path: Path | None, language: str) -> PlateFont:
    """Choose the font of a plate.

    Parameters
    ----------
    path
        The file that the user names, or None.
    language
        Code of the plate's language.

    Returns
    -------
    PlateFont
        That font, or Source Sans Pro; for Chinese an open font that is installed, where there is one.

    Raises
    ------
    RefusedError
        If the file is no font that can be read.
    """
    return PlateFont(chinese_font() if path is None and language == "zh" else path)


def _simplified_chinese(path: Path) -> int:
    """The face for simplified Chinese of a file that has several, or else the first; -1 for a file of one face."""
    from fontTools.ttLib import TTCollection

    with path.open("rb") as file:
        if file.read(4) != b"ttcf":
            return -1
    with TTCollection(path, lazy=True) as faces:
        names = [str(face["name"].getDebugName(_PLAIN_FAMILY)) for face in faces]
    return next((k for k, name in enumerate(names) if name.endswith(" SC")), 0)


class PlateFont:
    """A font file.

    Parameters
    ----------
    path
        A TrueType or OpenType file; None for Source Sans Pro. Of several faces the one for simplified Chinese.

    Raises
    ------
    RefusedError
        If the file is no font that can be read.
    """

    def __init__(self, path: Path | None = None) -> None:
        from fontTools.ttLib import TTFont, TTLibError

        own = Path(str(files("font_source_sans_pro") / "files" / "SourceSansPro-Regular.ttf"))
        self.path = path or own
        self._embedded: dict[str, str] = {}  # by their characters: pictures of a film need the same again and again
        try:
            self._face = _simplified_chinese(self.path)
            self._font: Any = TTFont(self.path, fontNumber=self._face)
            self._cmap: dict[int, str] = self._font.getBestCmap()
            self._widths: Any = self._font["hmtx"]
            names = self._font["name"]
            self.family = str(names.getDebugName(_FAMILY) or names.getDebugName(_PLAIN_FAMILY))
            self._em = float(self._font["head"].unitsPerEm)
        except (OSError, TTLibError, KeyError) as error:
            raise refused(ProblemCode.PLATE_FONT, self.path, reason=str(error)) from error

    def width(self, text: str, size: float) -> float:
        """Measure a line of text.

        Parameters
        ----------
        text
            The text.
        size
            Size of the font, in any unit.

        Returns
        -------
        float
            Its width in that unit, without kerning.
        """
        glyphs = (self._cmap.get(ord(each), ".notdef") for each in text)
        return sum(self._widths[glyph][0] for glyph in glyphs) * size / self._em

    def has(self, character: str) -> bool:
        """Tell whether it can show a character.

        Parameters
        ----------
        character
            The character.

        Returns
        -------
        bool
            Whether it has it.
        """
        return ord(character) in self._cmap

    def check(self, texts: Iterable[str]) -> None:
        """Refuse texts that the font cannot show.

        Parameters
        ----------
        texts
            The texts.

        Raises
        ------
        RefusedError
            If it lacks a character; the first is named.
        """
        for text in texts:
            for each in text:
                if ord(each) not in self._cmap:
                    raise refused(ProblemCode.PLATE_FONT_LACKS, self.path.name, each, text=text)

    def embedded(self, texts: Iterable[str]) -> str:
        """Make the part of the font that some texts need, for an SVG.

        Parameters
        ----------
        texts
            The texts.

        Returns
        -------
        str
            A data URL of a WOFF file; the same texts give the same one.
        """
        characters = "".join(sorted({each for text in texts for each in text}))
        if characters not in self._embedded:
            self._embedded[characters] = self._subset(characters)
        return self._embedded[characters]

    def _subset(self, characters: str) -> str:
        from fontTools import subset
        from fontTools.ttLib import TTFont

        options = subset.Options(flavor="woff", notdef_outline=True, recalc_timestamp=False)
        font = TTFont(self.path, fontNumber=self._face, recalcTimestamp=False)
        cutter = subset.Subsetter(options)
        cutter.populate(text=characters)
        cutter.subset(font)
        font.flavor = "woff"
        buffer = io.BytesIO()
        font.save(buffer)
        return "data:font/woff;base64," + base64.b64encode(buffer.getvalue()).decode()

    def wrapped(self, text: str, size: float, width: float) -> list[str]:
        """Break a text into lines.

        Parameters
        ----------
        text
            The text.
        size
            Size of the font in mm.
        width
            Width of a line in mm.

        Returns
        -------
        list[str]
            Its lines, broken at blanks, or between characters where a word alone is wider than a line.
        """
        lines = [""]
        for word in text.split(" "):
            longer = f"{lines[-1]} {word}".strip()
            if self.width(longer, size) <= width:
                lines[-1] = longer
                continue
            if lines[-1]:
                lines.append("")
            for each in word:
                if lines[-1] and self.width(lines[-1] + each, size) > width:
                    lines.append("")
                lines[-1] += each
        return lines
