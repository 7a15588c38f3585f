"""Curves of a material: its own scalar solution of the daemon's law for a strip drawn along or across its fibers.

Notation: s, the three principal stretches; axis 0 along the fibers, 1 across them in the skin, 2 through its thickness;
J = s0 s1 s2. Two families of fibers at an angle to either side mirror each other: what one pulls aslant in the plane,
the other pulls the other way. Energies W(s) in kPa are those that the heads of `solverd/src/force/materials/*.h` state;
fiber.h has the fibers', with its volume measure v(J) and the smooth onset at their slack.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.procedure import Material

_STEP = 1e-30  # of the complex-step derivative: no cancellation, so it is exact
_DIFFERENCE = 1e-6
# Of fiber.h: k2 m^2 beyond which the exponential goes on as a parabola; what keeps the volume; the width of the onset.
_MAX_EXPONENT, _VOLUME, _VOLUME_WIDTH, _RECRUITMENT = 10.0, 50.0, 0.1, 0.5
_MOST_STEPS = 100


def energy(material: Material, s: NDArray[np.complex128]) -> complex:
    """Compute the elastic energy of a material at principal stretches, without muscle.

    Parameters
    ----------
    material
        The material.
    s
        Principal stretches along and across the fibers and through the thickness, shape (3,).

    Returns
    -------
    complex
        Energy in kPa; complex so that derivatives can be taken with a complex step.
    """
    mu = material.youngs_modulus / (2.0 * (1.0 + material.poissons_ratio))
    lame = 2.0 * mu * material.poissons_ratio / (1.0 - 2.0 * material.poissons_ratio)
    j = s[0] * s[1] * s[2]
    squares = s * s
    log_j = np.log(j)
    if material.model == "corotated":
        found = mu * ((s - 1.0) ** 2).sum() + 0.5 * lame * (s.sum() - 3.0) ** 2
    elif material.model == "stableNeoHookean":
        found = 0.5 * mu * (squares.sum() - 3.0) + (j - 1.0) * (0.5 * (lame + mu) * (j - 1.0) - mu)
    elif material.model == "mooneyRivlin":
        first = 0.5 * mu / (1.0 + material.mooney_ratio)
        pairs = squares[0] * squares[1] + squares[1] * squares[2] + squares[0] * squares[2]
        found = first * (j ** (-2.0 / 3.0) * squares.sum() - 3.0) + 0.5 * (lame + 2.0 / 3.0 * mu) * log_j**2
        found += material.mooney_ratio * first * (j ** (-4.0 / 3.0) * pairs - 3.0)
    else:
        found = 0.5 * mu * (squares.sum() - 3.0) - mu * log_j + 0.5 * lame * log_j**2
    return complex(found + _fiber_energy(material, squares, j))


def _fiber_energy(material: Material, squares: NDArray[np.complex128], j: complex) -> complex:
    """The energy of the fibers; squares: of the principal stretches."""
    if not material.has_fibers:
        return 0.0j
    kappa, threshold = material.fiber_dispersion, material.fiber_slack**2 - 1.0
    x = j - 1.0
    volume = -2.0 * x + 2.0 * _VOLUME * _VOLUME_WIDTH**2 * (np.sqrt(1.0 + (x / _VOLUME_WIDTH) ** 2) - 1.0)
    aligned = math.cos(math.radians(material.fiber_angle)) ** 2
    along = aligned * squares[0] + (1.0 - aligned) * squares[1]
    strain = kappa * (squares.sum() - 3.0 + volume) + (1.0 - 3.0 * kappa) * (along - 1.0) - threshold
    width = _RECRUITMENT * threshold
    if strain.real <= -0.5 * width:
        return 0.0j
    if strain.real < 0.5 * width:
        t = strain / width + 0.5
        strain = width * t**3 * (1.0 - 0.5 * t)
    k1, k2 = material.fiber_k1, material.fiber_k2
    most = math.sqrt(_MAX_EXPONENT / k2) if k2 > 0.0 else math.inf
    inner = strain if strain.real < most else complex(most)
    beyond = strain - inner
    growth = np.exp(k2 * inner * inner)
    base = 0.5 * k1 * inner * inner if k2 * abs(inner) ** 2 < 1e-8 else 0.5 * k1 / k2 * (growth - 1.0)
    curvature = k1 * growth * (1.0 + 2.0 * k2 * inner * inner)
    return complex(base + beyond * (k1 * inner * growth + 0.5 * curvature * beyond))


def nominal_stresses(material: Material, s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute the principal first Piola-Kirchhoff stresses dW/ds.

    Parameters
    ----------
    material
        The material.
    s
        Principal stretches, shape (3,).

    Returns
    -------
    NDArray[np.float64]
        Stresses in kPa, shape (3,).
    """
    found = np.empty(3)
    for i in range(3):
        step = s.astype(np.complex128)
        step[i] += 1j * _STEP
        found[i] = energy(material, step).imag / _STEP
    return found


