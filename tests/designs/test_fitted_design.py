"""A design as large as a defect asks for: the defect lies inside what it excises, and no smaller one would do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.designs.fitted_design import fit_to_defect, marked_defect, without_drawn
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.library import DESIGNS
from lappet.procedure import Excision, Incision, Landmark, Material, Procedure
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_sheet import SkinSheet
from refusals import refuses

TOP = 4.0
PATCH = flat_patch((140.0, 140.0, TOP), resolution=7.0)
TURN = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
X = (1.0, 0.0, 0.0)
CLOSES = ("fusiform", "limberg", "dufourmentel", "bilobed", "rotation", "o-z", "u-plasty", "a-t", "keystone")


def circle(radius: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    return np.column_stack([x + radius * np.cos(TURN), y + radius * np.sin(TURN), np.full(len(TURN), TOP)])


def beyond(outline: np.ndarray, points: np.ndarray) -> float:
    """How far points lie outside a convex outline that runs counter-clockwise, at most; both (n, 2)."""
    way = np.roll(outline, -1, axis=0) - outline
    normals = np.stack([way[:, 1], -way[:, 0]], axis=1) / np.linalg.norm(way, axis=1)[:, None]
    return float(((points[:, None] - outline) * normals).sum(axis=2).max())


def test_a_rhombus_of_sixty_degrees_around_a_circle_has_the_side_that_geometry_says() -> None:
    fitted = fit_to_defect(PATCH, "limberg", circle(6.0, 5.0, 3.0), X)
    assert fitted.values["side"] == pytest.approx(2.0 * 6.0 / np.sin(np.radians(60.0)), rel=2e-3)
    np.testing.assert_allclose(fitted.at, (5.0, 3.0, TOP), atol=0.02)


def test_a_round_design_is_as_wide_as_a_round_defect() -> None:
    assert fit_to_defect(PATCH, "o-z", circle(7.5), X).values["diameter"] == pytest.approx(15.0, rel=2e-3)


@pytest.mark.parametrize(("name", "mirrored"), [*((name, False) for name in CLOSES), ("bilobed", True), ("a-t", True)])
def test_the_defect_lies_inside_what_is_excised_and_a_smaller_design_does_not_hold_it(
    name: str, mirrored: bool
) -> None:
    defect = circle(6.0)
    defect[:, 0] *= 1.3  # an oval
    direction = (0.8, 0.6, 0.0)
    fitted = fit_to_defect(PATCH, name, defect, direction, mirrored=mirrored)

    def outside(share: float) -> float:
        lengths = [each.name for each in DESIGNS[name].parameters if each.unit == "mm"]
        values = {key: value * (share if key in lengths else 1.0) for key, value in fitted.values.items()}
        design = flap_on_skin(PATCH, name, fitted.at, direction, values, mirrored=mirrored)
        outline = np.array(design.excised[0].outline)[:, :2]
        return beyond(outline, defect[:, :2])

    assert outside(1.0) < 0.06
    if all(0.97 * fitted.values[each.name] > each.least for each in DESIGNS[name].parameters if each.unit == "mm"):
        assert outside(0.97) > 0.02


def test_the_size_follows_the_skin_of_a_dome() -> None:
    dome = dome_scalp(90.0, 70.0, 6.0)
    angle = 8.0 / 90.0  # 8 mm along the skin
    pole = np.array([0.0, 0.0, 90.0])
    around = 90.0 * np.column_stack(
        [np.sin(angle) * np.cos(TURN), np.sin(angle) * np.sin(TURN), np.full(len(TURN), np.cos(angle))]
    )
    fitted = fit_to_defect(dome, "limberg", SkinSheet.of(dome).place(around), X)
    assert fitted.values["side"] == pytest.approx(2.0 * 8.0 / np.sin(np.radians(60.0)), rel=0.01)
    assert np.linalg.norm(np.array(fitted.at) - pole) < 0.3


@pytest.mark.parametrize(
    ("name", "defect", "code"),
    [
        ("z-plasty", circle(6.0), ProblemCode.DESIGN_DEFECT_NONE),
        ("w-plasty", circle(6.0), ProblemCode.DESIGN_DEFECT_SHAPE),
        ("limberg", circle(40.0), ProblemCode.DESIGN_DEFECT_SIZE),
        ("limberg", circle(6.0)[:2], ProblemCode.DESIGN_DEFECT_POINTS),
    ],
)
def test_what_cannot_be_fitted_is_refused(name: str, defect: np.ndarray, code: ProblemCode) -> None:
    with refuses(code, name):
        fit_to_defect(PATCH, name, defect, X)


def test_a_defect_larger_than_the_design_can_close_names_the_length_and_its_limit() -> None:
    with refuses(ProblemCode.DESIGN_DEFECT_SIZE, "limberg") as problems:
        fit_to_defect(PATCH, "limberg", circle(40.0), X)
    assert float(problems[0].value) == pytest.approx(92.4, abs=0.3)


def drawn() -> Procedure:
    ring = tuple(tuple(point) for point in circle(6.0).tolist())
    events = (
        Incision("lesion", 2.0, ring, closed=True),
        Excision("gone", 3.0, ((0.0, 0.0, TOP),)),
        Excision("elsewhere", 3.0, ((40.0, 0.0, TOP),)),
        Landmark("mole", ring[:6], "the mole"),
        Incision("line", 2.0, ring[:3]),
    )
    return Procedure(PATCH, (Material("skin"),), events=events, start_time=1, end_time=3)


def test_a_defect_is_a_closed_incision_or_an_outline_of_landmarks() -> None:
    assert marked_defect(drawn(), "lesion").shape == (48, 3)
    assert marked_defect(drawn(), "the mole").shape == (6, 3)
    for name in ("line", "gone", "nothing"):
        with refuses(ProblemCode.DESIGN_DEFECT_UNKNOWN):
            marked_defect(drawn(), name)


def test_the_incision_that_drew_a_defect_goes_with_what_it_excised() -> None:
    assert [event.name for event in without_drawn(drawn(), "lesion").events] == ["elsewhere", "mole", "line"]
    assert without_drawn(drawn(), "mole") == drawn()


def test_a_design_fits_around_the_faces_of_a_subset() -> None:
    tissue = flat_patch((140.0, 140.0, TOP), resolution=7.0)
    starts = np.concatenate([[0], np.cumsum(tissue.face_vertex_counts)[:-1]])
    corners = tissue.points[tissue.face_vertex_indices[starts[:, None] + np.arange(3)]].mean(axis=1)
    on_top = np.flatnonzero(corners[:, 2] > TOP - 1e-6)
    inside = on_top[np.abs(corners[on_top, :2]).max(axis=1) < 14.0]
    far = on_top[np.linalg.norm(corners[on_top, :2] - 50.0, axis=1) < 8.0]
    marked = replace(
        tissue, subsets={**tissue.subsets, "lesion": inside, "two": np.r_[inside, far], "below": tissue.subsets["bed"]}
    )
    procedure = Procedure(marked)
    outline = marked_defect(procedure, "region:lesion")
    low, high = outline[:, :2].min(axis=0), outline[:, :2].max(axis=0)
    assert set(np.round(outline[:, 2], 6)) == {TOP}
    fitted = fit_to_defect(marked, "u-plasty", outline, X)
    assert fitted.values["width"] == pytest.approx(max(high - low), rel=1e-3)
    with refuses(ProblemCode.DESIGN_REGION_UNKNOWN):
        marked_defect(procedure, "region:mole")
    with refuses(ProblemCode.DESIGN_DEFECT_PIECES):
        marked_defect(procedure, "region:two")
    with refuses(ProblemCode.DESIGN_DEFECT_UNMARKED):
        marked_defect(procedure, "region:below")
