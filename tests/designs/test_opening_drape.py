"""Designs around an opening: on a plane nothing changes, on other skin distances from the border are kept."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.designs import FlapDesign
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.library import library_design
from lappet.designs.opening_drape import OpeningDrape
from lappet.designs.skin_holes import SkinHoles
from lappet.procedure import Tissue
from lappet.tissue.skin_sheet import SkinSheet
from refusals import refuses

MOUTH = 50.0  # mm
MEASURES = {"width": 16.0, "height": 12.0, "mouth": MOUTH, "alar": 14.0}


def sheet_with_mouth(radius: float = np.inf, half: int = 22) -> Tissue:
    """A triangulated skin 100 mm wide with a slit of 50 mm, 0.2 mm wide, bent about an axis along y.

    radius: of the cylinder in mm. half: of its height in mm.
    """
    x, y = np.linspace(-50.0, 50.0, 101), np.linspace(-half, half, 2 * half + 1)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(grid)).reshape(len(x), len(y))
    a, b, c, d = (each.ravel() for each in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]))
    triangles = np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    on_slit = (np.abs(grid[:, 1]) < 1e-9) & (np.abs(grid[:, 0]) < 0.5 * MOUTH - 1e-9)
    twin = np.arange(len(grid))
    twin[on_slit] = len(grid) + np.arange(on_slit.sum())
    above = grid[triangles][:, :, 1].mean(axis=1) > 0.0
    triangles[above] = twin[triangles[above]]
    flat = np.vstack([grid, grid[on_slit]])
    flat[np.flatnonzero(on_slit), 1] -= 0.1
    flat[len(grid) :, 1] += 0.1
    if np.isinf(radius):
        points = np.column_stack([flat, np.zeros(len(flat))])
    else:
        turn = flat[:, 0] / radius
        points = np.column_stack([radius * np.sin(turn), flat[:, 1], radius * np.cos(turn) - radius])
    return Tissue(points, np.full(len(triangles), 3), triangles.ravel())


def laid(tissue: Tissue, **measures: float) -> FlapDesign:
    return flap_on_skin(tissue, "karapandzic", (0.0, -6.0, 0.0), (1.0, 0.0, 0.0), {**MEASURES, **measures})


def cuts(design: FlapDesign) -> NDArray[np.float64]:
    return np.vstack([np.array(curve) for curve in (design.excised[0].outline, *design.incisions)])


@pytest.mark.parametrize("measures", [MEASURES, {**MEASURES, "width": 32.0, "alar": 20.0}])
def test_around_a_slit_in_a_plane_the_design_is_as_drawn_but_that_it_does_not_cut_the_slit(
    measures: dict[str, float],
) -> None:
    row = library_design("karapandzic")
    plain = row.draw((0.0, -6.0, 0.0), (1.0, 0.0, 0.0), **row.values(measures))
    found = laid(sheet_with_mouth(), **measures)
    assert plain.opening
    assert not found.opening
    assert cuts(found) == pytest.approx(cuts(plain), abs=0.25)  # the slit is 0.2 mm wide


def test_on_a_bent_sheet_the_cuts_keep_their_distance_from_the_mouth() -> None:
    tissue = sheet_with_mouth(60.0)
    design = laid(tissue)
    for curve in design.incisions:
        unrolled, points = np.array(curve)[2:], np.array(curve)[2:]
        unrolled[:, 0] = 60.0 * np.arctan2(points[:, 0], points[:, 2] + 60.0)
        aside = np.maximum(np.abs(unrolled[:, 0]) - 0.5 * MOUTH, 0.0)
        assert np.hypot(aside, unrolled[:, 1]) == pytest.approx(
            np.full(len(unrolled), 12.0), abs=0.4
        )  # the slit is 0.2 mm wide


def test_the_border_of_a_mouth_is_one_closed_line_whose_lips_run_from_corner_to_corner() -> None:
    tissue = sheet_with_mouth()
    border = SkinHoles(tissue).border_near((0.0, -6.0, 0.0), 20.0, 20.0)
    assert border is not None
    line, into = border
    steps = np.linalg.norm(np.diff(np.vstack([line, line[:1]]), axis=0), axis=1)
    middle = np.abs(line[:, 0]) < 20.0
    assert (into[middle, 1] * line[middle, 1] > 0.0).all()  # away from the slit
    assert steps.max() < 1.3
    drape = OpeningDrape(SkinSheet.of(tissue), border, ((-25.0, 0.0, 0.0), (25.0, 0.0, 0.0)), np.array([0.0, 0.0, 1.0]))
    assert drape.width == pytest.approx(MOUTH, abs=0.1)
    assert SkinHoles(tissue).border_near((0.0, -21.0, 0.0), 20.0, 20.0) is None
    assert SkinHoles(tissue).border_near((0.0, -6.0, 0.0), 20.0, 60.0) is None


def test_a_design_for_another_mouth_is_refused_with_the_length_of_the_one_there() -> None:
    with refuses(ProblemCode.DESIGN_RANGE, "karapandzic") as found:
        laid(sheet_with_mouth(), mouth=60.0)
    assert [each.value for each in found] == ["60"]


def test_a_design_too_large_for_the_skin_around_a_mouth_is_refused() -> None:
    with refuses(ProblemCode.DESIGN_OFF_SKIN, "karapandzic"):
        laid(sheet_with_mouth(half=15))
