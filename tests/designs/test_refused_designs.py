"""What of a design is refused before anything is solved, with one sentence: the list of "Bad input" of the library."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet import check
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.library_operation import add_flap, flap_on_patch
from lappet.procedure import Procedure, Tissue
from lappet.tissue.patch import flat_patch
from refusals import refuses

X = (1.0, 0.0, 0.0)
TOP = 4.0


def without_skin(tissue: Tissue, reach: tuple[float, float], middle: tuple[float, float] = (0.0, 0.0)) -> Tissue:
    """A tissue in which the faces of a rectangle of its top are no skin any more, but a wall of the hole: fixed."""
    starts = np.concatenate([[0], np.cumsum(tissue.face_vertex_counts)[:-1]])
    corners = tissue.points[tissue.face_vertex_indices[starts[:, None] + np.arange(4)]].mean(axis=1)
    gone = (np.abs(corners[:, :2] - middle) < reach).all(axis=1) & (corners[:, 2] > TOP - 1e-6)
    fixed = np.unique(np.r_[tissue.subsets["fixed"], np.flatnonzero(gone)])
    return replace(tissue, subsets={**tissue.subsets, "fixed": fixed})


PATCH = flat_patch((120.0, 100.0, TOP), resolution=2.0, spacing=4.0)


@pytest.mark.parametrize("at", [(0.0, 0.0, 40.0), (90.0, 0.0, TOP), (np.nan, 0.0, TOP)])
def test_a_place_off_the_skin_is_refused_with_the_nearest_one_on_it(at: tuple[float, float, float]) -> None:
    with refuses(ProblemCode.DESIGN_PLACE_OFF):
        flap_on_skin(PATCH, "limberg", at, X)


def test_a_place_some_millimetres_off_the_skin_is_that_on_it() -> None:
    assert flap_on_skin(PATCH, "limberg", (0.0, 0.0, TOP + 3.0), X) == flap_on_skin(PATCH, "limberg", (0, 0, TOP), X)


def test_a_design_across_a_hole_of_the_skin_is_refused_with_the_hole_and_one_beside_it_is_not() -> None:
    nostril = without_skin(PATCH, (5.0, 4.0), (18.0, 0.0))
    with refuses(ProblemCode.DESIGN_ACROSS_HOLE) as problems:
        flap_on_skin(nostril, "limberg", (0.0, 0.0, TOP), X)
    assert "(18.0, 0.0, 4.0)" in problems[0].message
    with refuses(ProblemCode.DESIGN_OFF_SKIN):
        flap_on_skin(nostril, "limberg", (50.0, 30.0, TOP), X)
    assert flap_on_skin(nostril, "limberg", (-10.0, 0.0, TOP), (-1.0, 0.0, 0.0)).excised


def test_a_slit_that_a_line_would_step_over_is_found_by_the_way_around_it() -> None:
    """Lips that touch: their skin is as near as a line needs it, but the way along it goes around their corners."""
    starts = np.concatenate([[0], np.cumsum(PATCH.face_vertex_counts)[:-1]])
    faces = PATCH.face_vertex_indices[starts[:, None] + np.arange(4)]
    above = PATCH.points[faces].mean(axis=1)[:, 1] > 8.0
    lip = np.flatnonzero((np.abs(PATCH.points[:, 1] - 8.0) < 1e-6) & (np.abs(PATCH.points[:, 0]) < 25.0))
    lip = lip[PATCH.points[lip, 2] > TOP - 1e-6]
    doubled = np.full(len(PATCH.points), -1)
    doubled[lip] = len(PATCH.points) + np.arange(len(lip))
    moved = np.where(above[:, None] & (doubled[faces] >= 0), doubled[faces], faces)
    mouth = replace(PATCH, points=np.vstack([PATCH.points, PATCH.points[lip]]), face_vertex_indices=moved.reshape(-1))
    with refuses(ProblemCode.DESIGN_ACROSS_HOLE):
        flap_on_skin(mouth, "limberg", (0.0, 0.0, TOP), X)
    assert flap_on_skin(mouth, "limberg", (-10.0, -15.0, TOP), X, {"side": 12.0}).excised


def test_limbs_that_cross_are_refused_in_one_sentence() -> None:
    with pytest.raises(RefusedError) as found:
        flap_on_patch("s-excision", {"length": 15.4, "width": 10.0, "swing": 22.5}, spacing=4.0)
    (problem,) = found.value.problems
    assert problem.code == ProblemCode.DESIGN_CROSSES
    assert "mm" in problem.value


def test_a_narrow_base_is_warned_about_with_its_ratio_and_the_source() -> None:
    patch = Procedure(flat_patch((160.0, 80.0, TOP), resolution=8.0, spacing=4.0), start_time=1, end_time=1)
    made = add_flap(patch, "u-plasty", (-30.0, 0.0, TOP), X, {"width": 12.0, "length": 4.0})
    (found,) = (each for each in check(made) if each.code == ProblemCode.FLAP_NARROW_BASE)
    assert found.severity == "warning"
    assert "Baker" in f"{found.message} {found.remedy}"
