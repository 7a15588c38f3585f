"""The prims of laid flaps: how what the flap library made is remembered on a stage.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.procedure import FlapLines, LaidFlap, Point
from lappet.procedure.prim_paths import FLAPS, TIMELINE
from lappet.usd.authoring import Values
from lappet.usd.values import Reader


def write_flap(stage: Any, usd: Any, flap: LaidFlap) -> None:
    """Write a laid flap as a prim.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    flap
        The flap.
    """
    prim = usd.UsdGeom.Scope.Define(stage, f"{FLAPS}/{flap.name}").GetPrim()
    prim.AddAppliedSchema("LappetFlapAPI")
    values, types = Values(prim, usd), usd.Sdf.ValueTypeNames
    values.author("design", types.Token, flap.design)
    values.author("at", types.Point3d, usd.Gf.Vec3d(*flap.at))
    values.author("direction", types.Vector3d, usd.Gf.Vec3d(*flap.direction))
    values.author("measures", types.TokenArray, usd.Vt.TokenArray([name for name, _ in flap.measures]))
    values.author("values", types.DoubleArray, usd.Vt.DoubleArray([value for _, value in flap.measures]))
    values.author("mirrored", types.Bool, flap.mirrored)
    values.double("start", flap.start)
    if flap.lines:
        values.author("lines", types.Token, flap.lines)
    targets = [f"{TIMELINE}/{name}" for name in flap.events]
    prim.CreateRelationship("lappet:events", custom=False).SetTargets(targets)


def read_flap(reader: Reader, prim: Any) -> LaidFlap:
    """Read the laid flap that a prim carries.

    Parameters
    ----------
    reader
        The reader of the stage; gets the problems.
    prim
        The prim.

    Returns
    -------
    LaidFlap
        The flap; a value that could not be read is NaN or empty.
    """
    at = reader.space.placed(np.array([reader.vector(prim, "lappet:at", 3)]), prim.GetParent())[0]
    direction = np.array(reader.vector(prim, "lappet:direction", 3))
    matrix = reader.space.to_rest(prim.GetParent())
    if matrix is not None:
        direction = direction @ matrix[:3, :3]
        direction = direction / max(float(np.linalg.norm(direction)), 1e-300)
    names = reader.texts(prim, "lappet:measures", ())
    values = reader.numbers(prim, "lappet:values")
    if len(names) != len(values):
        reader.problem(ProblemCode.FLAP_MEASURES, prim.GetPath(), len(values), names=len(names))
        names, values = (), ()
    lines = reader.text(prim, "lappet:lines", "")
    if lines not in ("", "along", "across"):
        reader.problem(ProblemCode.FLAP_LINES, prim.GetPath(), lines)
        lines = ""
    made = prim.GetRelationship("lappet:events")
    return LaidFlap(
        prim.GetName(),
        reader.text(prim, "lappet:design"),
        cast(Point, tuple(at.tolist())),
        cast(Point, tuple(direction.tolist())),
        tuple(zip(names, values, strict=True)),
        reader.flag(prim, "lappet:mirrored", False),
        reader.number(prim, "lappet:start"),
        cast(FlapLines, lines),
        tuple(path.name for path in made.GetForwardedTargets()) if made else (),
    )
