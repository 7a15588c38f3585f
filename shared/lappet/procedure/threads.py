"""Suture threads: how stiff they are, and at what tension they cut through skin.

- Diameters by size: the middle of the limits of USP 〈861〉 Sutures – Diameter.
- Young's modulus of nylon and polydioxanone, 2500 and 1500 MPa: *chosen* within what is usual of drawn monofilaments.
- That of polypropylene, 4026 MPa: Nindhia et al. 2021, Int. J. Appl. Pharm. 13 (Y1025), monofilament.
- That of silk, 8701 MPa: Naleway et al. 2015, J. Biomed. Mater. Res. B 103:735, initial modulus, size 3-0.
- Pull-through at 3-0, 4-0 and 5-0, 4.04, 3.81 and 3.44 N: Potter et al. 2025, Dermatol. Surg. 51:148, nylon in a skin
  model. At 6-0 and 7-0, 3.1 and 2.7 N: *chosen*, continuing that series.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

DIAMETERS = {"3-0": 0.225, "4-0": 0.175, "5-0": 0.125, "6-0": 0.085, "7-0": 0.06}
"""Diameter of each size in mm."""

MODULI = {"nylon": 2500.0, "polydioxanone": 1500.0, "polypropylene": 4026.0, "silk": 8701.0}
"""Young's modulus of each material in MPa."""

PULL_THROUGH = {"3-0": 4040.0, "4-0": 3810.0, "5-0": 3440.0, "6-0": 3100.0, "7-0": 2700.0}
"""Tension at which a thread of each size cuts through skin, in mN."""

LEAST_LENGTH = 2.0  # mm of thread in a stitch, however short it is drawn (chosen)


@dataclass(frozen=True)
class Thread:
    """A thread from the shelf.

    Parameters
    ----------
    name
        Material and size, as "nylon 5-0".
    diameter
        Diameter in mm.
    modulus
        Young's modulus in MPa.
    pull_through
        Tension at which it cuts through skin in mN.
    """

    name: str
    diameter: float
    modulus: float
    pull_through: float

    @property
    def axial_stiffness(self) -> float:
        """Young's modulus times the area of the cross section, in mN."""
        return 1000.0 * self.modulus * math.pi * self.diameter**2 / 4.0

    def stiffness(self, length: float) -> float:
        """Compute the stiffness of a piece of thread.

        Parameters
        ----------
        length
            Its length in mm; at least 2 mm are in a stitch.

        Returns
        -------
        float
            Stiffness in mN/mm.
        """
        return self.axial_stiffness / max(length, LEAST_LENGTH)


THREADS = {
    f"{material} {size}": Thread(f"{material} {size}", DIAMETERS[size], modulus, PULL_THROUGH[size])
    for material, modulus in MODULI.items()
    for size in DIAMETERS
}
"""The threads by name."""
