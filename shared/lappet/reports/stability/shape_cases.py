"""Cases of the tissue's shape and size: thin, loose, tiny and vast tissue, from one cell to a million."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Incision, Suture, Undermine
from lappet.program.program import Program
from lappet.reports.stability.case import Case, Check, Scene, Solved
from lappet.reports.stability.scenes import (
    BELOW,
    LEFT,
    RIGHT,
    Vector,
    block,
    compiled,
    loose,
    moved,
    patch,
    procedure,
    stretched,
)
from lappet.tissue.patch import flat_patch


def shape_cases() -> Iterator[Case]:
    """List the groups thin, floating, scale and spacing.

    Yields
    ------
    Case
        The cases.
    """
    yield from _thin()
    yield from _floating()
    yield from _scale()
    yield from _spacing()


def needle(width: float) -> Program:
    """Make a strip 14 mm long, freed on three sides and from its bed, lifted at its tip by 6 mm.

    Parameters
    ----------
    width
        Its width in mm.

    Returns
    -------
    Program
        The program.
    """
    x, y = 7.0, width / 2
    outline = ((x, -y, 2.0), (-x, -y, 2.0), (-x, y, 2.0), (x, y, 2.0))
    ring = ((x, -y, 2.0), (x, y, 2.0), (-x, y, 2.0), (-x, -y, 2.0))
    tip = (-x + 0.5, 0.0, 2.0)
    lift = Hook("lift", tip, ((2.0, tip), (4.0, (-x + 0.5, 0.0, 8.0))), 2.0, 9.0, 20.0)
    made = procedure(patch(), Incision("flap", 1.0, outline, kerf=0.1), Undermine("free", 1.0, ring), lift, end=4.0)
    return compiled(made)


def _thin() -> Iterator[Case]:
    for width in (1.0, 0.5, 2.0):
        yield Case(f"needle flap {width:g} cells wide, lifted", "thin", lambda w=width: needle(w))

    def sheet(**more: Any) -> Program:
        tissue = loose(flat_patch((24.0, 16.0, 1.0), resolution=2.0, spacing=1.0))
        lift = Hook("lift", (0.0, 0.0, 1.0), ((1.0, (0.0, 0.0, 1.0)), (3.0, (0.0, 0.0, 6.0))), 1.0, 9.0, 100.0)
        return compiled(procedure(tissue, lift), **more)

    yield Case("sheet one cell thick, lifted", "thin", sheet)
    yield Case("sheet half a cell thick, lifted", "thin", lambda: sheet(spacing=2.0))
    yield Case("bar one cell wide, stretched", "thin", lambda: stretched(1.5, size=(24.0, 1.0, 1.0), spacing=1.0))
    yield Case("bar one cell wide, pressed to 80 %", "thin", lambda: stretched(0.8, size=(24.0, 1.0, 1.0), spacing=1.0))
    yield Case(
        "sheet a hundredth of a cell thick",
        "thin",
        lambda: stretched(1.3, size=(16.0, 16.0, 0.02), spacing=2.0),
        demands=ProblemCode.SOLVER_INVALID_INPUT,
    )
    ring = tuple((5.0 * np.cos(a), 5.0 * np.sin(a), 2.0) for a in np.linspace(0.1, 2 * np.pi - 0.1, 24))
    yield Case("island that a single cell holds, lifted", "thin", lambda: island(ring, 20.0))


def island(ring: tuple[Vector, ...], stiffness: float, **more: Any) -> Program:
    """Make a patch in which a ring is cut and what lies inside is freed from the bed.

    A hook lifts its middle by 5 mm.

    Parameters
    ----------
    ring
        Points of the ring in mm.
    stiffness
        Stiffness of the hook in mN/mm.
    **more
        What `procedure` and `patch` take besides.

    Returns
    -------
    Program
        The program.
    """
    closed = bool(more.pop("closed", False))
    lift = Hook("lift", (0.0, 0.0, 2.0), ((2.0, (0.0, 0.0, 2.0)), (4.0, (0.0, 0.0, 7.0))), 2.0, 9.0, stiffness)
    cut = Incision("ring", 1.0, ring, kerf=0.1, closed=closed)
    free = Undermine("free", 1.0, ring)
    return compiled(procedure(patch(), cut, free, *([lift] if stiffness else []), end=4.0), **more)


def _floating() -> Iterator[Case]:
    ring: tuple[Vector, ...] = ((-5.0, -5.0, 2.0), (5.0, -5.0, 2.0), (5.0, 5.0, 2.0), (-5.0, 5.0, 2.0))
    yield Case("island cut out, left alone", "floating", lambda: island(ring, 0.0, closed=True))
    yield Case("island cut out, lifted by a hook", "floating", lambda: island(ring, 20.0, closed=True))
    small = (4.0, 4.0, 4.0)
    yield Case("block held by nothing", "floating", lambda: Scene(block(small, 1.0), check=_at_rest))
    hook = (((2.0, 2.0, 4.0), (5.0, 4.0, 9.0), 50.0),)
    for spacing in (1.0, 0.5, 0.25):
        yield Case(
            f"block held by a hook only, cells of {spacing:g} mm",
            "floating",
            lambda h=spacing: Scene(block(small, h, hooks=hook), check=_follows),
        )
    hooks = (*hook, ((0.0, 0.0, 0.0), (1.0, 1.0, 5.0), 50.0), ((4.0, 4.0, 0.0), (5.0, 6.0, 5.0), 50.0))
    yield Case("block held by three hooks", "floating", lambda: block(small, 1.0, hooks=hooks))
    gravity = (0.0, 0.0, -9.81)
    yield Case("block held by nothing, falling", "floating", lambda: block(small, 1.0, gravity=gravity))
    yield Case("block held by a hook, hanging", "floating", lambda: block(small, 1.0, gravity=gravity, hooks=hook))
    halves = Incision("through", 1.0, ((0.0, -9.0, 2.0), (0.0, 9.0, 2.0)), kerf=0.1)
    ends = ((-1.0, 0.0, 2.0), (1.0, 0.0, 2.0))

    def two(*, rim: bool) -> Program:
        events = (halves, Suture("stitch", ends, 2.0, 1.0))
        return compiled(procedure(loose(patch(), rim=rim), *events))

    yield Case("halves held by their rims, sewn", "floating", lambda: two(rim=True))
    yield Case("loose halves, sewn together", "floating", lambda: two(rim=False))
    yield Case(
        "block moved by a retractor only",
        "floating",
        lambda: block(small, 1.0, gripped=(LEFT,), motions=[[moved((9.0, 0.0, 0.0), 90.0)]]),
    )


def _at_rest(solved: Solved) -> str:
    off = float(np.abs(solved.frames[-1].points - solved.program.epochs[0].surface.points).max())
    return "" if off < 1e-6 else f"Tissue on which nothing acts has moved by {off:.3g} mm."


def _follows(solved: Solved) -> str:
    left = float(np.linalg.norm(solved.frames[-1].hook_points[0] - (5.0, 4.0, 9.0)))
    return "" if left < 0.05 else f"A loose block stays {left:.3g} mm from the hook that nothing resists."


def scaled_patch(unit: float, stiffness: float = 20.0, **more: Any) -> Program:
    """Make a slit of 12 mm in a patch of 24 x 16 x 2 mm with a hook and sutures, scaled.

    Parameters
    ----------
    unit
        Factor of every length.
    stiffness
        Stiffness of the hook in mN/mm.
    **more
        What `procedure` and `patch` take besides.

    Returns
    -------
    Program
        The program.
    """

    def at(*point: float) -> Vector:
        x, y, z = (unit * value for value in point)
        return (x, y, z)

    tissue = flat_patch(
        at(24.0, 16.0, 2.0),
        resolution=2.0 * unit,
        spacing=unit,
        gravity=0.0,  # weight grows faster with the unit than what holds
        bed_stiffness=10.0 / unit,
        bed_shear=10.0 / unit,
    )
    events = (
        Incision("slit", 1.0, (at(-6, 0, 2), at(6, 0, 2)), kerf=0.1 * unit),
        Suture("stitch", (at(3, -1.5, 2), at(3, 1.5, 2)), 2.0, 1.0),
        Hook("lift", at(-2, 1, 2), ((2.0, at(-2, 1, 2)), (3.0, at(-2, 2, 4))), 2.0, 9.0, stiffness * unit),
    )
    return compiled(procedure(tissue, *events), **more)


def _scale() -> Iterator[Case]:
    for name, unit in (("micrometres", 1e-3), ("metres", 1e3), ("kilometres", 1e6)):
        for precision in ("float", "double"):
            size = (16.0 * unit, 8.0 * unit, 8.0 * unit)
            yield Case(
                f"bar of 16 {name}, stretched by 30 %, {precision}",
                "scale",
                lambda s=size, u=unit, p=precision: Scene(
                    stretched(1.3, size=s, spacing=2.0 * u, precision=p), check=_as_in_mm(u)
                ),
            )
    for unit in (1e-3, 1e-2, 0.03, 0.1, 0.3, 1e3, 1e6):
        yield Case(
            f"patch of {24 * unit:g} mm, cut, lifted, sewn",
            "scale",
            lambda u=unit: Scene(scaled_patch(u), check=_like_twin(u), twin=scaled_patch(1.0)),
        )
    yield Case(
        "block 1 km from the origin",
        "scale",
        lambda: _far(stretched(1.3), 1e6),
    )


def _as_in_mm(unit: float) -> Check:
    """A check: the sides draw in by the same share of the width as those of a bar in mm.

    That is by 5 to 13 % (neo-Hookean, stretch 1.3, Poisson's ratio 0.45, its ends being held).
    """

    def check(solved: Solved) -> str:
        points = solved.frames[-1].points / unit
        middle = points[np.abs(points[:, 0] - 8.0 * 1.3) < 1.5]
        width = float(np.ptp(middle[:, 1])) / 8.0
        return "" if 0.87 < width < 0.95 else f"In its middle the bar is {width:.3f} times as wide as before."

    return check


def _like_twin(unit: float) -> Check:
    """A check: the hook's anchor and force are those of the twin in mm, with lengths times `unit`.

    What a hook and a suture grip is a millimeter wide however large the patch, so in large units they hold less.
    """
    most = 0.01 if unit < 1.0 else 0.6

    def check(solved: Solved) -> str:
        assert solved.twin is not None
        here, there = solved.frames[-1], solved.twin
        off = float(np.abs(here.hook_points / unit - there.hook_points).max())
        force = float(np.abs(here.hook_forces / unit**2 - there.hook_forces).max() / np.abs(there.hook_forces).max())
        if off < most and force < most:
            return ""
        return f"In units of {unit:g} mm the anchor is off by {off:.3g} and the force by {force:.1%}."

    return check


def _far(program: Program, off: float) -> Program:
    (epoch,) = program.epochs
    surface = replace(epoch.surface, points=epoch.surface.points + off)
    settings = replace(program.settings, origin=(off, off, off))
    return replace(program, epochs=(replace(epoch, surface=surface),), settings=settings)


def _spacing() -> Iterator[Case]:
    for cells in (1, 2, 5, 10):
        yield Case(
            f"cube of {cells**3} cells, stretched by 30 %",
            "spacing",
            lambda n=cells: stretched(1.3, size=(10.0, 10.0, 10.0), spacing=10.0 / n),
        )
    yield Case(
        "spacing ten times the tissue",
        "spacing",
        lambda: stretched(1.3, size=(10.0, 10.0, 10.0), spacing=100.0),
        demands=ProblemCode.SOLVER_INVALID_INPUT,
    )
    for cells, budget in ((46, 120.0), (100, 600.0)):
        yield Case(
            f"cube of {cells**3} cells, stretched by 30 %",
            "spacing",
            lambda n=cells: stretched(1.3, size=(10.0, 10.0, 10.0), spacing=10.0 / n),
            budget=budget,
            slow=True,
        )
    yield Case(
        "spacing of a micrometre for 10 mm",
        "spacing",
        lambda: stretched(1.3, size=(10.0, 10.0, 10.0), spacing=1e-3),
        demands=ProblemCode.SOLVER_MEMORY_BUDGET,
    )
    yield Case(
        "slab of 1 x 64 x 64 cells, sheared by its thickness",
        "spacing",
        lambda: block((64.0, 64.0, 1.0), 1.0, fixed=(BELOW,), gripped=(5,), motions=[[moved((1.0, 0.0, 0.0))]]),
    )
    yield Case(
        "bar of 200 x 1 x 1 cells, stretched to twice its length",
        "spacing",
        lambda: block((200.0, 1.0, 1.0), 1.0, fixed=(LEFT,), gripped=(RIGHT,), motions=[[moved((200.0, 0.0, 0.0))]]),
    )
