"""The texts of the problems by code: read from `core/texts/*.toml`, filled with the values of one case."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from lappet.core.problem_code import ProblemCode

TEXTS = Path(__file__).with_name("texts")


@dataclass(frozen=True)
class ProblemText:
    """What is said for a code. title: for lists. message, remedy: sentences with fields in braces."""

    title: str
    message: str
    remedy: str


@cache
def catalogue() -> dict[ProblemCode, ProblemText]:
    """Return the texts of every code. A code that no file knows, or that two files know, raises KeyError."""
    found: dict[ProblemCode, ProblemText] = {}
    for file in sorted(TEXTS.glob("*.toml")):
        for value, entry in tomllib.loads(file.read_text(encoding="utf-8")).items():
            code = ProblemCode(value)
            if code in found:
                raise KeyError(f"{file.name}: {value} is there twice")
            found[code] = ProblemText(**entry)
    return found


def texts(code: ProblemCode, fields: dict[str, object]) -> tuple[str, str]:
    """Return the message and the remedy of a code, filled with these fields."""
    entry = catalogue()[code]
    return entry.message.format(**fields), entry.remedy.format(**fields)
