"""Marks on the skin are at their distance at rest, deform with it, and span no wound."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from lappet.core.problem_code import ProblemCode
from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.skin_read import SkinCache
from lappet.plates.draw_plate import PlateOptions, draw_plate
from lappet.plates.drawn_surface import DrawnSurface, drawn_surface
from lappet.plates.feature_lines import LineKind
from lappet.plates.printed_marks import MARKS, printed_marks, skin_lines
from refusals import refuses

SPACING = 5.0


def surface_at(cache: SkinCache, time: float) -> DrawnSurface:
    return drawn_surface(cache, DeepBed(cache), (), time)


def test_a_grid_on_flat_skin_has_straight_lines_at_its_spacing(cache: SkinCache) -> None:
    lines = printed_marks(cache, surface_at(cache, cache.frames[0]), "grid", SPACING)
    values: dict[int, set[float]] = {0: set(), 1: set()}
    for line in lines:
        assert line.kind is LineKind.MARK
        across = int(np.argmin(np.ptp(line.points[:, :2], axis=0)))
        assert np.ptp(line.points[:, across]) < 1e-3
        values[across].add(round(float(line.points[0, across]), 3))
    for own in values.values():
        assert len(own) >= 4
        assert np.diff(sorted(own)) == pytest.approx(SPACING, abs=1e-3)


def test_dots_lie_where_the_lines_of_the_grid_cross_and_squares_about_them(cache: SkinCache) -> None:
    surface = surface_at(cache, cache.frames[0])
    dots = np.array([each.points[0, :2] for each in printed_marks(cache, surface, "dots", SPACING)])
    grid = printed_marks(cache, surface, "grid", SPACING)
    levels = [
        sorted({round(float(each.points[0, k]), 3) for each in grid if np.ptp(each.points[:, k]) < 1e-3})
        for k in (0, 1)
    ]
    half = np.abs(cache.rest(cache.epochs[0])[:, :2]).max(axis=0)
    inner = dots[(np.abs(dots) < half - 1e-3).all(axis=1)]  # a dot may lie on the rim, a line does not
    crossings = {(x, y) for x in levels[0] for y in levels[1] if (np.abs((x, y)) < half - 1e-3).all()}
    assert {tuple(np.round(each, 3)) for each in inner} == crossings
    squares = [each.points for each in printed_marks(cache, surface, "squares", SPACING) if len(each.points) == 33]
    assert len(squares) >= 0.5 * len(dots)
    for ring in squares:
        assert np.ptp(ring[:, :2], axis=0) == pytest.approx([0.4 * SPACING] * 2, abs=1e-3)
        assert np.linalg.norm(dots - ring[:-1, :2].mean(axis=0), axis=1).min() < 0.05


@pytest.mark.parametrize("marks", MARKS)
def test_no_mark_spans_the_wound(cache: SkinCache, marks: str) -> None:
    time = cache.frames[len(cache.frames) // 2]
    surface = surface_at(cache, time)
    skin = surface.triangles[surface.origin == 0]
    edges = np.linalg.norm(surface.points[skin] - surface.points[np.roll(skin, 1, axis=1)], axis=2)
    for line in printed_marks(cache, surface, marks, SPACING):
        assert np.linalg.norm(np.diff(line.points, axis=0), axis=1).max() <= edges.max()


def test_skin_lines_of_the_procedure_ride_on_the_skin(cache_file: Path, cache: SkinCache) -> None:
    assert skin_lines(cache, cache.frames[0]) == []
    stage = Usd.Stage.Open(str(cache_file))
    curve = UsdGeom.BasisCurves.Define(stage, "/Procedure/SkinLines/across")
    curve.CreateTypeAttr("linear")
    height = float(cache.rest(cache.epochs[0])[:, 2].max())
    curve.CreatePointsAttr([(-20.0, 14.0, height), (20.0, 14.0, height)])
    drawn = SkinCache(cache_file, stage)
    (whole,) = skin_lines(drawn, drawn.frames[0])
    assert whole.kind is LineKind.SKIN_LINE
    assert whole.points[:, 1] == pytest.approx(14.0, abs=1e-3)
    assert np.ptp(whole.points[:, 0]) == pytest.approx(40.0, abs=0.1)
    (later,) = skin_lines(drawn, drawn.frames[len(drawn.frames) // 2])
    assert np.abs(later.points - whole.points).max() > 0.1


def test_marks_too_near_to_each_other_are_refused(cache_file: Path, tmp_path: Path) -> None:
    options = PlateOptions(shown={"marks": "grid", "marks_spacing": 0.2})
    with refuses(ProblemCode.PLATE_MARKS):
        draw_plate([cache_file], [tmp_path / "plate.svg"], options)
