"""Muscles as prims: a BasisCurves with one linear curve for each strand, whose widths are twice the radii.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Muscle, Point, Strand
from lappet.procedure.prim_paths import MATERIALS, MUSCLES
from lappet.usd.authoring import Values, curve_prim
from lappet.usd.values import Reader


def write_muscle(stage: Any, usd: Any, muscle: Muscle) -> None:
    """Write a muscle as a prim.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    muscle
        The muscle.
    """
    points = [point for strand in muscle.strands for point in strand.points]
    widths = np.array([2.0 * radius for strand in muscle.strands for radius in strand.radii], np.float32)
    prim = curve_prim(stage, usd, f"{MUSCLES}/{muscle.name}", points, "linear", False)
    curves = usd.UsdGeom.BasisCurves(prim)
    curves.GetCurveVertexCountsAttr().Set(usd.Vt.IntArray([len(strand.points) for strand in muscle.strands]))
    curves.CreateWidthsAttr(usd.Vt.FloatArray.FromNumpy(widths))
    curves.SetWidthsInterpolation(usd.UsdGeom.Tokens.vertex)
    prim.AddAppliedSchema("LappetMuscleAPI")
    if muscle.material:
        Values(prim, usd).relate("material", f"{MATERIALS}/{muscle.material}")


def read_muscle(reader: Reader, prim: Any) -> Muscle:
    """Read a muscle.

    Parameters
    ----------
    reader
        The reader of the stage; gets the problems.
    prim
        The prim.

    Returns
    -------
    Muscle
        The muscle; what cannot be read is empty.
    """
    points = reader.points(prim)
    counts = reader.integers(prim, "curveVertexCounts")
    widths = np.array(prim.GetAttribute("widths").Get() or (), np.float64).ravel()
    matrix = reader.space.to_rest(prim)
    if matrix is not None:
        widths = widths * np.cbrt(abs(np.linalg.det(matrix[:3, :3])))
    if len(widths) == 1:
        widths = np.full(len(points), widths[0])
    kind = str(prim.GetAttribute("type").Get() or "cubic")
    if kind != "linear":
        reader.problem(ProblemCode.MUSCLE_NOT_LINEAR, prim.GetPath(), kind)
    strands: list[Strand] = []
    if counts.sum() != len(points) or len(widths) != len(points):
        code = ProblemCode.MUSCLE_COUNTS
        reader.problem(code, prim.GetPath(), int(counts.sum()), points=len(points), widths=len(widths))
    else:
        for begin, count in zip(np.cumsum(counts) - counts, counts, strict=True):
            rows = slice(int(begin), int(begin + count))
            course = cast(tuple[Point, ...], tuple(map(tuple, points[rows].tolist())))
            strands.append(Strand(course, tuple(0.5 * widths[rows])))
    material = reader.target(prim, "lappet:material") or ""
    return Muscle(prim.GetName(), tuple(strands), material.rpartition("/")[2])
