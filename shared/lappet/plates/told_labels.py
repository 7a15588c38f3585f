"""Which labels a panel has after those before it, and where they stood."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from lappet.plates.boundary_labels import PlacedLabel
from lappet.plates.letter_places import LetterPlaces


@dataclass(eq=False)
class ToldLabels:
    """Labels of the panels before.

    Parameters
    ----------
    keys
        Keys of the catalogue's labels that a panel has had.
    places
        Where each text was last.
    riding
        Whether a panel has the same labels as the one before, as far as what they name is still seen; otherwise it has
        those that none before it had.
    variants
        Names of operations drawn over the panels that a panel has had.
    letters
        How the letters of corners stood.
    """

    keys: set[str] = field(default_factory=set)
    places: dict[str, PlacedLabel] = field(default_factory=dict)
    riding: bool = False
    variants: set[str] = field(default_factory=set)
    letters: LetterPlaces = field(default_factory=LetterPlaces)

    def choose(self, keys: Sequence[str]) -> list[str]:
        """Choose the labels of a panel.

        Parameters
        ----------
        keys
            Those of what is seen.

        Returns
        -------
        list[str]
            Those that it has.
        """
        chosen = [key for key in keys if (key in self.keys) is self.riding]
        self.keys = set(chosen) if self.riding else {*self.keys, *chosen}
        return chosen
