"""The prims of suture runs: how a run is written to a stage and read from one.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

import math
from typing import Any, cast

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Point, SutureLayer, SutureMode, SutureOrder, SuturePattern, SutureRun
from lappet.usd.authoring import Values, lines_prim
from lappet.usd.values import Reader


def run_prim(stage: Any, usd: Any, path: str, run: SutureRun) -> Any:
    """Define the prim of a run: a BasisCurves with its two edges.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    path
        Path of the prim.
    run
        The run.

    Returns
    -------
    Any
        The prim.
    """
    return lines_prim(stage, usd, path, run.edges)


def write_run(values: Values, usd: Any, run: SutureRun) -> None:
    """Write the values of a run.

    Parameters
    ----------
    values
        The author of its prim.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    run
        The run.
    """
    types = usd.Sdf.ValueTypeNames
    values.author("sides", types.IntArray, usd.Vt.IntArray(list(run.sides)))
    if run.corners:
        values.author("corners", types.IntArray, usd.Vt.IntArray([number for pair in run.corners for number in pair]))
    if run.insides:
        points = [usd.Gf.Vec3f(*point) for pair in run.insides for point in pair]
        values.author("insides", types.Point3fArray, usd.Vt.Vec3fArray(points))
    values.double("start", run.start)
    values.double("duration", run.duration)
    values.double("spacing", run.spacing)
    for name, value in (("margin", run.margin), ("bite", run.bite)):
        if value is not None:
            values.double(name, value)
    values.author("layers", types.TokenArray, usd.Vt.TokenArray([layer.name for layer in run.layers]))
    values.author("depths", types.DoubleArray, usd.Vt.DoubleArray([layer.depth for layer in run.layers]))
    between = [layer.name for layer in run.layers if layer.between]
    if between:
        values.author("between", types.TokenArray, usd.Vt.TokenArray(between))
    for name, text in (("pattern", run.pattern), ("order", run.order), ("mode", run.mode), ("thread", run.thread)):
        if text != getattr(SutureRun, name) or name in ("pattern", "order"):
            values.author(name, types.Token, text)
    values.double("stiffness", run.stiffness)
    for name, field in (
        ("passDepth", "pass_depth"),
        ("drawn", "drawn"),
        ("tension", "tension"),
        ("pullThrough", "pull_through"),
    ):
        if getattr(run, field) != getattr(SutureRun, field):
            values.double(name, getattr(run, field))


def read_run(reader: Reader, prim: Any) -> SutureRun:
    """Read the run that a prim carries.

    Parameters
    ----------
    reader
        The reader of the stage; gets the problems.
    prim
        The prim.

    Returns
    -------
    SutureRun
        The run; a value that could not be read is NaN or empty.
    """

    def number(name: str, default: float | None = None) -> float:
        return reader.number(prim, f"lappet:{name}", default)

    def optional(name: str) -> float | None:
        value = number(name, math.inf)
        return None if value == math.inf else value

    def text(name: str, default: str) -> str:
        return reader.text(prim, f"lappet:{name}", default)

    return SutureRun(
        prim.GetName(),
        _edges(reader, prim),
        number("start"),
        _sides(reader, prim),
        _corners(reader, prim),
        number("duration", SutureRun.duration),
        number("spacing", SutureRun.spacing),
        optional("margin"),
        optional("bite"),
        _layers(reader, prim),
        cast(SuturePattern, text("pattern", SutureRun.pattern)),
        number("passDepth", SutureRun.pass_depth),
        cast(SutureOrder, text("order", SutureRun.order)),
        cast(SutureMode, text("mode", SutureRun.mode)),
        text("thread", SutureRun.thread),
        number("stiffness", SutureRun.stiffness),
        number("drawn", SutureRun.drawn),
        number("tension", SutureRun.tension),
        number("pullThrough", SutureRun.pull_through),
        _insides(reader, prim),
    )


def _edges(reader: Reader, prim: Any) -> tuple[tuple[Point, ...], tuple[Point, ...]]:
    points = tuple((float(x), float(y), float(z)) for x, y, z in reader.points(prim))
    counts = reader.integers(prim, "curveVertexCounts").tolist()
    if len(counts) != 2 or sum(counts) != len(points) or min(counts) < 0:
        reader.problem(ProblemCode.SUTURE_RUN_EDGES, prim.GetPath(), len(counts), points=len(points))
        return (), ()
    return points[: counts[0]], points[counts[0] :]


def _sides(reader: Reader, prim: Any) -> tuple[int, int]:
    sides = reader.integers(prim, "lappet:sides", optional=True).tolist() or [1, -1]
    if len(sides) != 2:
        reader.problem(ProblemCode.SUTURE_RUN_SIDES, prim.GetPath(), sides)
        return 1, -1
    return sides[0], sides[1]


def _corners(reader: Reader, prim: Any) -> tuple[tuple[int, int], ...]:
    numbers = reader.integers(prim, "lappet:corners", optional=True).tolist()
    if len(numbers) % 2:
        reader.problem(ProblemCode.SUTURE_RUN_CORNERS, prim.GetPath(), numbers)
        return ()
    return tuple(zip(numbers[::2], numbers[1::2], strict=True))


def _insides(reader: Reader, prim: Any) -> tuple[tuple[Point, Point], ...]:
    if not prim.GetAttribute("lappet:insides").HasAuthoredValue():
        return ()
    points = [
        (float(x), float(y), float(z)) for x, y, z in reader.space.placed(reader.vectors(prim, "lappet:insides"), prim)
    ]
    if len(points) % 2:
        reader.problem(ProblemCode.SUTURE_RUN_CORNERS, prim.GetPath(), f"{len(points)} places")
        return ()
    return tuple(zip(points[::2], points[1::2], strict=True))


def _layers(reader: Reader, prim: Any) -> tuple[SutureLayer, ...]:
    names = reader.texts(prim, "lappet:layers", ("skin",))
    between = reader.texts(prim, "lappet:between", ())
    depths = reader.vector(prim, "lappet:depths", len(names), (0.0,) * len(names))
    return tuple(SutureLayer(name, depth, name in between) for name, depth in zip(names, depths, strict=True))
