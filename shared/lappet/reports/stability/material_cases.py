"""Cases of materials: near incompressibility, contrast between regions, stiff fibers, every model at its extremes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Regions
from lappet.procedure import MODELS
from lappet.program.program import Program
from lappet.program.settings import MaterialParameters
from lappet.reports.box_scenes import grid_box
from lappet.reports.stability.case import Case, Check, Demand, Scene, Solved
from lappet.reports.stability.deformation_cases import KINK
from lappet.reports.stability.scenes import (
    ABOVE,
    BELOW,
    LEFT,
    RIGHT,
    SKIN,
    Vector,
    block,
    material,
    moved,
    stretched,
)

BLOCK: Vector = (16.0, 16.0, 8.0)
KEPT = 0.02  # of the volume


def material_cases() -> Iterator[Case]:
    """List the groups poisson, contrast, fibers and models.

    Yields
    ------
    Case
        The cases.
    """
    yield from _poisson()
    yield from _contrast()
    yield from _fibers()
    yield from _models()


def pressed(share: float, **more: Any) -> Program:
    """Make a block held below, its upper side pressed down.

    Parameters
    ----------
    share
        Share of its height by which it is pressed.
    **more
        What `block` takes besides.

    Returns
    -------
    Program
        The program.
    """
    motion = [[moved((0.0, 0.0, -share * BLOCK[2]))]]
    return block(BLOCK, 2.0, fixed=(BELOW,), gripped=(ABOVE,), motions=motion, **more)


def volume_kept(share: float) -> Check:
    """Make the check that the surface encloses what it did at rest.

    Parameters
    ----------
    share
        Share by which the volume may differ.

    Returns
    -------
    Check
        The check.
    """

    def check(solved: Solved) -> str:
        surface = solved.program.epochs[0].surface
        before, after = (
            _volume(points, surface.triangles) for points in (surface.points, solved.frames[-1].points.astype(float))
        )
        change = after / before - 1.0
        return "" if abs(change) <= share else f"Tissue that is incompressible changes its volume by {change:.1%}."

    return check


def _volume(points: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _poisson() -> Iterator[Case]:
    for ratio in (0.3, 0.45, 0.49, 0.499, 0.4999):
        check = volume_kept(KEPT) if ratio > 0.498 else None
        skin = material(poissons_ratio=ratio)
        yield Case(
            f"Poisson's ratio {ratio}, pressed by 20 %",
            "poisson",
            lambda skin=skin, check=check: Scene(pressed(0.2, materials=(skin,)), check=check),
        )
        yield Case(
            f"Poisson's ratio {ratio}, bar stretched by 50 %",
            "poisson",
            lambda skin=skin, check=check: Scene(stretched(1.5, materials=(skin,)), check=check),
        )
    for model in MODELS:
        skin = material(model, poissons_ratio=0.4999)
        yield Case(
            f"Poisson's ratio 0.4999, {model}, 8 points, stretched by 50 %",
            "poisson",
            lambda skin=skin: Scene(stretched(1.5, quadrature=8, materials=(skin,))),
        )


def inclusion(contrast: float, depth: float = 4.0, **settings: Any) -> Program:
    """Make a block stretched by 30 % with an inclusion below the middle of its upper side.

    Parameters
    ----------
    contrast
        How many times as stiff the inclusion is.
    depth
        Depth of the inclusion in mm.
    **settings
        Other fields of `SolverSettings`.

    Returns
    -------
    Program
        The program.
    """
    surface, side = grid_box(BLOCK, (8, 8, 4))
    center = surface.points[surface.triangles].mean(axis=1)
    inside = (side == ABOVE) & (np.abs(center[:, :2] - 8.0) < 4.0).all(axis=1)
    regions = Regions(
        surface.points,
        surface.triangles,
        inside[None],
        np.ones(1, np.int32),
        np.zeros(1),
        np.array([depth]),
    )
    other = replace(SKIN, youngs_modulus=SKIN.youngs_modulus * contrast)
    return block(
        BLOCK,
        2.0,
        fixed=(LEFT,),
        gripped=(RIGHT,),
        motions=[[moved((0.3 * BLOCK[0], 0.0, 0.0))]],
        materials=(SKIN, other),
        regions=regions,
        **settings,
    )


def _contrast() -> Iterator[Case]:
    for power in (0, 1, 2, 3, 4, 5, 6):
        # A stiff inclusion is carried by 2.4 mm, which float knows to 2e-7 mm: from 10^5 on its forces are rounded to
        # more than the tolerance.
        yield Case(
            f"inclusion 10^{power} times as stiff",
            "contrast",
            lambda power=power: inclusion(10.0**power),
            demands=Demand.CONVERGES if power < 5 else ProblemCode.FRAME_NO_DESCENT,
        )
        if power:
            yield Case(f"inclusion 10^-{power} as stiff", "contrast", lambda power=power: inclusion(10.0**-power))
    for power in (5, 6, -6):
        yield Case(
            f"inclusion 10^{power} times as stiff, double",
            "contrast",
            lambda power=power: inclusion(10.0**power, precision="double"),
        )


def _fiberd(exponent: float, **changes: Any) -> MaterialParameters:
    return material(fiber_k1=10.0, fiber_k2=exponent, **changes)


def _fibers() -> Iterator[Case]:
    skin = grid_box((16.0, 8.0, 8.0), (8, 4, 4))[0]
    along = Regions(skin.points, skin.triangles, np.zeros((0, len(skin.triangles)), np.bool_))

    def bar(factor: float, fiberd: MaterialParameters, steps: int = 1) -> Program:
        return stretched(factor, steps=steps, materials=(fiberd,), regions=along)

    for exponent in (1.0, 10.0, 50.0):
        for factor, steps in ((1.2, 1), (1.5, 5), (0.8, 1)):
            yield Case(
                f"fiber exponent {exponent:g}, to {factor:g} of the length in {steps}",
                "fibers",
                lambda e=exponent, f=factor, s=steps: bar(f, _fiberd(e), s),
            )
    yield Case("fiber exponent 50, dispersed", "fibers", lambda: bar(1.2, _fiberd(50.0, fiber_dispersion=1.0 / 3.0)))
    yield Case("fiber exponent 50, across", "fibers", lambda: bar(1.5, _fiberd(50.0, fiber_direction=(0.0, 1.0, 0.0))))
    yield Case("fiber exponent 50, to 3 times the length in 5", "fibers", lambda: bar(3.0, _fiberd(50.0), 5))
    yield Case(
        "fiber exponent 50, prestretched 1.3 along",
        "fibers",
        lambda: bar(1.1, _fiberd(50.0, prestretch=(1.3, 1.1))),
    )


def _models() -> Iterator[Case]:
    for model in MODELS:
        for precision in ("float", "double"):
            near = material(model, poissons_ratio=0.4999)
            yield Case(
                f"{model}, {precision}, Poisson's ratio 0.4999, pressed by 40 % in 2",
                "models",
                lambda near=near, precision=precision, model=model: Scene(
                    replace_motions(pressed(0.4, materials=(near,), precision=precision), 2),
                    check=None if model == "corotated" else volume_kept(0.05),  # it keeps the sum of the stretches
                ),
            )
            plain = material(model)
            yield Case(
                f"{model}, {precision}, stretched to 300 %",
                "models",
                lambda plain=plain, precision=precision: stretched(3.0, materials=(plain,), precision=precision),
                demands=KINK if model == "corotated" else Demand.CONVERGES,
            )
    stiff, soft = (material("mooneyRivlin", youngs_modulus=e) for e in (1e9, 1e-6))
    yield Case("Young's modulus 10^9 kPa", "models", lambda: stretched(1.3, materials=(stiff,)))
    yield Case("Young's modulus 10^-6 kPa", "models", lambda: stretched(1.3, materials=(soft,)))
    free = material(poissons_ratio=0.0)
    yield Case("Poisson's ratio 0", "models", lambda: stretched(1.5, materials=(free,)))
    beyond = material(poissons_ratio=0.5)
    yield Case(
        "Poisson's ratio 0.5",
        "models",
        lambda: stretched(1.5, materials=(beyond,)),
        demands=ProblemCode.SOLVER_INVALID_INPUT,
    )


def replace_motions(program: Program, steps: int) -> Program:
    """Reach the shifts of a program of one frame in equal steps.

    Parameters
    ----------
    program
        The program, which only shifts.
    steps
        Number of steps.

    Returns
    -------
    Program
        The program of as many frames.
    """
    (frame,) = program.frames
    frames = []
    for step in range(1, steps + 1):
        motion = frame.retractor_motion.copy()
        motion[:, :3, 3] *= step / steps
        frames.append(replace(frame, time=float(step), retractor_motion=motion))
    return replace(program, frames=tuple(frames))
