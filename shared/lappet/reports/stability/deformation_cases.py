"""Cases of large deformation, and of starts that are no state of a tissue."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lappet.core.problem_code import ProblemCode
from lappet.procedure import MODELS
from lappet.program.program import Program
from lappet.program.settings import MaterialParameters
from lappet.reports.stability.case import Case, Demand, Scene
from lappet.reports.stability.scenes import (
    LEFT,
    RIGHT,
    block,
    material,
    moved,
    stretched,
    twisted,
)
from lappet.reports.stability.starts import STARTS, as_from_rest

# Corotated tissue draws in by lambda (stretch - 1) / (2 lambda + 2 mu): at a Poisson's ratio of 0.45 to nothing at a
# stretch of 3.2, and at held ends before. There two singular values cancel, where its energy has a kink: a search for a
# vanishing gradient does not end.
KINK = ProblemCode.FRAME_ITERATIONS


def deformation_cases() -> Iterator[Case]:
    """List the groups stretch, compression, twist and starts.

    Yields
    ------
    Case
        The cases.
    """
    for model in MODELS:
        skin = material(model)
        yield from _stretch(model, skin)
        yield from _compression(model, skin)
        yield from _twist(model, skin)
    yield from _starts()


def squeezed(length: float, steps: int, skin: MaterialParameters, **settings: Any) -> Program:
    """Make a slab of 8 x 16 x 16 mm pressed between two plates that it sticks to.

    Parameters
    ----------
    length
        Share of its thickness to which it is pressed.
    steps
        Number of frames.
    skin
        The material.
    **settings
        Other fields of `SolverSettings`.

    Returns
    -------
    Program
        The program.
    """
    size = (8.0, 16.0, 16.0)
    motions = [[moved((size[0] * (length - 1.0) * (step + 1) / steps, 0.0, 0.0))] for step in range(steps)]
    return block(size, 2.0, fixed=(LEFT,), gripped=(RIGHT,), motions=motions, materials=(skin,), **settings)


def _stretch(model: str, skin: MaterialParameters) -> Iterator[Case]:
    for factor, steps in ((2.0, 1), (3.0, 1), (3.0, 8)):
        yield Case(
            f"{model} bar to {factor:.0%} of its length in {steps}",
            "stretch",
            lambda f=factor, s=steps: stretched(f, steps=s, materials=(skin,)),
            demands=KINK if model == "corotated" and factor > 2.0 else Demand.CONVERGES,
        )
    if model == "corotated":
        compressible = material(model, poissons_ratio=0.3)
        yield Case(
            "corotated bar of Poisson's ratio 0.3 to 300% of its length in 1",
            "stretch",
            lambda: stretched(3.0, materials=(compressible,)),
        )


def _compression(model: str, skin: MaterialParameters) -> Iterator[Case]:
    # Stuck to both plates, the tissue must flow out over their edges: beyond a half it folds there.
    yield Case(f"{model} slab to 50 % in 4", "compression", lambda: squeezed(0.5, 4, skin))
    for quadrature in (1, 8):
        for steps in (1, 8):
            yield Case(
                f"{model} slab to 20 % in {steps}, quadrature {quadrature}",
                "compression",
                lambda s=steps, q=quadrature: squeezed(0.2, s, skin, quadrature=q),
            )
    steps = 16 if model == "mooneyRivlin" else 8
    yield Case(
        f"{model} bar to 20 %, which buckles, in {steps}",
        "compression",
        lambda: stretched(0.2, steps=steps, materials=(skin,)),
    )


def _twist(model: str, skin: MaterialParameters) -> Iterator[Case]:
    yield Case(f"{model} bar by 360° in 8", "twist", lambda: twisted(360.0, 8, materials=(skin,)))
    yield Case(f"{model} bar by 90° in 1", "twist", lambda: twisted(90.0, 1, materials=(skin,)))


def _starts() -> Iterator[Case]:
    for model in ("corotated", "neoHookean"):
        for precision in ("float", "double"):
            for name, start in STARTS.items():
                yield Case(
                    f"{model}, {precision}, starts {name}",
                    "starts",
                    lambda m=model, p=precision, s=start: Scene(
                        stretched(1.3, materials=(material(m),), precision=p, tolerance=1e-4), s, as_from_rest(0.02)
                    ),
                )
    for model in ("stableNeoHookean", "mooneyRivlin"):
        for name in ("collapsed", "random", "mirrored"):
            yield Case(
                f"{model}, float, starts {name}",
                "starts",
                lambda m=model, n=name: Scene(
                    stretched(1.3, materials=(material(m),), tolerance=1e-4), STARTS[n], as_from_rest(0.02)
                ),
            )