def stretches_under(material: Material, given: dict[int, float], wanted: dict[int, float]) -> NDArray[np.float64]:
    """Find the principal stretches at which some are given and the true stresses along the others too.

    Parameters
    ----------
    material
        The material.
    given
        Stretches by axis.
    wanted
        Cauchy stresses in kPa by the other axes.

    Returns
    -------
    NDArray[np.float64]
        The three stretches, shape (3,).

    Raises
    ------
    ArithmeticError
        If the law has no such state near.
    """
    s = np.ones(3)
    for axis, value in given.items():
        s[axis] = value
    free = sorted(wanted)
    for axis in free:  # near the volume at rest
        s[axis] = math.prod(given.values()) ** (-1.0 / max(len(free), 1)) if given else 1.0
    target = np.array([wanted[axis] for axis in free])
    scale = material.youngs_modulus + float(np.abs(target).max(initial=0.0))

    def off(at: NDArray[np.float64]) -> NDArray[np.float64]:
        stresses = nominal_stresses(material, at) * at / at.prod()
        return stresses[free] - target

    left = off(s)
    for _ in range(_MOST_STEPS):
        if np.abs(left).max(initial=0.0) <= 1e-10 * scale:
            return s
        slope = np.empty((len(free), len(free)))
        for column, axis in enumerate(free):
            beside = s.copy()
            beside[axis] += _DIFFERENCE
            slope[:, column] = (off(beside) - left) / _DIFFERENCE
        step = -np.linalg.solve(slope, left)
        step *= min(1.0, 0.1 / float(np.abs(step).max()))
        for _ in range(40):
            trial = s.copy()
            trial[free] += step
            if (trial > 0.05).all() and float(np.linalg.norm(off(trial))) < float(np.linalg.norm(left)):
                break
            step *= 0.5
        else:
            break
        s, left = trial, off(trial)
    if np.abs(left).max(initial=0.0) <= 1e-6 * scale:
        return s
    raise ArithmeticError(f"{material.name} has no state of equilibrium at {given} under {wanted} kPa.")


def strip(material: Material, stretch: float, axis: int = 0) -> tuple[float, NDArray[np.float64]]:
    """Draw a strip with free sides.

    Parameters
    ----------
    material
        The material.
    stretch
        Stretch of the strip.
    axis
        0 along the fibers, 1 across them.

    Returns
    -------
    tuple[float, NDArray[np.float64]]
        Nominal stress in kPa and the three principal stretches, shape (3,).
    """
    s = stretches_under(material, {axis: stretch}, {other: 0.0 for other in range(3) if other != axis})
    return float(nominal_stresses(material, s)[axis]), s


def curve(material: Material, stretches: NDArray[np.float64], axis: int = 0) -> NDArray[np.float64]:
    """Compute the uniaxial curve of a material with free sides.

    Parameters
    ----------
    material
        The material.
    stretches
        Stretches of the strip, shape (n,).
    axis
        0 along the fibers, 1 across them.

    Returns
    -------
    NDArray[np.float64]
        Nominal stresses in kPa, shape (n,).
    """
    return np.array([strip(material, float(stretch), axis)[0] for stretch in stretches])


@dataclass(frozen=True)
class CurveShape:
    """What a J-shaped curve is described by.

    Parameters
    ----------
    initial_slope
        Slope of the nominal stress at rest in kPa.
    knee
        Stretch at which the tangent at the end of the curve meets the axis: where fibers take over.
    terminal_slope
        Slope at the end of the curve in kPa.
    last
        Stretch at the end of the curve.
    """

    initial_slope: float
    knee: float
    terminal_slope: float
    last: float


def curve_shape(material: Material, last: float, axis: int = 0) -> CurveShape:
    """Measure a curve's initial slope, knee and terminal slope.

    Parameters
    ----------
    material
        The material.
    last
        Stretch at the end of the curve.
    axis
        0 along the fibers, 1 across them.

    Returns
    -------
    CurveShape
        What was measured.
    """
    h = 1e-4
    first = curve(material, np.array([1.0, 1.0 + h]), axis)
    end = curve(material, np.array([last - h, last]), axis)
    slope = float(end[1] - end[0]) / h
    return CurveShape(float(first[1] - first[0]) / h, last - float(end[1]) / slope, slope, last)


def prestretch_for(material: Material, along: float, across: float) -> tuple[float, float]:
    """Find the prestretch that gives an in-vivo tension: the skin's stresses in its plane, free through its thickness.

    Parameters
    ----------
    material
        The material; its own prestretch has no effect.
    along
        Tension along the fibers in kPa of true (Cauchy) stress.
    across
        Tension across them in kPa.

    Returns
    -------
    tuple[float, float]
        Prestretch along and across the fibers.

    Raises
    ------
    ArithmeticError
        If the law has no such state.
    """
    s = stretches_under(material, {}, {0: along, 1: across, 2: 0.0})
    return float(s[0]), float(s[1])


def tension_of(material: Material) -> tuple[float, float]:
    """Compute the in-vivo tension that the material's prestretch gives.

    Parameters
    ----------
    material
        The material.

    Returns
    -------
    tuple[float, float]
        Cauchy stresses along and across the fibers in kPa.
    """
    along, across = material.prestretch
    s = stretches_under(material, {0: along, 1: across}, {2: 0.0})
    stresses = nominal_stresses(material, s) * s / s.prod()
    return float(stresses[0]), float(stresses[1])
