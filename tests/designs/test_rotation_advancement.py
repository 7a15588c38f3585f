"""Millard's rotation–advancement: its margins, its flaps, and the blade that cuts a lip from its front."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.designs import FlapDesign
from lappet.designs.flat_curves import length
from lappet.designs.library import library_design
from lappet.designs.library_operation import add_flap, flap_on_patch
from lappet.procedure import Incision, Procedure
from lappet.tissue.dome import dome_scalp
from refusals import refuses

MEASURES = {"medial": 9.0, "lateral": 11.0, "gap": 8.0, "rotation": 5.0, "ala": 10.0, "drop": 2.0, "red": 6.0}


def drawn(mirrored: bool = False, **values: float) -> FlapDesign:
    row = library_design("millard")
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), mirrored=mirrored, **row.values({**MEASURES, **values}))


def edge(design: FlapDesign, seam: str, which: int) -> NDArray[np.float64]:
    (found,) = (each for each in design.seams if each.name == seam)
    return np.array(found.edges[which].points)


def test_the_margins_are_as_long_as_said_and_end_at_the_gap() -> None:
    design = drawn()
    lateral, lip = edge(design, "lip", 0), edge(design, "lip", 1)
    assert length(lateral) == pytest.approx(11.0)
    assert length(lip) == pytest.approx(5.0 + 9.0)  # below the columella and down the medial margin
    assert np.linalg.norm(lateral[-1] - lip[-1]) == pytest.approx(8.0)


def test_the_red_is_pared_down_to_one_point_in_the_middle_below_the_margins() -> None:
    design = drawn()
    first, second = edge(design, "red", 0), edge(design, "red", 1)
    np.testing.assert_allclose(first[-1], second[-1], atol=1e-9)
    middle = 0.5 * (first[0] + second[0])
    assert np.linalg.norm(first[-1] - middle) == pytest.approx(6.0)


@pytest.mark.parametrize("narrowing", [-0.1, 0.0, 0.5])
def test_on_a_notched_lip_the_cuts_through_the_red_stay_apart(narrowing: float) -> None:
    notched = drawn(narrowing=narrowing)
    ends = [edge(notched, "red", k)[-1] for k in (0, 1)]
    begins = [edge(notched, "red", k)[0] for k in (0, 1)]
    assert np.linalg.norm(np.mean(ends, axis=0) - np.mean(begins, axis=0)) == pytest.approx(6.0)
    assert all(tuple(end) in notched.excised[0].outline for end in ends)
    assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(8.0 * (1.0 - narrowing))
    for design in (notched, drawn()):
        assert len(set(design.excised[0].outline)) == len(design.excised[0].outline)


@pytest.mark.parametrize("mirrored", [False, True])
def test_the_blade_turns_towards_the_lateral_margin_and_away_from_the_other_lip(mirrored: bool) -> None:
    lateral = edge(drawn(mirrored), "lip", 0)[-1]
    turned = np.array(drawn(mirrored, blade_turn=20.0).blade)
    assert turned[1] * lateral[1] > 0.0
    assert turned[2] == pytest.approx(-np.cos(np.radians(20.0)))
    lifted = np.array(drawn(mirrored, blade_lift=30.0).blade)
    assert lifted[0] < 0.0  # x runs down the cleft
    assert lifted[2] == pytest.approx(-np.cos(np.radians(30.0)))


def test_the_tip_of_the_lateral_flap_meets_the_end_of_the_rotation_incision() -> None:
    design = drawn()
    tip, bow = design.corners
    np.testing.assert_allclose(tip.flap.point, (0.0, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(tip.wound.point, design.incisions[0][-1])
    np.testing.assert_allclose(bow.flap.point, edge(design, "lip", 0)[-1])
    np.testing.assert_allclose(bow.wound.point, edge(design, "lip", 1)[-1])


def test_the_hook_turns_the_peak_down_by_the_drop_about_the_end_of_the_incision() -> None:
    rotation = drawn().carries[0]
    corner, lay, pivot = (np.array(each) for each in (rotation.corner.point, rotation.lay.point, rotation.pivot))
    assert np.linalg.norm(corner - pivot) == pytest.approx(np.linalg.norm(lay - pivot))
    assert np.linalg.norm(corner - lay) == pytest.approx(2.0, rel=0.01)
    assert lay[0] > corner[0]  # x runs down the cleft


@pytest.mark.parametrize("mirrored", [False, True])
def test_every_edge_has_its_tissue_on_its_side(mirrored: bool) -> None:
    """The lip's edges bound flaps, the sill's upper edge what lies above."""
    design = drawn(mirrored)
    a, b = (np.array(point) for point in design.flaps)
    for seam, tissues in (("lip", (b, a)), ("sill", (b, np.array((-3.0, 0.0, 0.0))))):
        (found,) = (each for each in design.seams if each.name == seam)
        for one, tissue in zip(found.edges, tissues, strict=True):
            points = np.array(one.points)
            k = len(points) - 3
            run, beside = points[k + 1] - points[k], tissue - points[k]
            assert one.side * (run[0] * beside[1] - run[1] * beside[0]) > 0.0, seam


def test_the_mirrored_design_is_the_mirror_image() -> None:
    plain, mirrored = drawn(), drawn(mirrored=True)
    for seam, other in zip(plain.seams, mirrored.seams, strict=True):
        for one, two in zip(seam.edges, other.edges, strict=True):
            np.testing.assert_allclose(np.array(one.points) * (1.0, -1.0, 1.0), two.points, atol=1e-9)
            assert one.side == -two.side
    assert mirrored.blade == pytest.approx(plain.blade)


def test_the_blade_is_square_to_the_plane_of_the_margins_on_a_dome() -> None:
    tissue = dome_scalp(60.0, 40.0, 4.0)
    laid = add_flap(Procedure(tissue), "millard", (0.0, 0.0, 60.0), (1.0, 0.0, 0.0), MEASURES)
    cuts = [event for event in laid.events if isinstance(event, Incision)]
    assert len(cuts) == 3
    assert len({cut.direction for cut in cuts}) == 1
    blade = np.array(cuts[0].direction)
    assert np.linalg.norm(blade) == pytest.approx(1.0)
    assert blade[2] < -0.99


def test_the_pared_red_comes_out_and_both_flaps_stay() -> None:
    epochs = build_epochs(flap_on_patch("millard", spacing=2.0))
    assert [epoch.fragments for epoch in epochs] == [1, 2, 1, 1]


def test_margins_that_no_gap_joins_are_refused() -> None:
    with refuses(ProblemCode.DESIGN_RANGE, "millard"):
        drawn(gap=19.0)
    with refuses(ProblemCode.DESIGN_RANGE, "millard"):
        drawn(lateral=17.0)
