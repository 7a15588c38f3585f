"""What was found about one part of an installation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from lappet.core.problem import ProblemsError

State = Literal["ok", "missing", "broken"]


@dataclass(frozen=True)
class Finding:
    """One part of an installation.

    Parameters
    ----------
    name
        What it is, as "daemon".
    state
        "ok"; "missing" for what Lappet can do without; "broken" for what it needs.
    value
        What is there, or what is wrong.
    remedy
        How to get it, where it is not there.
    """

    name: str
    state: State
    value: str
    remedy: str = ""


def broken(name: str, error: ProblemsError | OSError) -> Finding:
    """Make the finding of what raised an error.

    Parameters
    ----------
    name
        What it is.
    error
        The error.

    Returns
    -------
    Finding
        The finding, with the first problem's remedy where it has one.
    """
    if isinstance(error, OSError):
        return Finding(name, "broken", f"{error.strerror or error}: {error.filename or ''}".rstrip(": "))
    first = error.problems[0]
    return Finding(name, "broken", first.message, first.remedy)
