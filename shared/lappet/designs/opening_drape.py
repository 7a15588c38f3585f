"""Drape a flat design around an opening of the skin, as a mouth is: distances from its border stay what they are.

In the plane the opening is a slit. A point of the plane lies at some distance beside the slit's nearest point: there,
at the same share of the lower or upper border of the opening, a straight line starts along the skin, square to the
border, and is walked that far. About the ends of the slit lines are walked from a place of the skin beside them, as in
`lappet.designs.geodesic_drape`; between the two ways points are blended. On a plane all of it changes nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lappet.designs.flat_curves import length
from lappet.designs.geodesic_drape import Misfit, walked
from lappet.procedure import Point
from lappet.tissue.skin_sheet import SkinSheet

_LIP, _CORNER = 0.6, 0.95  # of half the slit: what is nearer to the middle, or farther, is mapped in one of both ways
_LEVEL = 1e-6  # mm beside the slit that are none
_BESIDE = 3.0  # mm from the slit: nearer to it a corner's map has no share, at twice as much all of it
_ASIDE = 3.0  # mm from a corner of the opening to where the skin beside it is walked from


class OpeningDrape:
    """A `project` for designs that go round an opening.

    Parameters
    ----------
    skin
        The skin.
    border
        Points of the opening's border in order in mm, and vectors from them into the skin, each of shape (n, 3).
    slit
        Both ends of the slit in the plane in mm.
    normal
        Outwards from the plane, shape (3,).
    """

    def __init__(
        self,
        skin: SkinSheet,
        border: tuple[NDArray[np.float64], NDArray[np.float64]],
        slit: Sequence[Point],
        normal: NDArray[np.float64],
    ) -> None:
        self._skin = skin
        self._start, self._end = (np.array(end, np.float64) for end in (slit[0], slit[-1]))
        way = self._end - self._start
        self._long = float(np.linalg.norm(way))
        self._along = way / self._long
        self._up = np.cross(normal, self._along)
        self._lower, self._upper = self._lips(*border)
        self.misfit: Misfit | None = None

    @property
    def width(self) -> float:
        """Length in mm of the lower border, from one corner of the opening to the other."""
        return length(self._lower[0])

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
        x, y = (plane - self._start) @ self._along - 0.5 * self._long, (plane - self._start) @ self._up
        y[np.abs(y) < _LEVEL] = 0.0
        half = 0.5 * self._long
        share = np.clip((np.abs(x) / half - _LIP) / (_CORNER - _LIP), 0.0, 1.0)  # of a corner's map
        # Beside the slit a line from a corner would lead through the opening.
        share = np.where(np.abs(x) < half, share * np.clip((np.abs(y) - _BESIDE) / _BESIDE, 0.0, 1.0), share)
        found = np.zeros((len(plane), 3))
        share = share[:, None]
        lip = share[:, 0] < 1.0
        found[lip] += (1.0 - share[lip]) * self._beside_border(x[lip], y[lip])
        for side in (-1.0, 1.0):
            corner = (share[:, 0] > 0.0) & (x * side > 0.0)
            found[corner] += share[corner] * self._about_corner(side, x[corner], y[corner])
        return self._skin.place(found)

    def _beside_border(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Walk square to the border, from the place at the same share of its length."""
        start, tangent, into = self._on_border(np.clip(x / self._long + 0.5, 0.0, 1.0), y > 0.0)
        _, normals = self._skin.at(start)
        across = _unit(np.cross(normals, tangent))
        across *= np.where(np.einsum("ij,ij->i", across, into) > 0.0, 1.0, -1.0)[:, None]
        return self._walked(start, normals, across, np.abs(y))

    def _about_corner(self, side: float, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Walk from a place on the skin beside a corner: at the corner itself the border turns too sharply."""
        corner = self._lower[0][0 if side < 0.0 else -1] + side * _ASIDE * self._along
        start, normals = self._skin.at(corner)
        ahead = self._along - (self._along @ normals[0]) * normals[0]
        ahead /= np.linalg.norm(ahead)
        up = np.cross(normals[0], ahead)
        up = up if up @ self._up > 0.0 else -up
        offset = np.column_stack([x - side * (0.5 * self._long + _ASIDE), y])
        far = np.linalg.norm(offset, axis=1)
        along = offset / np.maximum(far, 1e-300)[:, None] @ np.stack([ahead, up])
        count = (len(x), 1)
        return self._walked(np.tile(start, count), np.tile(normals, count), along, far)

    def _walked(
        self,
        start: NDArray[np.float64],
        normals: NDArray[np.float64],
        along: NDArray[np.float64],
        far: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        here, left = walked(self._skin, start, normals, along, far)
        if len(here):
            self._note(here, left, far)
        return here

    def _on_border(
        self, shares: NDArray[np.float64], upper: NDArray[np.bool_]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Points of the border, vectors along it and vectors from it into the skin, each (k, 3)."""
        at, along, into = (np.empty((len(shares), 3)) for _ in range(3))
        for (lip, inwards), chosen in ((self._lower, ~upper), (self._upper, upper)):
            way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(lip, axis=0), axis=1))])
            s = shares[chosen] * way[-1]
            at[chosen], into[chosen] = _interpolated(lip, way, s), _interpolated(inwards, way, s)
            along[chosen] = _interpolated(lip, way, s + 1.0) - _interpolated(lip, way, s - 1.0)
        return at, along, into

    def _lips(
        self, border: NDArray[np.float64], into: NDArray[np.float64]
    ) -> tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]:
        """The lower and the upper border with their vectors, both from the slit's start to its end."""
        along = (border - border.mean(axis=0)) @ self._along
        first, last = int(along.argmin()), int(along.argmax())
        count = len(border)
        one = (first + np.arange((last - first) % count + 1)) % count
        other = (first - np.arange((first - last) % count + 1)) % count
        lips = (border[one], into[one]), (border[other], into[other])
        return lips if (lips[0][0] @ self._up).mean() < (lips[1][0] @ self._up).mean() else lips[::-1]

    def _note(self, here: NDArray[np.float64], left: NDArray[np.float64], far: NDArray[np.float64]) -> None:
        k = int(left.argmax())
        if left[k] > 1e-6 and (self.misfit is None or left[k] > self.misfit.missing):
            x, y, z = here[k]
            self.misfit = Misfit((float(x), float(y), float(z)), float(left[k]), float(1.0 - left[k] / far[k]))


def _interpolated(points: NDArray[np.float64], way: NDArray[np.float64], s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (k, 3) between those of points (n, 3), at ways s (k,); those of the ends beyond them."""
    return np.column_stack([np.interp(s, way, points[:, k]) for k in range(3)])


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None]
