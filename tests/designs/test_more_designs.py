"""The geometry that defines each of the later designs: what moves into a place fits it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.designs import FlapDesign
from lappet.designs.flat_curves import length
from lappet.designs.library import library_design
from lappet.designs.library_operation import flap_on_patch
from lappet.procedure import Excision, Incision, SutureRun


def drawn(name: str, **values: float) -> FlapDesign:
    row = library_design(name)
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), **row.values(values))


def edges(design: FlapDesign) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Points (k, 2) of both edges of every seam."""
    return {seam.name: tuple(np.array(edge.points)[:, :2] for edge in seam.edges) for seam in design.seams}  # type: ignore[misc]


def pairs(design: FlapDesign) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """The flap's and the wound's corner (2,) of every pair."""
    return {each.name: tuple(np.array(spot.point)[:2] for spot in (each.flap, each.wound)) for each in design.corners}  # type: ignore[misc]


def angle(a: NDArray[np.float64], corner: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    u, v = a - corner, b - corner
    return float(np.degrees(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v))))


def turned(point: NDArray[np.float64], about: NDArray[np.float64], degrees: float) -> NDArray[np.float64]:
    turn = np.radians(degrees)
    return about + np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ (point - about)


@pytest.mark.parametrize("count", [2, 5])
def test_z_in_series_are_single_z_side_by_side_and_share_their_ends(count: int) -> None:
    design, single = drawn("multiple-z-plasty", count=count, angle=60.0, limb=10.0), drawn("z-plasty", limb=10.0)
    assert len(design.flaps) == 2 * count
    one, at = edges(single), edges(design)
    for k in range(count):
        shift = np.array([(k - 0.5 * (count - 1)) * 10.0, 0.0])
        for name in ("first", "second", "central"):
            for mine, other in zip(at[f"{name}_{k + 1}"], one[name], strict=True):
                assert mine == pytest.approx(other + shift, abs=1e-9)
    assert sum(corner.name.startswith("joint") for corner in design.corners) == count - 1


@pytest.mark.parametrize("outer", [90.0, 120.0])
def test_the_four_flaps_have_half_the_angle_and_all_limbs_one_length(outer: float) -> None:
    design = drawn("four-flap-z-plasty", angle=outer, limb=20.0)
    at = edges(design)
    assert all(length(edge) == pytest.approx(20.0) for seam in at.values() for edge in seam)
    b = np.array([10.0, 0.0])
    limbs = [at["left"][0][0], at["b_d"][0][-1], at["right"][1][-1]]  # c, f and a, seen from b
    assert [angle(p, b, q) for p, q in pairwise(limbs)] == pytest.approx([0.5 * outer] * 2)


def test_the_five_flaps_fill_the_half_below_the_scar_and_the_fifth_goes_to_the_stems_end() -> None:
    design = drawn("five-flap-z-plasty", angle=60.0, stem=0.4, limb=16.0)
    at, corner = edges(design), pairs(design)
    o = np.zeros(2)
    v = [at[f"{side}_flaps"][0][-1] for side in ("right", "left")]
    assert angle(v[0], o, v[1]) == pytest.approx(60.0)
    assert corner["tip"] == (pytest.approx(o), pytest.approx([0.0, 0.4 * 16.0]))
    for side in ("right", "left"):
        low, high = corner[f"{side}_low"], corner[f"{side}_high"]
        assert np.linalg.norm(low[1] - high[0]) == pytest.approx(16.0)  # PU
        assert np.linalg.norm(high[1] - low[0]) == pytest.approx(16.0)  # OV


def test_websters_tips_are_of_30_degrees_and_his_flap_turns_by_the_ws() -> None:
    design = drawn("webster", side=16.0)
    at, corner = edges(design), pairs(design)
    d, e, f = at["far"][0][0], at["far"][0][-1], at["end"][0][-1]
    near, m = at["base"][1][0], at["base"][1][-1]
    assert angle(d, e, f) == pytest.approx(30.0)
    assert angle(d, near, m) == pytest.approx(30.0)
    assert [np.linalg.norm(p - q) for p, q in ((d, e), (e, f), (near, d))] == pytest.approx([16.0] * 3)
    assert m[0] == pytest.approx(0.0, abs=1e-9)
    assert turned(d, near, 30.0) == pytest.approx(m, abs=1.0)  # the W's inner side is 5 % shorter
    assert corner["shoulder"][1] == pytest.approx(m)
    a = corner["tip"][1]
    assert angle(corner["edge"][0], a, d) == pytest.approx(60.0)


def test_three_limberg_flaps_turned_by_60_degrees_fill_the_hexagon_around_the_circle() -> None:
    design = drawn("triple-rhombic", diameter=20.0)
    rim = np.array(design.excised[0].outline)[:, :2]
    assert np.linalg.norm(rim, axis=1).min() == pytest.approx(10.0, abs=0.05)
    at, corner = edges(design), pairs(design)
    for k in range(1, 4):
        pivot = np.array(next(each for each in design.carries if each.name == f"tip_{k}").pivot)[:2]
        shoulder, (tip, there) = corner[f"shoulder_{k}"][0], corner[f"tip_{k}"]
        turn = 60.0 if np.allclose(turned(shoulder, pivot, 60.0), 0.0, atol=1e-6) else -60.0
        assert turned(shoulder, pivot, turn) == pytest.approx(np.zeros(2), abs=1e-6)
        assert turned(tip, pivot, turn) == pytest.approx(there, abs=1e-6)
    assert all(length(edge) == pytest.approx(20.0 / np.sqrt(3.0)) for seam in at.values() for edge in seam)


