"""Where insets stand in a panel, and what of the panel they cover."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, box

from lappet.plates.panel_drawing import PanelDrawing
from lappet.plates.strokes import Stroke

SHARE = 0.42  # of a panel's width and height
_EDGE = 0.6  # mm between an inset and the panel's border
_AIR = 0.8  # mm around an inset in which nothing of the panel is drawn


@dataclass(frozen=True, eq=False)
class InsetPlace:
    """The place of an inset.

    Parameters
    ----------
    middle
        Its middle in mm from the panel's, shape (2,).
    size
        Its width and height in mm.
    """

    middle: NDArray[np.float64]
    size: tuple[float, float]

    def covers(self, place: NDArray[np.float64]) -> bool:
        """Tell whether a place of the panel lies below it.

        Parameters
        ----------
        place
            The place in mm, shape (2,).

        Returns
        -------
        bool
            Whether it does.
        """
        return bool((np.abs(place - self.middle) < 0.5 * np.asarray(self.size) + _AIR).all())

    def outline_towards(self, site: NDArray[np.float64]) -> NDArray[np.float64]:
        """Find where the line from the middle to a place leaves the frame.

        Parameters
        ----------
        site
            A place outside in mm, shape (2,).

        Returns
        -------
        NDArray[np.float64]
            The place on the frame in mm, shape (2,).
        """
        way = site - self.middle
        share = np.min(0.5 * np.asarray(self.size) / np.maximum(np.abs(way), 1e-9))
        return self.middle + min(float(share), 1.0) * way


def inset_places(count: int, size: tuple[float, float], taken: NDArray[np.float64]) -> list[InsetPlace]:
    """Choose the corners that are least taken.

    Parameters
    ----------
    count
        How many insets there are, at most 4.
    size
        Width and height of the panel in mm.
    taken
        Places in mm of what is to be seen, shape (k, 2).

    Returns
    -------
    list[InsetPlace]
        A place for each.
    """
    own = (SHARE * size[0], SHARE * size[1])
    reach = 0.5 * (np.asarray(size) - np.asarray(own)) - _EDGE
    corners = [InsetPlace(reach * np.array(sign), own) for sign in ((1, -1), (-1, -1), (-1, 1), (1, 1))]
    weights = [sum(corner.covers(place) for place in taken) for corner in corners]
    return [corners[k] for k in np.argsort(weights, kind="stable")[:count]]


def uncovered(drawing: PanelDrawing, places: Sequence[InsetPlace]) -> PanelDrawing:
    """Leave out the lines, letters and arrows of a panel that its insets cover.

    Parameters
    ----------
    drawing
        The panel.
    places
        Where its insets stand.

    Returns
    -------
    PanelDrawing
        The panel around them.
    """
    if not places:
        return drawing
    strokes = list(drawing.strokes)
    for place in places:
        low, high = (place.middle + sign * (0.5 * np.asarray(place.size) + _AIR) for sign in (-1.0, 1.0))
        frame = box(*low, *high)
        outside = []
        for stroke in strokes:
            rest = LineString(stroke.points).difference(frame)
            for part in getattr(rest, "geoms", [rest]):
                if part.geom_type == "LineString" and part.length > 0.0:
                    outside.append(Stroke(stroke.kind, np.array(part.coords)))
        strokes = outside

    def free(at: NDArray[np.float64]) -> bool:
        return not any(place.covers(at) for place in places)

    return replace(
        drawing,
        strokes=tuple(strokes),
        letters=tuple(letter for letter in drawing.letters if free(letter.at)),
        arrows=tuple(way for way in drawing.arrows if all(free(at) for at in way)),
    )
