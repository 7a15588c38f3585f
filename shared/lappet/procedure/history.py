"""A procedure and its edits, with unlimited and exact undo and redo.

An edit makes a new procedure from an old one. Since procedures are immutable and share what did not change, the history
keeps every state itself: undo returns the very state from before, bit for bit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from lappet.procedure.procedure import Procedure


@dataclass(frozen=True)
class Edit:
    """An edit of a procedure; `lappet.procedure.edits` makes those that are used most.

    Parameters
    ----------
    label
        What an undo menu shows.
    apply
        Makes the new procedure from the old one; raises RefusedError where the edit makes no sense for it.
    """

    label: str
    apply: Callable[[Procedure], Procedure]


class History:
    """A procedure and the edits that led to it.

    Parameters
    ----------
    procedure
        The procedure to start from.
    """

    def __init__(self, procedure: Procedure) -> None:
        self._states = [procedure]
        self._labels: list[str] = []
        self._at = 0

    @property
    def procedure(self) -> Procedure:
        """The procedure as it is now."""
        return self._states[self._at]

    @property
    def undo_label(self) -> str | None:
        """Label of the edit that `undo` would take back, or None."""
        return self._labels[self._at - 1] if self._at else None

    @property
    def redo_label(self) -> str | None:
        """Label of the edit that `redo` would apply again, or None."""
        return self._labels[self._at] if self._at < len(self._labels) else None

    def do(self, edit: Edit) -> Procedure:
        """Apply an edit and drop what could be redone; one that is refused changes nothing.

        Parameters
        ----------
        edit
            The edit.

        Returns
        -------
        Procedure
            The procedure after it.

        Raises
        ------
        RefusedError
            If the edit is refused.
        """
        after = edit.apply(self.procedure)
        del self._states[self._at + 1 :], self._labels[self._at :]
        self._states.append(after)
        self._labels.append(edit.label)
        self._at += 1
        return after

    def undo(self) -> Procedure:
        """Go back to before the last edit.

        Returns
        -------
        Procedure
            The procedure as it was.

        Raises
        ------
        IndexError
            If there is nothing to undo.
        """
        if not self._at:
            raise IndexError("There is nothing to undo.")
        self._at -= 1
        return self.procedure

    def redo(self) -> Procedure:
        """Apply again what was undone last.

        Returns
        -------
        Procedure
            The procedure as it was before `undo`.

        Raises
        ------
        IndexError
            If there is nothing to redo.
        """
        if self._at == len(self._labels):
            raise IndexError("There is nothing to redo.")
        self._at += 1
        return self.procedure
