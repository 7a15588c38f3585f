"""Where material points of the skin come to lie in a frame."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_source import SkinSource
from lappet.drawing.suture_bites import bites_at, carried
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.plate_scene import followed

_STEP = 0.5  # mm between two places of a line along the skin


@dataclass(frozen=True, eq=False)
class SkinAnchors:
    """The skin of a solved procedure, on which places are followed.

    Parameters
    ----------
    source
        The solved procedure.
    """

    source: SkinSource

    def on_skin(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Find the nearest places on the whole skin at rest.

        Parameters
        ----------
        places
            Places in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Places on the skin in mm, shape (k, 3).
        """
        epoch = self.source.epochs[0]
        rest = self.source.rest(epoch)
        return carried(bites_at(rest, epoch.triangles[epoch.origin == FaceOrigin.SKIN], places), rest)

    def at(
        self, places: NDArray[np.float64], time: float, last_place: bool = False
    ) -> tuple[NDArray[np.float64], bool]:
        """Follow places to a frame.

        Parameters
        ----------
        places
            Places on the skin at rest in mm, shape (k, 3).
        time
            Time code of the frame.
        last_place
            Whether places whose tissue is gone stay where it was last.

        Returns
        -------
        tuple[NDArray[np.float64], bool]
            Where they lie in mm, shape (k, 3), NaN where their tissue is gone; and whether some of it is.
        """
        found = followed(self.source, places, time)
        gone = ~np.isfinite(found).all(axis=1)
        any_gone = bool(gone.any())
        if any_gone and last_place:
            for earlier in reversed([each for each in self.source.frames if each < time]):
                before = followed(self.source, places[gone], earlier)
                known = np.isfinite(before).all(axis=1)
                found[np.flatnonzero(gone)[known]] = before[known]
                gone[np.flatnonzero(gone)[known]] = False
                if not gone.any():
                    break
        return found, any_gone

    def line(self, anchors: NDArray[np.float64]) -> NDArray[np.float64]:
        """Draw a line on the whole skin at rest through some places.

        Parameters
        ----------
        anchors
            Places in mm, shape (k, 3), at least two.

        Returns
        -------
        NDArray[np.float64]
            Places on the skin in mm, shape (n, 3), about half a millimetre apart.
        """
        parts = []
        for begin, end in pairwise(anchors):
            count = max(int(np.ceil(float(np.linalg.norm(end - begin)) / _STEP)), 1)
            share = np.linspace(0.0, 1.0, count + 1)[:, None]
            parts.append((1.0 - share) * begin + share * end)
        joined = np.vstack([parts[0], *(part[1:] for part in parts[1:])])
        return self.on_skin(joined)
