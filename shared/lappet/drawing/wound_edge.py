"""The edge of the wound as fine dark red lines, so that a closed wound still reads."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.epoch_searches import EpochSearches
from lappet.drawing.skin_source import SkinEpoch, SkinSource

EDGE_RADIUS = 0.1


class WoundEdge:
    """The lines along the lips of the wound; they follow the skin.

    `source` may be changed for one of equal epochs.

    Parameters
    ----------
    source
        The solved procedure.
    searches
        What is known of its epochs; None: nothing.
    """

    def __init__(self, source: SkinSource, searches: EpochSearches | None = None) -> None:
        self.source = source
        self._searches = EpochSearches() if searches is None else searches

    def knows(self, epoch: SkinEpoch) -> bool:
        """Tell whether the lips of an epoch were found before.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        bool
            Whether they were.
        """
        return self._searches.knows_chains(epoch)

    def tubes(self, time: float) -> tuple[list[NDArray[np.float64]], list[float]]:
        """Draw the lips of a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        tuple[list[NDArray[np.float64]], list[float]]
            Lines, shape (k, 3) each, and their radii, in mm.
        """
        epoch = self.source.epoch_at(time)
        points = self.source.positions(epoch, time)
        lines = [points[chain].astype(np.float64) for chain in self._searches.chains(epoch)]
        return lines, [EDGE_RADIUS] * len(lines)
