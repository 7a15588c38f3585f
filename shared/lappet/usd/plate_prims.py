"""The prims of plates: pages, their panels below them, and their annotations.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from lappet.core.problem import Problem, RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.procedure.exact_values import Point
from lappet.procedure.plate import (
    ANNOTATION_ANCHORS,
    PANEL_STEPS,
    PLAN_PENS,
    PLATE_MARKS,
    PLATE_STYLES,
    PLATE_VIEWS,
    AnnotationKind,
    PanelStep,
    PlanPen,
    Plate,
    PlateAnnotation,
    PlateMarks,
    PlatePanel,
    PlateStyleName,
    PlateView,
    WhenExcised,
)
from lappet.procedure.prim_paths import PLATES
from lappet.usd.authoring import Values, points_prim
from lappet.usd.values import Reader

_FLAGS = ("labels", "letters", "arrows", "measures", "instruments")
_EXCISED: tuple[WhenExcised, ...] = ("leave-out", "last-place")


def write_plate(stage: Any, usd: Any, plate: Plate) -> None:
    """Write a plate as prims.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    plate
        The plate.
    """
    path = f"{PLATES}/{plate.name}"
    prim = usd.UsdGeom.Scope.Define(stage, path).GetPrim()
    prim.AddAppliedSchema("LappetPlateAPI")
    values, types = Values(prim, usd), usd.Sdf.ValueTypeNames
    values.author("style", types.Token, plate.style)
    values.author("tone", types.Int, plate.tone)
    values.double("width", plate.width)
    values.author("columns", types.Int, plate.columns)
    values.author("language", types.Token, plate.language)
    values.author("view", types.Token, plate.view)
    values.author("quantity", types.Token, plate.quantity)
    if plate.text:
        values.double("text", plate.text)
    if plate.journal:
        values.author("journal", types.Token, plate.journal)
    if plate.marks:
        values.author("marks", types.Token, plate.marks)
        values.double("marksSpacing", plate.marks_spacing)
    if plate.skin_lines:
        values.author("skinLines", types.Bool, True)
    if plate.plan_pen:
        values.author("planPen", types.Token, plate.plan_pen)
    if not plate.hatched:
        values.author("hatched", types.Bool, False)
    _write_section(values, usd, plate)
    for name in _FLAGS:
        values.author(name, types.Bool, getattr(plate, name))
    if plate.landmarks:
        values.author("landmarks", types.StringArray, usd.Vt.StringArray(list(plate.landmarks)))
    for panel in plate.panels:
        _write_panel(stage, usd, f"{path}/Panels/{panel.name}", panel)
    for note in plate.annotations:
        _write_annotation(stage, usd, f"{path}/Annotations/{note.name}", note)
    for name in ("Panels", "Annotations"):
        if stage.GetPrimAtPath(f"{path}/{name}"):
            usd.UsdGeom.Scope.Define(stage, f"{path}/{name}")


def _write_panel(stage: Any, usd: Any, path: str, panel: PlatePanel) -> None:
    prim = usd.UsdGeom.Scope.Define(stage, path).GetPrim()
    prim.AddAppliedSchema("LappetPanelAPI")
    values, types = Values(prim, usd), usd.Sdf.ValueTypeNames
    if panel.step:
        values.author("step", types.Token, panel.step)
    else:
        values.double("time", panel.time)
    for name, text, kind in (
        ("caption", panel.caption, types.String),
        ("view", panel.view, types.Token),
        ("insetOf", panel.inset_of, types.Token),
        ("ghost", panel.ghost, types.Token),
    ):
        if text:
            values.author(name, kind, text)
    if panel.ghost_filled:
        values.author("ghostFilled", types.Bool, True)
    if panel.at is not None:
        values.author("at", types.Point3d, usd.Gf.Vec3d(*panel.at))
        values.double("across", panel.across)
    if panel.look_from is not None and panel.look_up is not None:
        values.author("lookFrom", types.Vector3d, usd.Gf.Vec3d(*panel.look_from))
        values.author("lookUp", types.Vector3d, usd.Gf.Vec3d(*panel.look_up))
    _write_section(values, usd, panel)


def _write_section(values: Values, usd: Any, whose: Plate | PlatePanel) -> None:
    if whose.section_at is not None and whose.section_normal is not None:
        values.author("sectionAt", usd.Sdf.ValueTypeNames.Point3d, usd.Gf.Vec3d(*whose.section_at))
        values.author("sectionNormal", usd.Sdf.ValueTypeNames.Vector3d, usd.Gf.Vec3d(*whose.section_normal))


def _write_annotation(stage: Any, usd: Any, path: str, note: PlateAnnotation) -> None:
    prim = points_prim(stage, usd, path, note.anchors)
    usd.UsdGeom.Imageable(prim).CreatePurposeAttr(usd.UsdGeom.Tokens.guide)
    prim.AddAppliedSchema("LappetAnnotationAPI")
    values, types = Values(prim, usd), usd.Sdf.ValueTypeNames
    values.author("kind", types.Token, note.kind)
    if note.text:
        values.author("text", types.String, note.text)
    if note.panels:
        values.author("panels", types.TokenArray, usd.Vt.TokenArray(list(note.panels)))
    if note.offset is not None:
        values.author("offset", types.Double2, usd.Gf.Vec2d(*note.offset))
    values.author("whenExcised", types.Token, note.when_excised)


def read_plates(
    reader: Reader, plates: Sequence[Any], panels: Sequence[Any], annotations: Sequence[Any]
) -> tuple[Plate, ...]:
    """Read plates with what lies below them.

    Parameters
    ----------
    reader
        The reader of the stage; gets the problems.
    plates, panels, annotations
        The prims that carry the schemas of plates, panels and annotations.

    Returns
    -------
    tuple[Plate, ...]
        The plates; a value that could not be read is the default.
    """
    found = []
    for prim in plates:
        own = prim.GetPath()
        found.append(
            _plate(
                reader,
                prim,
                tuple(_panel(reader, each) for each in panels if each.GetPath().HasPrefix(own)),
                tuple(_annotation(reader, each) for each in annotations if each.GetPath().HasPrefix(own)),
            )
        )
    return tuple(found)


def read_plates_of(stage: Any, usd: Any, notes: list[Problem]) -> tuple[Plate, ...]:
    """Read the plates on an open stage, such as a skin cache above its procedure.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    notes
        Gets a note of what was converted or left aside.

    Returns
    -------
    tuple[Plate, ...]
        The plates.

    Raises
    ------
    RefusedError
        If something kept one of them from being read.
    """
    reader = Reader(stage, usd, notes)
    found: dict[str, list[Any]] = {"LappetPlateAPI": [], "LappetPanelAPI": [], "LappetAnnotationAPI": []}
    for prim in stage.Traverse():
        for schema in map(str, prim.GetPrimTypeInfo().GetAppliedAPISchemas()):
            if schema in found:
                found[schema].append(prim)
    plates = read_plates(reader, *found.values())
    if reader.problems:
        raise RefusedError(reader.problems)
    return plates


def _plate(
    reader: Reader, prim: Any, panels: tuple[PlatePanel, ...], annotations: tuple[PlateAnnotation, ...]
) -> Plate:
    flags: Mapping[str, bool] = {name: reader.flag(prim, f"lappet:{name}", True) for name in _FLAGS}
    return Plate(
        prim.GetName(),
        cast(PlateStyleName, _one_of(reader, prim, "style", PLATE_STYLES, Plate.style)),
        int(reader.number(prim, "lappet:tone", 0.0)),
        reader.number(prim, "lappet:width", Plate.width),
        int(reader.number(prim, "lappet:columns", 0.0)),
        reader.text(prim, "lappet:language", Plate.language),
        cast(PlateView, _one_of(reader, prim, "view", PLATE_VIEWS, Plate.view)),
        reader.text(prim, "lappet:quantity", ""),
        _place(reader, prim, "sectionAt"),
        _way(reader, prim, "sectionNormal"),
        **flags,
        landmarks=reader.texts(prim, "lappet:landmarks", ()),
        panels=panels,
        annotations=annotations,
        text=reader.number(prim, "lappet:text", 0.0),
        journal=reader.text(prim, "lappet:journal", ""),
        marks=cast(PlateMarks, _one_of(reader, prim, "marks", PLATE_MARKS, "")),
        marks_spacing=reader.number(prim, "lappet:marksSpacing", Plate.marks_spacing),
        skin_lines=reader.flag(prim, "lappet:skinLines", False),
        plan_pen=cast(PlanPen, _one_of(reader, prim, "planPen", PLAN_PENS, "")),
        hatched=reader.flag(prim, "lappet:hatched", True),
    )


def _panel(reader: Reader, prim: Any) -> PlatePanel:
    step = _one_of(reader, prim, "step", PANEL_STEPS, "")
    return PlatePanel(
        prim.GetName(),
        cast(PanelStep, step),
        reader.number(prim, "lappet:time", 0.0) if not step else 0.0,
        reader.text(prim, "lappet:caption", ""),
        cast(PlateView, _one_of(reader, prim, "view", ("", *PLATE_VIEWS), "")),
        _place(reader, prim, "at"),
        reader.number(prim, "lappet:across", 0.0),
        reader.text(prim, "lappet:insetOf", ""),
        cast(PanelStep, _one_of(reader, prim, "ghost", PANEL_STEPS, "")),
        _way(reader, prim, "lookFrom"),
        _way(reader, prim, "lookUp"),
        _place(reader, prim, "sectionAt"),
        _way(reader, prim, "sectionNormal"),
        reader.flag(prim, "lappet:ghostFilled", False),
    )


def _annotation(reader: Reader, prim: Any) -> PlateAnnotation:
    anchors = reader.points(prim)
    kind = cast(AnnotationKind, _one_of(reader, prim, "kind", tuple(ANNOTATION_ANCHORS), "label"))
    least, most = ANNOTATION_ANCHORS[kind]
    if not least <= len(anchors) <= most:
        wanted = f"{least}" if least == most else f"{least} to {most}"
        reader.problem(ProblemCode.ANNOTATION_ANCHORS, prim.GetPath(), len(anchors), kind=kind, wanted=wanted)
    offset = reader.vector(prim, "lappet:offset", 2, (np.nan, np.nan))
    return PlateAnnotation(
        prim.GetName(),
        kind,
        cast(tuple[Point, ...], tuple(map(tuple, anchors.tolist()))),
        reader.text(prim, "lappet:text", ""),
        reader.texts(prim, "lappet:panels", ()),
        (offset[0], offset[1]) if np.isfinite(offset).all() else None,
        cast(WhenExcised, _one_of(reader, prim, "whenExcised", _EXCISED, "leave-out")),
    )


def _one_of(reader: Reader, prim: Any, name: str, known: Sequence[str], default: str) -> str:
    """A token that must be one of some."""
    value = reader.text(prim, f"lappet:{name}", default)
    if value not in known:
        wanted = ", ".join(each for each in known if each)
        reader.problem(ProblemCode.PLATE_TOKEN, prim.GetPath(), value, name=name, wanted=wanted)
        return default
    return value


def _place(reader: Reader, prim: Any, name: str) -> Point | None:
    """A point at rest in mm, None where nothing is authored."""
    at = reader.vector(prim, f"lappet:{name}", 3, (np.nan,) * 3)
    if not np.isfinite(at).all():
        return None
    return cast(Point, tuple(reader.space.placed(np.array([at]), prim.GetParent())[0].tolist()))


def _way(reader: Reader, prim: Any, name: str) -> Point | None:
    """A direction at rest, None where nothing is authored."""
    way = np.array(reader.vector(prim, f"lappet:{name}", 3, (np.nan,) * 3))
    if not np.isfinite(way).all():
        return None
    matrix = reader.space.to_rest(prim.GetParent())
    if matrix is not None:
        way = way @ matrix[:3, :3]
        way = way / max(float(np.linalg.norm(way)), 1e-300)
    return cast(Point, tuple(way.tolist()))
