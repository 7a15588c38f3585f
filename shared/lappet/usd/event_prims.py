"""The prims of events: how each kind is written to a stage and read from one.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    Basis,
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Point,
    Pressure,
    Retractor,
    Section,
    Suture,
    SutureMode,
    SutureRun,
    Thin,
    Traction,
    Undermine,
)
from lappet.procedure.prim_paths import TIMELINE, TISSUE
from lappet.usd.authoring import Values, curve_prim, points_prim
from lappet.usd.suture_run_prims import read_run, run_prim, write_run
from lappet.usd.values import Reader

# The type of prim that carries each event's schema.
EVENT_PRIMS = {
    "LappetIncisionAPI": "BasisCurves",
    "LappetExcisionAPI": "Points",
    "LappetUndermineAPI": "BasisCurves",
    "LappetThinAPI": "BasisCurves",
    "LappetHookAPI": "Xform",
    "LappetRetractorAPI": "Xform",
    "LappetTractionAPI": "Scope",
    "LappetPressureAPI": "Scope",
    "LappetSutureAPI": "BasisCurves",
    "LappetSutureRunAPI": "BasisCurves",
    "LappetLandmarkAPI": "Points",
    "LappetSectionAPI": "Scope",
}


def write_event(stage: Any, usd: Any, event: Event) -> None:
    """Write an event as a prim of the timeline.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    event
        The event.
    """
    path = f"{TIMELINE}/{event.name}"
    match event:
        case Incision():
            prim = curve_prim(stage, usd, path, event.points, event.basis, event.closed)
        case Undermine() | Thin():
            prim = curve_prim(stage, usd, path, event.points, event.basis, True)
        case Suture():
            prim = curve_prim(stage, usd, path, event.anchors, "linear", False)
        case SutureRun():
            prim = run_prim(stage, usd, path, event)
        case Excision():
            prim = points_prim(stage, usd, path, event.seeds)
        case Landmark():
            prim = points_prim(stage, usd, path, event.points)
        case Hook() | Retractor():
            prim = usd.UsdGeom.Xform.Define(stage, path).GetPrim()
        case Traction() | Pressure() | Section():
            prim = usd.UsdGeom.Scope.Define(stage, path).GetPrim()
    prim.AddAppliedSchema(f"Lappet{event.kind}API")
    values = Values(prim, usd)
    match event:
        case Incision():
            values.double("time", event.time)
            values.author("through", usd.Sdf.ValueTypeNames.Bool, event.depth is None)
            values.double("depth", 0.0 if event.depth is None else event.depth)
            values.double("kerf", event.kerf)
            if event.direction is not None:
                values.author("direction", usd.Sdf.ValueTypeNames.Double3, usd.Gf.Vec3d(*event.direction))
        case Excision() | Undermine() | Thin():
            values.double("time", event.time)
            for name in ("thickness", "dressing", "duration") if isinstance(event, Thin) else ():
                values.double(name, getattr(event, name))
        case Hook():
            values.author("anchor", usd.Sdf.ValueTypeNames.Point3d, usd.Gf.Vec3d(*event.anchor))
            values.double("stiffness", event.stiffness)
            values.double("start", event.start)
            values.double("release", event.release)
            translate = usd.UsdGeom.Xformable(prim).AddTranslateOp(usd.UsdGeom.XformOp.PrecisionDouble)
            for time, target in event.targets:
                translate.Set(usd.Gf.Vec3d(*target), time)
        case Retractor():
            if event.grip:
                values.relate("grip", f"{TISSUE}/{event.grip}")
            values.double("start", event.start)
            values.double("release", event.release)
            transform = usd.UsdGeom.Xformable(prim).AddTransformOp(usd.UsdGeom.XformOp.PrecisionDouble)
            for time, matrix in event.motion:
                transform.Set(usd.Gf.Matrix4d(*matrix), time)
        case Suture():
            _write_suture(values, usd, event)
        case SutureRun():
            write_run(values, usd, event)
        case Traction() | Pressure():
            _write_load(values, event)
        case Landmark():
            values.author("label", usd.Sdf.ValueTypeNames.String, event.label)
        case Section():
            _write_section(values, usd, event)


def _write_suture(values: Values, usd: Any, event: Suture) -> None:
    anchors = usd.Vt.Vec3dArray([usd.Gf.Vec3d(*anchor) for anchor in event.anchors])
    values.author("anchors", usd.Sdf.ValueTypeNames.Point3dArray, anchors)
    values.double("start", event.start)
    values.double("duration", event.duration)
    values.double("stiffness", event.stiffness)
    if event.mode != Suture.mode:
        values.author("mode", usd.Sdf.ValueTypeNames.Token, event.mode)
    if event.thread:
        values.author("thread", usd.Sdf.ValueTypeNames.Token, event.thread)
    for name in ("length", "tension", "pullThrough"):
        value = getattr(event, "pull_through" if name == "pullThrough" else name)
        if value != 0.0:
            values.double(name, value)


def _write_section(values: Values, usd: Any, event: Section) -> None:
    values.author("label", usd.Sdf.ValueTypeNames.String, event.label)
    values.author("point", usd.Sdf.ValueTypeNames.Point3d, usd.Gf.Vec3d(*event.point))
    values.author("normal", usd.Sdf.ValueTypeNames.Double3, usd.Gf.Vec3d(*event.normal))


def _write_load(values: Values, event: Traction | Pressure) -> None:
    if event.faces:
        values.relate("faces", f"{TISSUE}/{event.faces}")
    if isinstance(event, Traction):
        values.vector_samples("traction", event.traction)
    else:
        values.samples("pressure", event.pressure)
    values.double("start", event.start)
    values.double("release", event.release)


def read_event(reader: Reader, prim: Any, schema: str, tissues: list[Any]) -> Event:
    """Read the event that a prim carries.

    Parameters
    ----------
    reader
        The reader of the stage; gets the problems.
    prim
        The prim.
    schema
        Its schema, one of `EVENT_PRIMS`.
    tissues
        The prims of tissue on the stage.

    Returns
    -------
    Event
        The event; a value that could not be read is NaN or empty.
    """
    name = prim.GetName()
    match schema:
        case "LappetIncisionAPI":
            points, basis, closed = read_curve(reader, prim)
            through = reader.flag(prim, "lappet:through", True)
            time, kerf = reader.number(prim, "lappet:time"), reader.number(prim, "lappet:kerf", Incision.kerf)
            depth = None if through else reader.number(prim, "lappet:depth")
            direction = cast(Point, reader.vector(prim, "lappet:direction", 3, (0.0, 0.0, 0.0)))
            return Incision(name, time, points, depth, kerf, basis, closed, direction if any(direction) else None)
        case "LappetExcisionAPI":
            return Excision(name, reader.number(prim, "lappet:time"), _tuples(reader.points(prim)))
        case "LappetUndermineAPI" | "LappetThinAPI":
            return _read_area(reader, prim, schema)
        case "LappetHookAPI":
            start, release = reader.number(prim, "lappet:start"), reader.number(prim, "lappet:release")
            anchor = reader.space.placed(np.array([reader.vector(prim, "lappet:anchor", 3)]), prim.GetParent())
            moves = tuple((time, cast(Point, tuple(m[3, :3]))) for time, m in _targets(reader, prim, start))
            stiffness = reader.number(prim, "lappet:stiffness", Hook.stiffness)
            return Hook(name, _tuples(anchor)[0], moves, start, release, stiffness)
        case "LappetRetractorAPI":
            start, release = reader.number(prim, "lappet:start"), reader.number(prim, "lappet:release")
            motion = tuple((time, tuple(m.ravel())) for time, m in reader.space.motion(prim, start))
            grip = _faces(reader, prim, "grip", tissues, (ProblemCode.GRIP_MISSING, ProblemCode.GRIP_ELSEWHERE))
            return Retractor(name, grip, motion, start, release)
        case "LappetTractionAPI" | "LappetPressureAPI" | "LappetSectionAPI":
            return _read_load_or_section(reader, prim, schema, tissues)
        case "LappetSutureRunAPI":
            return read_run(reader, prim)
        case "LappetSutureAPI":
            start = reader.number(prim, "lappet:start")
            anchors = _tuples(reader.space.placed(reader.vectors(prim, "lappet:anchors"), prim.GetParent()))
            if len(anchors) < 2:
                reader.problem(ProblemCode.SUTURE_ANCHORS, prim.GetPath(), len(anchors))
                anchors = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
            duration = reader.number(prim, "lappet:duration", Suture.duration)
            return Suture(
                name,
                anchors,
                start,
                duration,
                reader.number(prim, "lappet:stiffness", Suture.stiffness),
                cast(SutureMode, reader.text(prim, "lappet:mode", Suture.mode)),
                reader.text(prim, "lappet:thread", ""),
                reader.number(prim, "lappet:length", Suture.length),
                reader.number(prim, "lappet:tension", Suture.tension),
                reader.number(prim, "lappet:pullThrough", Suture.pull_through),
            )
        case _:
            return Landmark(name, _tuples(reader.points(prim)), reader.text(prim, "lappet:label", name))


def _read_area(reader: Reader, prim: Any, schema: str) -> Undermine | Thin:
    """An area that is undermined or thinned."""
    name, time = prim.GetName(), reader.number(prim, "lappet:time")
    points, basis, closed = read_curve(reader, prim)
    thinned = schema == "LappetThinAPI"
    if not closed:
        code = ProblemCode.THIN_OPEN_CURVE if thinned else ProblemCode.UNDERMINE_OPEN_CURVE
        reader.problem(code, prim.GetPath(), "nonperiodic")
    if not thinned:
        return Undermine(name, time, points, basis)
    dressing = reader.number(prim, "lappet:dressing", Thin.dressing)
    duration = reader.number(prim, "lappet:duration", Thin.duration)
    return Thin(name, time, points, reader.number(prim, "lappet:thickness"), basis, dressing, duration)


def _targets(reader: Reader, prim: Any, start: float) -> list[tuple[float, NDArray[np.float64]]]:
    """Transforms of a hook; none where nothing places it: the origin is no target."""
    motion = reader.space.motion(prim, start)
    return motion if len(motion) > 1 or reader.usd.UsdGeom.Xformable(prim).GetOrderedXformOps() else []


def _read_load_or_section(reader: Reader, prim: Any, schema: str, tissues: list[Any]) -> Event:
    name = prim.GetName()
    if schema == "LappetSectionAPI":
        (point,) = _tuples(reader.space.placed(np.array([reader.vector(prim, "lappet:point", 3)]), prim.GetParent()))
        normal = cast(Point, reader.vector(prim, "lappet:normal", 3))
        return Section(name, point, normal, reader.text(prim, "lappet:label", name))
    start, release = reader.number(prim, "lappet:start"), reader.number(prim, "lappet:release")
    faces = _faces(reader, prim, "faces", tissues, (ProblemCode.LOAD_MISSING, ProblemCode.LOAD_ELSEWHERE))
    if schema == "LappetPressureAPI":
        return Pressure(name, faces, reader.samples(prim, "lappet:pressure"), start, release)
    return Traction(name, faces, reader.vector_samples(prim, "lappet:traction"), start, release)


def _faces(
    reader: Reader, prim: Any, relation: str, tissues: list[Any], missing_elsewhere: tuple[ProblemCode, ProblemCode]
) -> str:
    """The name of the face subset of the tissue that a relationship points to."""
    target = reader.target(prim, f"lappet:{relation}")
    missing, elsewhere = missing_elsewhere
    parent, _, name = target.rpartition("/")
    if not target:
        reader.problem(missing, prim.GetPath(), f"no {relation}")
    elif tissues and parent != str(tissues[0].GetPath()):
        reader.problem(elsewhere, prim.GetPath(), target, tissue=tissues[0].GetPath())
    return name


def read_curve(reader: Reader, prim: Any) -> tuple[tuple[Point, ...], Basis, bool]:
    """Read a prim with one curve; a pinned curve gets its phantom points.

    Parameters
    ----------
    reader
        The reader of the stage; gets the problems.
    prim
        The prim.

    Returns
    -------
    tuple[tuple[Point, ...], Basis, bool]
        Its points, its basis and whether it is closed.
    """
    points = reader.points(prim)
    counts = reader.integers(prim, "curveVertexCounts")
    if len(counts) != 1:
        reader.problem(ProblemCode.CURVE_SEVERAL, prim.GetPath(), len(counts))
    elif counts[0] != len(points):
        reader.problem(ProblemCode.CURVE_COUNT, prim.GetPath(), int(counts[0]), points=len(points))
    kind = str(prim.GetAttribute("type").Get() or "cubic")
    basis = "linear" if kind == "linear" else str(prim.GetAttribute("basis").Get() or "bezier")
    if basis not in ("linear", "bspline", "catmullRom", "bezier"):
        reader.problem(ProblemCode.CURVE_UNKNOWN_BASIS, prim.GetPath(), basis)
        basis = "linear"
    wrap = str(prim.GetAttribute("wrap").Get() or "nonperiodic")
    if wrap == "pinned" and basis in ("bspline", "catmullRom") and len(points) >= 2:
        points = np.concatenate([[2 * points[0] - points[1]], points, [2 * points[-1] - points[-2]]])
        reader.notes.append(problem(ProblemCode.CURVE_PINNED, prim.GetPath(), wrap))
    return _tuples(points), cast(Basis, basis), wrap == "periodic"


def _tuples(points: NDArray[np.float64]) -> tuple[Point, ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in points)
