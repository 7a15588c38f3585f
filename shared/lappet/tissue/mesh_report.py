"""What was found in a mesh, what was repaired, and what was taken of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum


class Stage(StrEnum):
    """When something was noted."""

    FOUND = "found"
    REPAIRED = "repaired"
    TAKEN = "taken"


@dataclass(frozen=True)
class Note:
    """One row of the report.

    Parameters
    ----------
    stage
        Whether it was found, repaired or taken.
    what
        What it is about, in a few words: the row's name.
    value
        What there is to say about it.
    """

    stage: Stage
    what: str
    value: str


@dataclass(frozen=True)
class MeshReport:
    """Everything that was noted while tissue was made of a mesh, in its order.

    Parameters
    ----------
    notes
        The rows.
    """

    notes: tuple[Note, ...] = ()

    def __iter__(self) -> Iterator[Note]:
        """Go through the rows."""
        return iter(self.notes)

    def __contains__(self, what: object) -> bool:
        """Tell whether there is a row of this name."""
        return any(note.what == what for note in self.notes)

    def __getitem__(self, what: str) -> str:
        """Read the value of the first row of this name.

        Raises
        ------
        KeyError
            If there is none.
        """
        for note in self.notes:
            if note.what == what:
                return note.value
        raise KeyError(what)

    @property
    def lines(self) -> list[str]:
        """A line of text for each row."""
        return [f"{note.stage}: {note.what}: {note.value}" for note in self.notes]

    def with_notes(self, notes: Iterable[Note]) -> MeshReport:
        """Add rows.

        Parameters
        ----------
        notes
            The rows.

        Returns
        -------
        MeshReport
            The longer report.
        """
        return MeshReport((*self.notes, *notes))


def found(what: str, value: object) -> Note:
    """Note something that was found.

    Parameters
    ----------
    what
        Name of the row.
    value
        Its value.

    Returns
    -------
    Note
        The row.
    """
    return Note(Stage.FOUND, what, str(value))


def repaired(what: str, value: object) -> Note:
    """Note something that was repaired.

    Parameters
    ----------
    what
        Name of the row.
    value
        Its value.

    Returns
    -------
    Note
        The row.
    """
    return Note(Stage.REPAIRED, what, str(value))


def taken(what: str, value: object) -> Note:
    """Note something about what was taken.

    Parameters
    ----------
    what
        Name of the row.
    value
        Its value.

    Returns
    -------
    Note
        The row.
    """
    return Note(Stage.TAKEN, what, str(value))
