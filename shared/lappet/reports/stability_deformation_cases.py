"""Cases of large deformation, and of starts that are no state of a tissue."""

from __future__ import annotations

from collections.abc import Iterator

from lappet.program import MaterialParameters, Program
from lappet.reports.stability import Case, Scene
from lappet.reports.stability_scenes import (
    LEFT,
    MODELS,
    RIGHT,
    STARTS,
    as_from_rest,
    block,
    material,
    moved,
    stretched,
    twisted,
)

# An inversion that the model does not describe, or that nothing confirms, ends a frame honestly.
INVERTS = ("are inverted", "turns cells inside out")


def deformation_cases() -> Iterator[Case]:
    """Groups stretch, compression, twist and starts."""
    for model in MODELS:
        skin = material(model)
        yield from _stretch(model, skin)
        yield from _compression(model, skin)
        yield from _twist(model, skin)
    yield from _starts()


def squeezed(length: float, steps: int, skin: MaterialParameters) -> Program:
    """A slab of 8 x 16 x 16 mm pressed between two plates that it sticks to, to a share of its thickness."""
    size = (8.0, 16.0, 16.0)
    motions = [[moved((size[0] * (length - 1.0) * (step + 1) / steps, 0.0, 0.0))] for step in range(steps)]
    return block(size, 2.0, fixed=(LEFT,), gripped=(RIGHT,), motions=motions, materials=(skin,))


def _stretch(model: str, skin: MaterialParameters) -> Iterator[Case]:
    for factor, steps in ((2.0, 1), (3.0, 1), (3.0, 8)):
        yield Case(
            f"{model} bar to {factor:.0%} of its length in {steps}",
            "stretch",
            lambda f=factor, s=steps: stretched(f, steps=s, materials=(skin,)),
        )


def _compression(model: str, skin: MaterialParameters) -> Iterator[Case]:
    # Stuck to both plates, the tissue must flow out over their edges: beyond a half it folds there.
    yield Case(f"{model} slab to 50 % in 4", "compression", lambda: squeezed(0.5, 4, skin))
    yield Case(f"{model} slab to 20 % in 8", "compression", lambda: squeezed(0.2, 8, skin), says=INVERTS)
    yield Case(f"{model} slab to 20 % in 1", "compression", lambda: squeezed(0.2, 1, skin), says=INVERTS)
    yield Case(
        f"{model} bar to 20 %, which buckles, in 8",
        "compression",
        lambda: stretched(0.2, steps=8, materials=(skin,)),
        says=INVERTS,
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
