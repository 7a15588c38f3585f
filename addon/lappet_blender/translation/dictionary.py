"""The interface's messages in other languages, as Blender takes them."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from lappet.designs.library import DESIGNS

FILES = ("labels.toml", "tips.toml", "flaps.toml")
# The languages of each row of the files, in order, with the names that versions of Blender give them.
LANGUAGES = (("de", ("de_DE",)), ("fr", ("fr_FR",)), ("es", ("es", "es_ES")), ("zh", ("zh_HANS", "zh_CN")))
CONTEXTS = ("*", "Operator", "Lappet")  # of fields and tips; of buttons; of panels


@cache
def messages() -> Mapping[str, tuple[str, ...]]:
    """The translations of each message, in the order of `LANGUAGES`."""
    found: dict[str, tuple[str, ...]] = {}
    for name in FILES:
        read = tomllib.loads((Path(__file__).parent / name).read_text(encoding="utf-8"))
        found |= {message: tuple(texts) for message, texts in read.items()}
    return found | _edits(found)


def _edits(known: Mapping[str, tuple[str, ...]]) -> dict[str, tuple[str, ...]]:
    """What the operators are called that edit a laid flap: the verb and the flap, whatever a language does to it."""
    edit = known["Edit"]
    return {
        f"Edit {design.title}": tuple(f"{verb}: {name}" for verb, name in zip(edit, known[design.title], strict=True))
        for design in DESIGNS.values()
    }


def blender_dictionary() -> dict[str, dict[tuple[str, str], str]]:
    """What `bpy.app.translations.register` takes: {locale: {(context, message): translation}}."""
    return {
        locale: {(context, message): texts[column] for message, texts in messages().items() for context in CONTEXTS}
        for column, (_, locales) in enumerate(LANGUAGES)
        for locale in locales
    }
