"""A unilateral cleft of the upper lip on the left, made of the uncleft body by moving its tissue.

What is done, all of it on the neutral body and fading out with distance:

- the lip's free border is drawn up into a notch below the nostril, so that red lines both margins of the cleft and the
  peak of Cupid's bow on its side stands too high;
- the two margins are moved apart;
- the base of the ala goes to the side, back and down, the ala's rim is flattened, and the foot of the columella goes to
  the other side;
- in a complete cleft a strip of skin up into the nostril is taken out first, and all is moved farther.

The movement is one of space, not of a surface: skin and underside go together, and the tissue keeps its layers.

Heights and widths are chosen: they were drawn after photographs and textbook plates, not measured.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.procedure import Point
from lappet.tissue.crop_mesh import Level

BORDER = 668.2  # z in mm between the lips
_SILL = 691.0  # z in mm of the nostril's floor
_FREE = 669.6  # z in mm of the upper lip's free border


@dataclass(frozen=True)
class Cleft:
    """A unilateral cleft lip.

    Parameters
    ----------
    line
        Where the line that opens lies: its x on the neutral body in mm.
    height
        How far the free border is drawn up at the line in mm.
    width
        Half width in mm of what is drawn up.
    rise
        How far the lip around it rises as well, Cupid's bow with it, in mm.
    apart
        How far each margin is moved aside in mm.
    open
        How much of that is left at the nostril's floor, as a share.
    nose
        How far nose and ala go, as a share of an incomplete cleft's.
    gap
        Half width in mm of the strip of skin that is taken out up to the nostril; 0 in an incomplete cleft.
    """

    line: float
    height: float
    width: float
    rise: float
    apart: float
    open: float
    nose: float
    gap: float

    def moved(self, neutral: NDArray[np.float64]) -> NDArray[np.float64]:
        """Move points of the neutral body.

        Parameters
        ----------
        neutral
            Points in or on the neutral body in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.float64]
            Displacements in mm, shape (n, 3).
        """
        x, y, z = neutral.T
        away = x - self.line  # positive towards the philtrum
        upper = _smooth((z - BORDER) / 1.2) * np.clip((y - 134.0) / 4.0, 0.0, 1.0)
        down = np.clip((_SILL - z) / (_SILL - _FREE), 0.0, 1.0)  # 0 at the sill, 1 at the free border
        notch = self.height * np.exp(-(np.abs(away / self.width) ** 3))
        around = self.rise * np.exp(-((away / np.where(away > 0.0, 8.0, 6.0)) ** 2))
        moved = np.zeros_like(neutral)
        wide = (self.open + (1.0 - self.open) * down**0.7) * np.exp(-((away / 9.0) ** 2))
        moved[:, 0] = self.apart * wide * np.tanh(away / 0.8) * upper * _smooth((_NOSTRIL + 4.0 - z) / 6.0)
        moved[:, 2] = (notch + around) * down * upper
        for middle, reach, way in _NOSE:
            moved += self.nose * _bump(neutral, middle, reach)[:, None] * np.array(way)
        return moved

    @property
    def taken_out(self) -> Level | None:
        """The level that is positive where skin of the neutral body is taken out; None for nothing."""
        if self.gap == 0.0:
            return None
        return lambda at: np.min(
            [self.gap - np.abs(at[:, 0] - self.line), _NOSTRIL - at[:, 2], at[:, 2] - BORDER - 0.4, at[:, 1] - 138.0],
            axis=0,
        )


_SULCUS, _CORNERS = 686.0, 19.0  # z and x in mm to which the upper lip is free
_NOSTRIL = 694.0  # z in mm to which a complete cleft opens: inside the nostril
# Middle, reach and way in mm: the base of the ala, the rim of the nostril, the foot of the columella.
_NOSE = (
    ((-11.0, 143.0, 689.5), (8.0, 9.0, 7.0), (-2.6, -2.0, -1.0)),
    ((-9.0, 155.0, 699.0), (7.0, 8.0, 7.0), (-2.0, -2.2, -1.6)),
    ((1.0, 150.0, 688.0), (6.0, 9.0, 7.0), (1.8, 0.0, 0.0)),
)
INCOMPLETE = Cleft(line=-8.0, height=8.0, width=3.0, rise=4.0, apart=2.2, open=0.0, nose=1.3, gap=0.0)
COMPLETE = Cleft(line=-8.0, height=2.5, width=3.0, rise=5.0, apart=2.4, open=0.6, nose=2.0, gap=1.4)


# Places of a repair on the neutral body in mm, on the left; on the model they lie where the cleft has moved them.
# Names: Millard's number in brackets. Lines run from the skin over the red to the free border.
CLEFT_MARKS: dict[str, tuple[Point, ...]] = {
    "cleft_peak_medial": ((-4.2, 152.6, 677.9),),  # 3: the peak of Cupid's bow beside the cleft
    "cleft_peak_lateral": ((-13.8, 149.4, 677.2),),  # 8: where the lateral lip's red begins to thin
    "cleft_apex": ((-11.8, 147.3, 682.3),),  # 9: the tip of the advancement flap
    "columella_base_cleft": ((-3.2, 149.0, 686.2),),
    "cleft_red_medial": (
        (-4.2, 153.0, 675.0),
        (-4.2, 151.5, 672.0),
        (-4.2, 148.5, 670.0),
        (-4.2, 146.6, 669.6),
    ),
    "cleft_red_lateral": (
        (-13.8, 149.2, 674.3),
        (-13.8, 148.0, 671.8),
        (-13.8, 144.8, 669.8),
        (-13.8, 143.0, 669.2),
    ),
    "alar_crease_cleft": ((-15.0, 142.8, 685.0), (-18.8, 137.5, 692.0)),  # 10
}


def in_lip(neutral: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Tell what of the upper lip lies on its own mucosa, not on bone.

    Parameters
    ----------
    neutral
        Points of the neutral body in mm, shape (k, 3).

    Returns
    -------
    NDArray[np.bool_]
        Whether each is in the free part of the lip, shape (k,).
    """
    x, _, z = neutral.T
    return np.asarray((z > BORDER) & (z < _SULCUS) & (np.abs(x) < _CORNERS))


def _smooth(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """From 0 to 1 with no corner."""
    t = np.clip(share, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def _bump(points: NDArray[np.float64], middle: ArrayLike, reach: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(np.exp(-(((points - np.asarray(middle)) / np.asarray(reach)) ** 2).sum(axis=1)))
