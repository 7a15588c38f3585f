"""The texts of the problems by code: read from `core/texts/*.toml`, filled with the values of one case."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from string import Formatter
from typing import Literal

from lappet.core.problem_code import ProblemCode

Severity = Literal["error", "warning", "note"]
TEXTS = Path(__file__).with_name("texts")


@dataclass(frozen=True)
class ProblemText:
    """What is said for a code.

    Parameters
    ----------
    title
        Title for lists.
    message
        Sentence with fields in braces.
    remedy
        Sentence with fields in braces.
    severity
        "error", "warning" or "note".
    advice
        What the documents say besides.
    """

    title: str
    message: str
    remedy: str
    severity: Severity = "error"
    advice: str = ""

    @property
    def names_prim(self) -> bool:
        """Whether the message itself says which prim or file it is about."""
        return any(field == "prim" for _, field, _, _ in Formatter().parse(self.message))


@cache
def catalogue() -> dict[ProblemCode, ProblemText]:
    """Read the texts of every code.

    Returns
    -------
    dict[ProblemCode, ProblemText]
        The texts by code.

    Raises
    ------
    KeyError
        If no file knows a code, or two files know it.
    """
    found: dict[ProblemCode, ProblemText] = {}
    for file in sorted(TEXTS.glob("*.toml")):
        for value, entry in tomllib.loads(file.read_text(encoding="utf-8")).items():
            code = ProblemCode(value)
            if code in found:
                raise KeyError(f"{file.name}: {value} is there twice")
            found[code] = ProblemText(**entry)
    return found


def text_of(code: ProblemCode) -> ProblemText:
    """Look up the texts of a code.

    Parameters
    ----------
    code
        The code.

    Returns
    -------
    ProblemText
        The texts.
    """
    return catalogue()[code]
