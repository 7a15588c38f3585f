"""Drape a flat design over any skin: straight lines from its middle stay straight and as long as they were."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.procedure import Point
from lappet.tissue.skin_sheet import SkinSheet

STEP = 0.5  # mm: a line is walked in such steps
REACHED = 0.05  # mm beside a point that a line should reach
_WALKS = 30


@dataclass(frozen=True)
class Misfit:
    """Where a line of a design could not be walked to its end.

    Parameters
    ----------
    point
        Where it ended in mm.
    missing
        How much of it was left in mm.
    share
        Share of it that was walked, 0 to 1.
    """

    point: Point
    missing: float
    share: float


class GeodesicDrape:
    """A `project` for designs drawn in the skin's tangent plane at a point.

    A point of the plane goes where the geodesic that starts towards it has come after its distance from the middle: the
    exponential map of the surface, by steps of `STEP`. On a sphere it is `lappet.tissue.dome.draped`. A line that meets
    the skin's border ends there; `misfit` tells of the one that lacks most.

    Parameters
    ----------
    skin
        The skin.
    center
        A point in mm, shape (3,); the plane touches the skin where that is closest to it.
    """

    def __init__(self, skin: SkinSheet, center: ArrayLike) -> None:
        self._skin = skin
        points, normals = skin.at(center)
        self.middle, self.normal = points[0], normals[0]
        self._worst: Misfit | None = None
        self._known: dict[bytes, NDArray[np.float64]] = {}

    @property
    def misfit(self) -> Misfit | None:
        """The line, of all draped so far, that lacks most of its length; None where all were walked to their ends."""
        return self._worst

    def __call__(self, plane: NDArray[np.float64]) -> NDArray[np.float64]:
        """Drape points of the plane.

        Parameters
        ----------
        plane
            Points of the plane in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Points on the skin in mm, shape (k, 3).
        """
        known = [self._known.get(point.tobytes()) for point in plane + 0.0] if self._known else []
        if known and all(point is not None for point in known):
            return np.array(known)
        return self._walked(plane)

    def prepare(self, plane: NDArray[np.float64]) -> None:
        """Drape points that will be asked for, all at once: a design asks for a few at a time, which takes longer.

        Parameters
        ----------
        plane
            Points of the plane in mm, shape (k, 3).
        """
        points = np.unique(plane, axis=0)
        points = points + 0.0  # a zero has one sign
        self._known |= {point.tobytes(): there for point, there in zip(points, self._walked(points), strict=True)}

    def _walked(self, plane: NDArray[np.float64]) -> NDArray[np.float64]:
        """Drape points of the plane (k, 3) by walking."""
        offsets = self._in_plane(plane - self.middle)
        far = np.linalg.norm(offsets, axis=1)
        along = offsets / np.maximum(far, 1e-300)[:, None]
        start = np.tile(self.middle, (len(plane), 1)), np.tile(self.normal, (len(plane), 1))
        here, left = walked(self._skin, *start, along, far)
        self._note(here, left, far)
        return here

    def unrolled(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Find the places in the plane that are draped onto points of the skin.

        Parameters
        ----------
        points
            Points on the skin in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Vectors in the plane from the middle in mm, shape (k, 3): by Newton's method with the plane's own metric,
            which ends after a fixed number of steps where a point cannot be reached.
        """
        worst, self._worst, flat = self._worst, None, self._in_plane(points - self.middle)
        for _ in range(_WALKS):
            off = self._in_plane(points - self(self.middle + flat))
            if np.linalg.norm(off, axis=1).max() < REACHED:
                break
            flat = flat + off
        self._worst = worst
        return flat

    def _in_plane(self, ways: NDArray[np.float64]) -> NDArray[np.float64]:
        return ways - np.outer(ways @ self.normal, self.normal)

    def _note(self, here: NDArray[np.float64], left: NDArray[np.float64], far: NDArray[np.float64]) -> None:
        k = int(left.argmax())
        if left[k] > 1e-6 and (self._worst is None or left[k] > self._worst.missing):
            x, y, z = here[k]
            self._worst = Misfit((float(x), float(y), float(z)), float(left[k]), float(1.0 - left[k] / far[k]))


def walked(
    skin: SkinSheet,
    start: NDArray[np.float64],
    normals: NDArray[np.float64],
    along: NDArray[np.float64],
    far: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Walk straight on along the skin, from several points at once.

    Parameters
    ----------
    skin
        The skin.
    start
        Where each walk starts, on the skin, in mm, shape (k, 3).
    normals
        Outwards from the skin there, shape (k, 3).
    along
        Unit vectors along the skin, shape (k, 3).
    far
        Length of each walk in mm, shape (k,).

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]]
        Where each ended in mm, shape (k, 3), and how much of it was left at the skin's border in mm, shape (k,).
    """
    here, normal, along = start.copy(), normals.copy(), along.copy()
    left, walking = far.copy(), far > 1e-9
    while walking.any():
        k = np.flatnonzero(walking)
        ahead = along[k] - np.einsum("ij,ij->i", along[k], normal[k])[:, None] * normal[k]
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-300)[:, None]
        step = np.minimum(STEP, left[k])
        points, normals = skin.at(here[k] + step[:, None] * ahead)
        gained = np.einsum("ij,ij->i", points - here[k], ahead)
        stopped = gained < 0.5 * step  # the border is in the way
        walking[k[stopped]] = False
        on = k[~stopped]
        along[on] = points[~stopped] - here[on]
        here[on], normal[on] = points[~stopped], normals[~stopped]
        left[on] -= step[~stopped]
        walking[on] = left[on] > 1e-9
    return here, left


def draped_on(skin: SkinSheet, center: ArrayLike) -> GeodesicDrape:
    """Make a `project` for designs drawn in the skin's tangent plane at a point.

    Parameters
    ----------
    skin
        The skin.
    center
        A point in mm, shape (3,); the plane touches the skin where that is closest to it.

    Returns
    -------
    GeodesicDrape
        A function from points of the plane in mm, shape (k, 3), to points on the skin in mm, shape (k, 3).
    """
    return GeodesicDrape(skin, center)
