"""Cases of cuts: twice through the same edge, a hair apart, through each other, hundreds of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Event, Excision, Hook, Incision, Undermine
from lappet.program.program import Program
from lappet.reports.stability.case import Case
from lappet.reports.stability.scenes import Vector, compiled, patch, procedure

TOP = 2.0
LONG: tuple[Vector, ...] = ((-6.0, 0.0, TOP), (6.0, 0.0, TOP))
RING = tuple((4 * math.cos(a), 4 * math.sin(a), TOP) for a in np.linspace(0, 2 * np.pi, 32, endpoint=False))
NEEDLE: tuple[Vector, ...] = ((5.0, 0.0, TOP), (-3.0, 0.5, TOP), (-3.0, 0.0, TOP))


def cut_cases() -> Iterator[Case]:
    """List the groups cuts and many cuts.

    Yields
    ------
    Case
        The cases.
    """
    yield from _several()
    yield from _single()
    yield from _excised()
    yield from _undermined()
    yield from _many()


def opened(*cuts: Event, end: float = 4.0, size: Vector = (24.0, 16.0, TOP), **more: Any) -> Program:
    """Make cuts in a patch that a hook then pulls at, beside the middle.

    Parameters
    ----------
    *cuts
        The cuts.
    end
        Last time code.
    size
        Extent of the patch in mm.
    **more
        What `procedure` and `patch` take besides.

    Returns
    -------
    Program
        The program.
    """
    place = (0.5, 1.5, TOP)
    hook = Hook("pull", place, ((end - 1.0, place), (end, (0.5, 3.0, TOP + 1.0))), end - 1.0, end + 1.0, 20.0)
    return compiled(procedure(patch(size), *cuts, hook, end=end), **more)


def line(name: str, time: float, *points: Sequence[float], **more: Any) -> Incision:
    """Make an incision through points of the skin.

    Parameters
    ----------
    name
        Name of the event.
    time
        Time code.
    *points
        Points (x, y) in mm.
    **more
        Other fields of the incision.

    Returns
    -------
    Incision
        The incision.
    """
    return Incision(name, time, tuple((x, y, TOP) for x, y in points), **more)


def _several() -> Iterator[Case]:
    again = Incision("again", 2.0, LONG, kerf=0.1)
    yield Case("the same cut twice, one after the other", "cuts", lambda: opened(Incision("a", 1.0, LONG), again))
    yield Case("the same cut twice at once", "cuts", lambda: opened(Incision("a", 2.0, LONG), again))
    for apart in (0.01, 0.1):
        for kerf in (0.001, 0.05):
            yield Case(
                f"cuts {apart:g} mm apart with a kerf of {kerf:g} mm",
                "cuts",
                lambda d=apart, k=kerf: opened(
                    line("a", 1.0, (-6, 0), (6, 0), kerf=k), line("b", 1.0, (-6, d), (6, d), kerf=k)
                ),
            )
    yield Case(
        "cuts 0.01 mm apart, one after the other",
        "cuts",
        lambda: opened(line("a", 1.0, (-6, 0), (6, 0)), line("b", 2.0, (-6, 0.01), (6, 0.01))),
    )
    yield Case("cuts cross", "cuts", lambda: opened(line("a", 1.0, (-6, 0), (6, 0)), line("b", 2.0, (0, -6), (0, 6))))
    star = [
        line(f"ray_{k}", 1.0, (0, 0), (6 * math.cos(a), 6 * math.sin(a)))
        for k, a in enumerate(np.linspace(0.0, 2 * np.pi, 12, endpoint=False))
    ]
    yield Case("twelve cuts meet in a point", "cuts", lambda: opened(*star))


def _single() -> Iterator[Case]:
    yield Case("cut across the whole tissue", "cuts", lambda: opened(line("a", 1.0, (0, -9), (0, 9))))
    yield Case("cut along the tissue's edge", "cuts", lambda: opened(line("a", 1.0, (-12, 8), (12, 8))))
    yield Case("cut 0.01 mm inside the tissue's edge", "cuts", lambda: opened(line("a", 1.0, (-12, 7.99), (12, 7.99))))
    yield Case("cut in lattice planes", "cuts", lambda: opened(line("a", 1.0, (-6, 0), (0, 0), (0, 4), kerf=1e-6)))
    yield Case("cut 0.001 mm long", "cuts", lambda: opened(line("a", 1.0, (0, 0), (0.001, 0))))
    for depth in (0.001, 1.999, 2.0, 50.0):
        yield Case(
            f"cut {depth:g} mm deep in 2 mm",
            "cuts",
            lambda d=depth: opened(line("a", 1.0, (-6, 0), (6, 0), depth=d)),
        )
    zigzag = [(-6.0 + 0.05 * k, 0.05 * (k % 2)) for k in range(240)]
    yield Case("zigzag finer than its kerf", "cuts", lambda: opened(line("a", 1.0, *zigzag, kerf=0.1)))
    eight = [(4 * math.sin(a), 3 * math.sin(2 * a)) for a in np.linspace(0.3, 2 * np.pi + 0.1, 40)]
    yield Case("cut through itself, an eight", "cuts", lambda: opened(line("a", 1.0, *eight)))
    spiral = [(0.4 * a * math.cos(a), 0.4 * a * math.sin(a)) for a in np.linspace(1.0, 5 * np.pi, 120)]
    yield Case("spiral", "cuts", lambda: opened(line("a", 1.0, *spiral)))
    yield Case("kerf wider than the cut is long", "cuts", lambda: opened(line("a", 1.0, (-0.5, 0), (0.5, 0), kerf=3.0)))


def _excised() -> Iterator[Case]:
    around = Incision("around", 1.0, RING, closed=True)
    yield Case(
        "excision of an island, the hook on the rest",
        "cuts",
        lambda: compiled(procedure(patch(), around, Excision("out", 2.0, ((0.0, 0.0, TOP),)), _aside(), end=4.0)),
    )
    yield Case(
        "excision of what a hook holds",
        "cuts",
        lambda: opened(around, Excision("out", 2.0, ((0.0, 0.0, TOP),))),
        demands=ProblemCode.PROGRAM_HOOK_EXCISED,
    )
    yield Case(
        "excision of everything",
        "cuts",
        lambda: compiled(
            procedure(patch(), around, Excision("out", 2.0, ((0.0, 0.0, TOP), (10.0, 0.0, TOP))), end=4.0)
        ),
        demands=ProblemCode.EXCISION_OF_ALL,
    )
    sharp = Incision("sharp", 1.0, NEEDLE, closed=True)
    out = Excision("out", 2.0, ((-2.0, 0.2, TOP),))
    yield Case("excision of a wedge with a tip of 4°", "cuts", lambda: opened(sharp, out))


def _undermined() -> Iterator[Case]:
    yield Case("undermined wedge with a tip of 4°", "cuts", lambda: opened(Undermine("free", 1.0, NEEDLE)))
    dot = tuple((0.5 + 0.05 * x, 0.5 + 0.05 * y, TOP) for x, y, _ in RING)
    yield Case("undermined area of 0.2 mm", "cuts", lambda: opened(Undermine("free", 1.0, dot)))
    yield Case("undermined, then cut", "cuts", lambda: opened(Undermine("free", 1.0, RING), Incision("a", 2.0, LONG)))
    yield Case(
        "undermined to the rim and beyond",
        "cuts",
        lambda: opened(
            Undermine("free", 1.0, tuple((2.5 * x, 2.5 * y, TOP) for x, y, _ in RING)), Incision("a", 2.0, LONG)
        ),
    )


def _aside() -> Hook:
    place = (8.0, 4.0, TOP)
    return Hook("pull", place, ((3.0, place), (4.0, (8.0, 5.0, TOP + 1.0))), 3.0, 5.0, 20.0)


def scattered(
    count: int, length: float, size: Vector, *, seed: int, depth: float | None, times: int = 1
) -> list[Event]:
    """Make straight cuts anywhere in a patch, in any direction, spread over frames.

    Parameters
    ----------
    count
        Number of cuts.
    length
        Their length in mm, about.
    size
        Extent of the patch in mm.
    seed
        Seed of the random numbers.
    depth
        Depth in mm, or None to cut through.
    times
        Number of frames.

    Returns
    -------
    list[Event]
        The cuts.
    """
    random = np.random.default_rng(seed)
    cuts: list[Event] = []
    for k in range(count):
        x, y = (random.random(2) - 0.5) * np.array(size[:2]) * 0.9
        angle, long = random.random() * 2 * np.pi, length * (0.5 + random.random())
        end = (x + long * math.cos(angle), y + long * math.sin(angle))
        cuts.append(line(f"cut_{k}", 1.0 + k % times, (x, y), end, depth=depth))
    return cuts


def _many() -> Iterator[Case]:
    wide = (60.0, 60.0, TOP)
    yield Case(
        "500 random cuts of 3 mm, through",
        "many cuts",
        lambda: opened(*scattered(500, 3.0, wide, seed=1, depth=None), size=wide),
        budget=240.0,
        slow=True,
    )
    yield Case(
        "500 random cuts of 3 mm, 1 mm deep",
        "many cuts",
        lambda: opened(*scattered(500, 3.0, wide, seed=2, depth=1.0), size=wide),
        budget=240.0,
        slow=True,
    )
    yield Case(
        "60 random cuts that cross, in 3 frames",
        "many cuts",
        lambda: opened(*scattered(60, 8.0, (24.0, 16.0, TOP), seed=3, depth=None, times=3)),
        budget=120.0,
    )
    grid = [line(f"x_{k + 8}", 1.0, (k, -6), (k, 6)) for k in range(-8, 9, 2)]
    grid += [line(f"y_{k + 6}", 2.0, (-8, k), (8, k)) for k in range(-6, 7, 2)]
    yield Case("diced into squares of 2 mm", "many cuts", lambda: opened(*grid), budget=120.0)
    comb = [line(f"x_{k + 16}", 1.0, (0.25 * k, -6), (0.25 * k, 6), kerf=0.02) for k in range(-16, 17)]
    yield Case("33 cuts a quarter of a cell apart", "many cuts", lambda: opened(*comb), budget=120.0)
