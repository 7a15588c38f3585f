"""What lessons say, in the languages of the plates."""

from __future__ import annotations

import tomllib
from importlib.resources import files

from lappet.plates.plate_words import LANGUAGES, plate_words

_OF_PLATES = ("step.", "map.")


def lesson_words() -> dict[str, dict[str, str]]:
    """Read the words of lessons; steps and maps are named as on plates.

    Returns
    -------
    dict[str, dict[str, str]]
        By the code of the language, what it says for each key.
    """
    catalogue = files("lappet.export") / "lesson_words"
    words = {}
    for language in LANGUAGES:
        own = tomllib.loads((catalogue / f"{language}.toml").read_text(encoding="utf-8"))
        plates = plate_words(language).texts
        words[language] = {**{key: plates[key] for key in plates if key.startswith(_OF_PLATES)}, **own}
    return words
