"""Landmarks by their anatomical names, as places on the neutral body.

x runs to the patient's right, y to the front, z up, in mm. Those of the face are Farkas's. A place is laid on the
closest skin; paired ones are mirrored and named by their side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lappet.models.body_surface import BodySurface
from lappet.models.cleft import CLEFT_MARKS
from lappet.models.region import Ellipsoid
from lappet.procedure import Landmark, Point

_OFF_SKIN = 6.0  # mm: farther than this from the model's skin a landmark is not on it
_CLEAR = 2.0  # mm from the model's border

MIDLINE: dict[str, Point] = {
    "vertex": (0.0, 50.0, 841.6),
    "trichion": (0.0, 130.7, 798.0),
    "glabella": (0.0, 143.9, 756.0),
    "nasion": (0.0, 141.3, 735.9),
    "rhinion": (0.0, 148.8, 717.9),
    "pronasale": (0.0, 159.6, 699.8),
    "subnasale": (0.0, 149.3, 686.0),
    "labrale_superius": (0.0, 153.5, 677.8),
    "labrale_inferius": (0.0, 149.6, 658.5),
    "sublabiale": (0.0, 141.7, 650.6),
    "pogonion": (0.0, 142.2, 643.0),
    "menton": (0.0, 131.0, 628.0),
    "suprasternal_notch": (0.0, 60.0, 545.0),
    "umbilicus": (0.0, 134.0, 190.0),
}
LEFT: dict[str, Point] = {
    "endocanthion": (-18.0, 124.0, 730.4),
    "exocanthion": (-43.0, 121.0, 731.5),
    "palpebrale_superius": (-29.4, 131.5, 738.7),
    "palpebrale_inferius": (-31.0, 132.8, 728.5),
    "superciliare": (-32.0, 139.0, 752.0),
    "frontotemporale": (-60.0, 113.0, 765.0),
    "alare": (-18.0, 139.5, 697.0),
    "subalare": (-11.0, 143.0, 689.5),
    "crista_philtri": (-5.0, 152.5, 678.0),
    "cheilion": (-25.0, 137.0, 667.5),
    "zygion": (-72.0, 82.0, 717.0),
    "gonion": (-56.0, 60.0, 645.0),
    "tragion": (-73.0, 50.0, 710.0),
    "otobasion_inferius": (-72.0, 48.0, 690.0),
    "superaurale": (-84.0, 22.0, 738.0),
    "thelion": (-99.2, 149.5, 392.3),
    "third_metacarpal_head": (-503.0, 260.0, 156.0),
    "fifth_metacarpal_head": (-514.0, 223.0, 140.0),
}


@dataclass(frozen=True)
class Place:
    """A landmark of a model.

    Parameters
    ----------
    name
        Its name, with the side.
    point
        Where it lies on the shaped body in mm.
    """

    name: str
    point: Point

    def event(self) -> Landmark:
        """Make the landmark of a procedure.

        Returns
        -------
        Landmark
            The event.
        """
        return Landmark(self.name, (self.point,), self.name.replace("_", " "))


def landmarks_on(skin: BodySurface, region: Ellipsoid) -> tuple[Place, ...]:
    """Find the landmarks that lie on a model, not at its border.

    Parameters
    ----------
    skin
        The skin of the model.
    region
        The region that it was cut out with.

    Returns
    -------
    tuple[Place, ...]
        The landmarks.
    """
    named = dict(MIDLINE)
    for name, (x, y, z) in LEFT.items():
        named |= {f"{name}_left": (x, y, z), f"{name}_right": (-x, y, z)}
    given = np.array(list(named.values()))
    points, away = skin.carried(given)
    inside = (region.level(given) < -_CLEAR) & (away < _OFF_SKIN)
    return tuple(
        Place(name, (float(x), float(y), float(z)))
        for name, (x, y, z), on in zip(named, np.round(points, 4), inside, strict=True)
        if on
    )


def cleft_landmarks(skin: BodySurface) -> tuple[Landmark, ...]:
    """Find the landmarks of a cleft lip's repair.

    Parameters
    ----------
    skin
        The skin of a model with a cleft.

    Returns
    -------
    tuple[Landmark, ...]
        The landmarks; those with several points are lines.
    """
    marks = []
    for name, places in CLEFT_MARKS.items():
        points = np.round(skin.carried(places)[0], 4)
        marks.append(
            Landmark(name, tuple((float(x), float(y), float(z)) for x, y, z in points), name.replace("_", " "))
        )
    return tuple(marks)
