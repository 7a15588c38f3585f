"""What is to be exported, and what a format is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lappet.core.problem import Problem
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits


def _untold(problem: Problem) -> None:
    """Tell nobody.

    Parameters
    ----------
    problem
        What there would be to tell.
    """


@dataclass(frozen=True)
class ExportRequest:
    """What is to be exported, and how.

    Parameters
    ----------
    caches
        The skin caches, at least one.
    target
        The file to write; its suffix says what it becomes.
    options
        What the user chose, by name; each format has names of its own, and those left out have its defaults.
    limits
        What reading may take.
    note
        Is told what the user should know of the files.
    """

    caches: tuple[Path, ...]
    target: Path
    options: Mapping[str, Any] = field(default_factory=dict)
    limits: ReadLimits = DEFAULT_LIMITS
    note: Callable[[Problem], None] = _untold


# Writes what a request says; returns the files.
ExportFunction = Callable[[ExportRequest], list[Path]]


@dataclass(frozen=True)
class Exporter:
    """A format that solved procedures are exported to.

    Parameters
    ----------
    suffix
        Of its files, in lower case, such as ".html".
    what
        What its files are, in a few words.
    load
        Imports and returns the function that writes one; it is called only when the format is chosen.
    options
        Names of the options that it understands.
    most_caches
        How many caches one file may hold.
    """

    suffix: str
    what: str
    load: Callable[[], ExportFunction]
    options: frozenset[str] = frozenset()
    most_caches: int = 1