def test_two_limberg_flaps_turned_by_60_degrees_fill_the_parallelogram() -> None:
    design = drawn("double-rhombic", side=13.0)
    corner = pairs(design)
    for k in (1, 2):
        pivot = np.array(next(each for each in design.carries if each.name == f"tip_{k}").pivot)[:2]
        for name in ("tip", "shoulder"):
            start, there = corner[f"{name}_{k}"]
            reached = [turned(start, pivot, turn) for turn in (60.0, -60.0)]
            assert min(np.linalg.norm(each - there) for each in reached) < 1e-6


def test_the_notes_stem_touches_the_circle_and_has_the_published_mean_measures() -> None:
    """J. W. Walike and W. F. Larrabee 1985: 1.4 and 1.1 diameters, 50.3°, three quarters of the circle's area."""
    at = edges(drawn("note", diameter=14.0))
    foot, tip = at["stem"][0][0], at["stem"][0][-1]
    end = at["flag"][0][-1]
    assert foot == pytest.approx([7.0, 0.0])
    assert tip[0] == pytest.approx(7.0)  # square to the radius
    assert np.linalg.norm(tip - foot) == pytest.approx(1.4 * 14.0)
    assert np.linalg.norm(end - tip) == pytest.approx(1.1 * 14.0)
    assert angle(foot, tip, end) == pytest.approx(50.0)
    area = 0.5 * 1.4 * 1.1 * np.sin(np.radians(50.0)) * 14.0**2
    assert area / (np.pi * 7.0**2) == pytest.approx(0.75, abs=0.01)
    wound = [length(at[name][1]) for name in ("stem", "flag")]
    assert wound == pytest.approx([length(at[name][0]) for name in ("stem", "flag")], rel=0.06)


def test_the_lobes_of_a_trilobed_flap_follow_each_other_by_their_angles() -> None:
    design = drawn("trilobed")
    assert len(design.flaps) == 3
    corner = pairs(design)
    feet = [corner["first"][1], corner["first"][0], corner["second"][0], corner["donor"][1]]
    pivot = np.array(design.carries[0].pivot)[:2]
    turns = [angle(a, pivot, b) for a, b in pairwise(feet)]
    assert turns == pytest.approx([48.0, 45.0, 45.0])
    assert corner["second"][1] == pytest.approx(corner["first"][0])


def test_the_lines_of_an_o_t_touch_the_circle() -> None:
    design = drawn("o-t", diameter=14.0, apex=2.4)
    one, other = edges(design)["stem"]
    assert one == pytest.approx(other * (-1.0, 1.0), abs=1e-9)
    tip = one[-1]
    assert tip == pytest.approx([0.0, 2.4 * 7.0])
    away = np.linalg.norm(one, axis=1)
    touch = one[away < 7.01][-1]
    assert touch @ (tip - touch) == pytest.approx(0.0, abs=0.6)


def test_the_flap_beside_the_ala_is_sewn_to_a_rim_of_nearly_its_length() -> None:
    at = edges(drawn("crescentic"))
    edge, rim = (length(each) for each in at["ala"])
    assert rim == pytest.approx(10.0 + 11.0 * np.radians(130.0), rel=0.01)
    assert 0.75 < edge / rim < 1.0


def test_the_stem_behind_a_back_cut_is_a_third_of_it_on_both_lips() -> None:
    one, other = edges(drawn("rotation-back-cut", width=12.0, back_cut=1.2))["donor_stem"]
    assert [length(one), length(other)] == pytest.approx([4.8, 4.8], rel=0.02)
    assert one[0] == pytest.approx(other[0])


def test_the_two_islands_of_a_type_iii_are_each_others_images() -> None:
    design = drawn("keystone-iii")
    upper, lower = (np.array(curve)[:, :2] for curve in design.incisions)
    assert lower == pytest.approx(upper * (1.0, -1.0), abs=1e-9)
    assert design.undermined == 0.0


def test_behind_a_type_ii_the_wound_stays_open_for_a_graft() -> None:
    one, two = edges(drawn("keystone", length=54.0, width=18.0, advance=0.6)), edges(drawn("keystone-ii"))
    assert set(one) - set(two) == {"stem_left", "stem_right", "back"}
    assert set(two) == {"defect", "left", "right"}
    for name in two:
        assert [length(each) for each in two[name]] == pytest.approx([length(each) for each in one[name]], rel=1e-9)
    assert drawn("keystone-ii").undermined == 0.0


def test_the_dog_ears_of_a_round_excision_are_cut_out_after_its_middle_is_closed() -> None:
    procedure = flap_on_patch("round-excision", spacing=2.0)
    runs = {event.name: event for event in procedure.events if isinstance(event, SutureRun)}
    first, late = sorted(
        (event for event in procedure.events if isinstance(event, Excision)), key=lambda event: event.time
    )
    middle = runs["suture_donor_middle"]
    assert first.time < middle.start
    assert middle.start + middle.duration < late.time < runs["suture_cone_right"].start
    cut = next(event for event in procedure.events if isinstance(event, Incision) and event.name == "cone_right")
    assert cut.time < late.time
    tips = [max(np.array(curve.outline)[:, 0], key=abs) for curve in drawn("round-excision").excised[1:]]
    assert abs(tips[0] - tips[1]) == pytest.approx(2.6 * 14.0)
