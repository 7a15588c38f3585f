"""A unilateral cleft of the upper lip on the left, made of the uncleft body by moving its skin.

What is done to the skin, all of it on the neutral body and fading out with distance:

- the lip's free border is drawn up into a notch below the nostril, so that red lines both margins of the cleft and the
  peak of Cupid's bow on its side stands too high;
- the two margins are moved apart;
- the base of the ala goes to the side, back and down, the ala's rim is flattened, and the foot of the columella goes to
  the other side;
- in a complete cleft the skin between the notch and the nostril is taken out, and all of it is moved farther.

Heights and widths are chosen: they were drawn after photographs and textbook plates, not measured.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

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
        x in mm on the neutral body of the line that opens.
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
        """Move the skin of the neutral body.

        Parameters
        ----------
        neutral
            Vertices of the neutral body in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.float64]
            Displacements in mm, shape (n, 3).
        """
        x, y, z = neutral.T
        away = x - self.line  # positive towards the philtrum
        upper = _smooth((z - BORDER) / 1.2) * np.clip((y - 138.0) / 4.0, 0.0, 1.0)
        down = np.clip((_SILL - z) / (_SILL - _FREE), 0.0, 1.0)  # 0 at the sill, 1 at the free border
        notch = self.height * np.exp(-(np.abs(away / self.width) ** 3))
        around = self.rise * np.exp(-((away / np.where(away > 0.0, 8.0, 6.0)) ** 2))
        moved = np.zeros_like(neutral)
        moved[:, 0] = self.apart * (self.open + (1.0 - self.open) * down**0.7) * np.tanh(away / 0.8) * np.exp(-((away / 9.0) ** 2)) * upper * _smooth((_NOSTRIL + 4.0 - z) / 6.0)
        moved[:, 2] = (notch + around) * down * upper
        for middle, reach, way in _NOSE:
            moved += self.nose * _bump(neutral, middle, reach)[:, None] * np.array(way)
        return moved

    @property
    def taken_out(self) -> Level | None:
        """The level that is positive where skin is taken out, on vertices of the neutral body; None for nothing."""
        if self.gap == 0.0:
            return None
        return lambda at: np.min(
            [self.gap - np.abs(at[:, 0] - self.line), _NOSTRIL - at[:, 2], at[:, 2] - BORDER - 0.4, at[:, 1] - 138.0],
            axis=0,
        )


_NOSTRIL = 694.0  # z in mm to which a complete cleft opens: inside the nostril
# Middle, reach and way in mm: the base of the ala, the rim of the nostril, the foot of the columella.
_NOSE = (
    ((-11.0, 143.0, 689.5), (8.0, 9.0, 7.0), (-2.6, -2.0, -1.0)),
    ((-9.0, 155.0, 699.0), (7.0, 8.0, 7.0), (-2.0, -2.2, -1.6)),
    ((1.0, 150.0, 688.0), (6.0, 9.0, 7.0), (1.8, 0.0, 0.0)),
)
INCOMPLETE = Cleft(line=-8.0, height=8.0, width=3.0, rise=4.0, apart=2.2, open=0.0, nose=1.3, gap=0.0)
COMPLETE = Cleft(line=-8.0, height=7.0, width=3.0, rise=4.0, apart=3.0, open=0.5, nose=2.0, gap=0.8)


def body_scale(points: NDArray[np.float64], neutral: NDArray[np.float64], mouth: ArrayLike) -> float:
    """Measure how large a shaped body's mouth is beside the neutral one's: a cleft is scaled with it.

    Parameters
    ----------
    points
        Vertices of the shaped body in mm, shape (n, 3).
    neutral
        The same of the neutral body in mm, shape (n, 3).
    mouth
        The two corners of the mouth on the neutral body in mm, shape (2, 3).

    Returns
    -------
    float
        The ratio of the distances between the corners.
    """
    corners = [int(np.linalg.norm(neutral - corner, axis=1).argmin()) for corner in np.asarray(mouth, np.float64)]
    apart = [float(np.linalg.norm(each[corners[1]] - each[corners[0]])) for each in (points, neutral)]
    return apart[0] / apart[1]


def _smooth(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """From 0 to 1 with no corner."""
    t = np.clip(share, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))


def _bump(points: NDArray[np.float64], middle: ArrayLike, reach: ArrayLike) -> NDArray[np.float64]:
    return np.asarray(np.exp(-(((points - np.asarray(middle)) / np.asarray(reach)) ** 2).sum(axis=1)))
