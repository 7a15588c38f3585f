"""Cases of buckling: symmetric states that are equilibria but no minima of the energy, and states just before them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from lappet.procedure import MODELS
from lappet.program.program import Program
from lappet.reports.stability.case import Case, Check, Demand, Scene, Solved
from lappet.reports.stability.scenes import BELOW, SKIN, Vector, block, material, stretched

BAR: Vector = (40.0, 4.0, 4.0)
# Energy of the bar pressed to 70 %, measured at 1 mm; straight, at the saddle, it is 1848 mN mm.
BUCKLED_ENERGY = 320.1
GRAVITY = 9.81


def buckling_cases() -> Iterator[Case]:
    """List the group buckling.

    Yields
    ------
    Case
        The cases.
    """
    buckled = energy_near(BUCKLED_ENERGY)
    for steps in (1, 4, 16):
        yield _buckles(
            f"bar of 40 x 4 x 4 mm pressed to 70 % in {steps}", lambda n=steps: Scene(pressed(0.7, n), check=buckled)
        )
    yield _buckles(
        "bar pressed to 70 % in 1, double", lambda: Scene(pressed(0.7, 1, precision="double"), check=buckled)
    )
    yield _buckles("bar pressed to 70 % in 1, 8 points", lambda: Scene(pressed(0.7, 1, quadrature=8), check=off_axis))
    for model in MODELS:
        yield _buckles(
            f"{model} bar pressed to 80 % in 1",
            lambda m=model: Scene(pressed(0.8, 1, materials=(material(m),)), check=off_axis),
        )
    yield _buckles(
        "sheet of 40 x 20 x 1 mm pressed to 90 % in 1",
        lambda: Scene(stretched(0.9, size=(40.0, 20.0, 1.0), spacing=1.0), check=off_axis),
    )
    yield Case(
        "bar pressed by 3.15 %, where it is about to buckle",
        "buckling",
        lambda: pressed(1.0 - 0.0315, 1),
        Demand.IS_SENSITIVE,
    )
    yield Case("bar pressed by 2 %", "buckling", lambda: Scene(pressed(0.98, 1), check=straight))
    # Greenhill 1881: a column fixed at its foot stands upright under its own weight up to a height of
    # (7.837 E I / (rho g A))^(1/3).
    for share, demands in ((0.85, Demand.CONVERGES), (1.6, Demand.BUCKLES)):
        yield Case(
            f"column of {share:g} times the height at which its weight bends it",
            "buckling",
            lambda s=share, d=demands: Scene(
                column(round(s * greatest_height(4.0))), check=off_axis if d is Demand.BUCKLES else straight
            ),
            demands,
        )


def _buckles(name: str, scene: Any) -> Case:
    return Case(name, "buckling", scene, Demand.BUCKLES)


def pressed(length: float, steps: int, **more: Any) -> Program:
    """Make a bar of 40 x 4 x 4 mm, both ends held, pressed along its axis.

    Parameters
    ----------
    length
        Share of its length to which it is pressed.
    steps
        Number of frames.
    **more
        What `block` takes besides.

    Returns
    -------
    Program
        The program.
    """
    return stretched(length, steps=steps, size=BAR, spacing=1.0, **more)


def greatest_height(width: float) -> float:
    """Compute how high a square column of skin stands upright.

    Parameters
    ----------
    width
        Its width in mm.

    Returns
    -------
    float
        The height in mm.
    """
    weight = SKIN.density * GRAVITY * 1e-6  # mN/mm³
    return float((7.837 * SKIN.youngs_modulus * width**2 / 12.0 / weight) ** (1.0 / 3.0))


def column(height: float) -> Program:
    """Make a column 4 mm wide that stands on a fixed foot under gravity.

    Parameters
    ----------
    height
        Its height in mm.

    Returns
    -------
    Program
        The program.
    """
    return block((4.0, 4.0, height), 1.0, fixed=(BELOW,), gravity=(0.0, 0.0, -GRAVITY))


def energy_near(energy: float) -> Check:
    """Make the check that the last frame has an energy, within 1 %.

    Parameters
    ----------
    energy
        The energy in mN mm.

    Returns
    -------
    Check
        The check.
    """

    def check(solved: Solved) -> str:
        found = solved.frames[-1].diagnostics.energy
        return (
            "" if math.isclose(found, energy, rel_tol=0.01) else f"Its energy is {found:.4g} mN mm, not {energy:.4g}."
        )

    return check


def _deflection(solved: Solved) -> float:
    """How far the middle of the surface has moved across its long axis on the mean, in mm."""
    rest = solved.program.epochs[0].surface.points
    moved = np.asarray(solved.frames[-1].points, float) - rest
    along = int(np.argmax(np.ptp(rest, axis=0)))
    middle = np.abs(rest[:, along] - rest[:, along].mean()) < 0.1 * np.ptp(rest[:, along])
    return float(np.linalg.norm(np.delete(moved[middle].mean(axis=0), along)))


def off_axis(solved: Solved) -> str:
    """Check that the middle has left the axis.

    Parameters
    ----------
    solved
        The frames.

    Returns
    -------
    str
        What is wrong, or nothing.
    """
    off = _deflection(solved)
    return "" if off > 1.0 else f"Its middle is {off:.2g} mm off the axis: it has not buckled."


def straight(solved: Solved) -> str:
    """Check that the middle is on the axis.

    Parameters
    ----------
    solved
        The frames.

    Returns
    -------
    str
        What is wrong, or nothing.
    """
    off = _deflection(solved)
    return "" if off < 0.01 else f"Its middle is {off:.2g} mm off the axis, though it is far from buckling."
