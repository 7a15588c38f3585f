"""Small valid procedures made at random, the same ones for the same seed. Needs hypothesis (the extra `test`)."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    MODELS,
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Point,
    Procedure,
    Retractor,
    Suture,
    Tissue,
    Undermine,
)
from lappet.tissue.patch import flat_patch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hypothesis.strategies import DrawFn, SearchStrategy

T = TypeVar("T")
SIZE = (16.0, 12.0, 2.0)
TOP = SIZE[2]


def procedures() -> SearchStrategy[Procedure]:
    """Make the strategy for procedures of 2 to 4 frames on a patch of 16 x 12 x 2 mm.

    Returns
    -------
    SearchStrategy[Procedure]
        The strategy.

    Raises
    ------
    RefusedError
        If hypothesis is missing.
    """
    try:
        from hypothesis import strategies as st
    except ImportError as error:
        raise refused(
            ProblemCode.REPORT_NEEDS, "", error, what="The fuzz", package="hypothesis", extra="test"
        ) from error

    @st.composite
    def made(draw: DrawFn) -> Procedure:
        return _procedure(_Choices(draw))

    return made()


class _Choices:
    """What is left open in a procedure, as hypothesis chooses it."""

    def __init__(self, draw: DrawFn) -> None:
        from hypothesis import strategies

        self._draw, self._st = draw, strategies

    def whole(self, low: int, high: int) -> int:
        return self._draw(self._st.integers(low, high))

    def truth(self) -> bool:
        return self._draw(self._st.booleans())

    def one_of(self, options: Sequence[T]) -> T:
        return self._draw(self._st.sampled_from(options))

    def number(self, low: float, high: float) -> float:
        return self._draw(self._numbers(low, high))

    def number_or_none(self, low: float, high: float) -> float | None:
        return self._draw(self._st.none() | self._numbers(low, high))

    def place(self, beyond: float = 0.0) -> Point:
        x, y = (self.number(-side / 2 - beyond, side / 2 + beyond) for side in SIZE[:2])
        return (x, y, TOP)

    def ring(self) -> tuple[Point, ...]:
        """Around a middle, of any radius in every direction."""
        x, y = (self.number(-0.4 * side, 0.4 * side) for side in SIZE[:2])
        count, turn = self.whole(3, 7), self.number(0.0, math.tau)
        arms = [(turn + math.tau * k / count, self.number(0.3, 5.0)) for k in range(count)]
        return tuple((x + r * math.cos(a), y + r * math.sin(a), TOP) for a, r in arms)

    def _numbers(self, low: float, high: float) -> SearchStrategy[float]:
        # to a thousandth: simple numbers collide, which is what tissue does not like
        return self._st.integers(round(1000 * low), round(1000 * high)).map(lambda n: n / 1000)


def _incision(choices: _Choices, name: str, at: float) -> Event:
    depth = choices.number_or_none(0.1, 3.0)
    kerf = choices.one_of([0.05, 0.001, 0.2, 1.0])
    closed = choices.truth()
    if closed and choices.truth():
        points = choices.ring()
    else:  # through itself as it comes
        points = tuple(choices.place(beyond=1.0) for _ in range(choices.whole(3 if closed else 2, 5)))
    return Incision(name, at, points, depth, kerf, closed=closed)


def _undermine(choices: _Choices, name: str, at: float) -> Event:
    return Undermine(name, at, choices.ring())


def _hook(choices: _Choices, name: str, at: float) -> Event:
    anchor = choices.place()
    shift = tuple(choices.number(-6.0, 6.0) for _ in range(3))
    target: Point = (anchor[0] + shift[0], anchor[1] + shift[1], anchor[2] + shift[2])
    stiffness = 10.0 ** choices.whole(-2, 8)
    samples = ((at, anchor), (at + choices.whole(1, 2), target)) if choices.truth() else ((at, target),)
    return Hook(name, anchor, samples, at, at + choices.whole(1, 4), stiffness)


def _suture(choices: _Choices, name: str, at: float) -> Event:
    ends = (choices.place(), choices.place())
    return Suture(name, ends, at, float(choices.whole(0, 2)), 10.0 ** choices.whole(-2, 8))


def _retractor(choices: _Choices, name: str, at: float) -> Event:
    angle, axis = math.radians(choices.number(-180.0, 180.0)), choices.whole(0, 2)
    matrix = np.eye(4)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    matrix[[a, a, b, b], [a, b, a, b]] = math.cos(angle), math.sin(angle), -math.sin(angle), math.cos(angle)
    matrix[3, :3] = [choices.number(-5.0, 5.0) for _ in range(3)]
    still = tuple(np.eye(4).reshape(-1))
    motion = ((at, still), (at + choices.whole(1, 3), tuple(matrix.reshape(-1))))
    return Retractor(name, "jaw", motion, at, at + choices.whole(1, 4))


def _landmark(choices: _Choices, name: str, at: float) -> Event:
    return Landmark(name, (choices.place(),), name)


# As often as they are listed.
MAKERS = (_incision, _incision, _incision, _undermine, _hook, _hook, _suture, _suture, _retractor, _landmark)


def _material(choices: _Choices) -> Material:
    fibered = choices.truth()
    return Material(
        model=choices.one_of(MODELS),
        youngs_modulus=10.0 ** choices.whole(-1, 4),
        poissons_ratio=choices.one_of([0.45, 0.0, 0.3, 0.49, 0.499, 0.4999]),
        mooney_ratio=choices.one_of([0.0, 0.3, 2.0]),
        fiber_k1=10.0 if fibered else 0.0,
        fiber_k2=choices.one_of([0.0, 1.0, 10.0, 50.0]) if fibered else 0.0,
        fiber_dispersion=choices.one_of([0.0, 0.2, 1.0 / 3.0]) if fibered else 0.0,
        prestretch=choices.one_of([(1.0, 1.0), (1.0, 1.0), (1.2, 1.1), (0.9, 1.0)]),
    )


def _procedure(choices: _Choices) -> Procedure:
    end = float(choices.whole(2, 4))
    count = choices.whole(1, 7)
    events = [choices.one_of(MAKERS)(choices, f"event_{k}", float(choices.whole(1, int(end)))) for k in range(count)]
    rings = [event for event in events if isinstance(event, Incision) and event.closed and event.depth is None]
    taken = choices.truth()  # what was cut out is taken out
    if rings and taken:
        cut = choices.one_of(rings)
        seed = np.mean(cut.points, axis=0)
        events.append(Excision("out", min(cut.time + choices.whole(0, 1), end), (tuple(seed),)))
    if sum(isinstance(event, Retractor) for event in events) > 1:  # there is one jaw
        first = next(event for event in events if isinstance(event, Retractor))
        events = [event for event in events if event is first or not isinstance(event, Retractor)]
    return Procedure(
        tissue=_tissue(
            choices.one_of([2.0, 1.0, 1.5]),
            rim=choices.one_of([True, True, False]),
            bed=choices.one_of([True, True, False]),
            gravity=choices.one_of([0.0, 0.0, 9.81]),
        ),
        materials=(_material(choices),),
        events=tuple(events),
        start_time=1.0,
        end_time=end,
    )


def _tissue(spacing: float, *, rim: bool, bed: bool, gravity: float) -> Tissue:
    patch = flat_patch(SIZE, resolution=2.0, spacing=spacing, gravity=gravity)
    middles = patch.points[patch.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    jaw = np.flatnonzero(middles[:, 0] > SIZE[0] / 2 - 1e-6)
    fixed = np.setdiff1d(patch.subsets["fixed"], jaw)
    subsets = {"jaw": jaw, **({"fixed": fixed} if rim else {}), **({"bed": patch.subsets["bed"]} if bed else {})}
    return replace(patch, subsets={name: faces.astype(np.int32) for name, faces in subsets.items()})


def told(procedure: Procedure) -> str:
    """Describe all that a procedure of `procedures` is made of, to make it again.

    Parameters
    ----------
    procedure
        The procedure.

    Returns
    -------
    str
        The text.
    """
    tissue = procedure.tissue
    lines = [
        f"spacing {tissue.spacing}, gravity {tissue.gravity}, subsets {sorted(tissue.subsets)}, "
        f"end {procedure.end_time}",
        str(asdict(procedure.materials[0])),
        *(f"{event.kind} {asdict(event)}" for event in procedure.events),
    ]
    return "\n".join(lines)
