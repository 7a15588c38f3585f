"""The captions and labels of plates in the languages of the catalogue, or in a file of the user's."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

LANGUAGES = ("en", "de", "fr", "es", "zh")


@dataclass(frozen=True)
class PlateWords:
    """What plates say in one language.

    Parameters
    ----------
    language
        Its code, such as "en"; a file's name for words of one's own.
    texts
        What it says for each key of the catalogue.
    """

    language: str
    texts: dict[str, str]

    def __call__(self, key: str, **values: object) -> str:
        """Say something.

        Parameters
        ----------
        key
            A key of the catalogue.
        **values
            What is put in place of the names in braces.

        Returns
        -------
        str
            The text.
        """
        return self.texts[key].format(**values)


def plate_words(language: str, own: Path | None = None) -> PlateWords:
    """Read the words of a language.

    Parameters
    ----------
    language
        One of `LANGUAGES`.
    own
        A TOML file whose keys take the place of the catalogue's.

    Returns
    -------
    PlateWords
        The words.

    Raises
    ------
    RefusedError
        If the file cannot be read, or has a key that the catalogue does not have, or no text for one.
    """
    catalogue = files("lappet.plates") / "languages"
    texts = tomllib.loads((catalogue / f"{language}.toml").read_text(encoding="utf-8"))
    if own is None:
        return PlateWords(language, texts)
    try:
        given = tomllib.loads(own.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise refused(ProblemCode.PLATE_CAPTIONS, own, reason=str(error)) from error
    for key, text in given.items():
        if key not in texts or not isinstance(text, str):
            raise refused(ProblemCode.PLATE_CAPTION_KEY, own, key, known=", ".join(texts))
        try:
            text.format(time=0, count=0, letter="", caption="")
        except (KeyError, IndexError, ValueError) as error:
            raise refused(ProblemCode.PLATE_CAPTIONS, own, reason=f"{key}: {error}") from error
    return PlateWords(own.stem, {**texts, **given})
