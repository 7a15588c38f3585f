"""How singular the stress is at an edge where a held side meets a free one, in linear elasticity.

Displacements vary as r^a with the distance r from the edge. On a regular lattice that leaves errors of order 2 a far
from the edge, which is the order of the energy (Aubin-Nitsche duality), and of order a at the edge itself.
"""

from __future__ import annotations

import math

import numpy as np


def edge_exponent(poissons_ratio: float, angle: float = 90.0) -> float:
    """Compute how singular plane strain is in a corner where a held side meets a free one.

    The exponent is the least root of sin²(a w) = (4 (1 - nu)² - a² sin² w) / (3 - 4 nu) (Williams 1952, J Appl Mech
    19:526; clamped and free side): 0.71 at 90° and nu = 0.3, 0.62 at nu = 0.45. At nu = 0 it is 1: what is pulled does
    not get narrower.

    Parameters
    ----------
    poissons_ratio
        Poisson's ratio nu.
    angle
        Angle w of the corner in degrees.

    Returns
    -------
    float
        The exponent a, at most 1, where nothing is singular any more.
    """
    turn = math.radians(angle)
    exponents = np.linspace(0.01, 1.0, 9901)
    left = np.sin(exponents * turn) ** 2
    right = (4.0 * (1.0 - poissons_ratio) ** 2 - (exponents * math.sin(turn)) ** 2) / (3.0 - 4.0 * poissons_ratio)
    roots = np.flatnonzero(left >= right)
    return float(exponents[roots[0]]) if len(roots) else 1.0
