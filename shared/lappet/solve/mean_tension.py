"""The greatest tension of the skin as a mean over a stated area.

At one point it has no limit as the lattice becomes finer: a suture holds about a millimeter of tissue, and beside that
the tension rises. A mean over an area much larger than a bite has one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.labeled_surface import FaceOrigin, Surface

AREA = 25.0  # mm² of skin at rest (chosen: several bites)
_PLACES = 48  # discs looked at, those about the points of greatest tension


@dataclass(frozen=True)
class MeanTension:
    """The greatest mean tension.

    Parameters
    ----------
    tension
        Mean of the largest principal Cauchy stress in kPa.
    place
        Middle of the area, on the skin at rest in mm.
    area
        The area that the mean is over in mm²: less than asked for at the edge of the skin.
    error
        Estimated error of the tension in kPa, or None without an estimate.
    """

    tension: float
    place: tuple[float, float, float]
    area: float
    error: float | None = None


def greatest_mean_tension(surface: Surface, tension: NDArray[np.floating], area: float = AREA) -> MeanTension | None:
    """Find the disc of skin at rest over which the tension is greatest in the mean.

    Parameters
    ----------
    surface
        Surface of the epoch at rest.
    tension
        Tension at its points in kPa, shape (n,).
    area
        Area of the disc in mm².

    Returns
    -------
    MeanTension | None
        The mean, or None where no skin is left or the tension is not known.
    """
    skin = surface.triangles[surface.origin == FaceOrigin.SKIN].astype(np.int64)
    if not len(skin) or len(tension) != len(surface.points):
        return None
    corners = surface.points[skin]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2.0
    middles = corners.mean(axis=1)
    values = np.asarray(tension, np.float64)[skin].mean(axis=1)
    radius = math.sqrt(area / math.pi)
    waiting = values.copy()
    best: MeanTension | None = None
    for _ in range(_PLACES):
        place = middles[int(np.argmax(waiting))]
        squared = ((middles - place) ** 2).sum(axis=1)
        disc = squared <= radius * radius
        whole = float(areas[disc].sum())
        mean = float((areas[disc] * values[disc]).sum()) / max(whole, 1e-300)
        if best is None or mean > best.tension:
            best = MeanTension(mean, (float(place[0]), float(place[1]), float(place[2])), whole)
        waiting[squared <= (radius / 2.0) ** 2] = -np.inf
        if not np.isfinite(waiting).any():
            break
    return best
