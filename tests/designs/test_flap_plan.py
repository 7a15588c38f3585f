"""The plan of a design: what is cut to scale, a letter for each corner, ways that end where flaps are laid."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.designs.flap_plan import flap_plan
from lappet.designs.library import DESIGNS


def length(line: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def test_the_plan_of_a_limberg_has_sides_of_its_measure_and_turns_its_tip_by_sixty_degrees() -> None:
    plan = flap_plan(DESIGNS["limberg"], {"side": 20.0})
    (outline,) = plan.outlines
    assert length(np.vstack([outline, outline[:1]])) == pytest.approx(80.0, rel=0.01)
    first = {letter.text: letter.at for letter in plan.letters}
    tip, lay = next((first[a], first[b]) for a, b in plan.meetings if first[a][0] > first["A"][0] + 19.0)
    pivot = first["A"]
    angles = [np.degrees(np.arctan2(*(each - pivot)[::-1])) for each in (tip, lay)]
    assert abs(angles[1] - angles[0]) == pytest.approx(120.0, abs=1.0)


@pytest.mark.parametrize("name", DESIGNS)
def test_every_design_has_a_plan_with_one_letter_for_a_place(name: str) -> None:
    plan = flap_plan(DESIGNS[name])
    assert plan.outlines or plan.incisions
    places = np.array([letter.at for letter in plan.letters]).reshape(-1, 2)
    apart = np.linalg.norm(places[:, None] - places, axis=2) + np.eye(len(places)) * 9.0
    assert apart.min(initial=9.0) >= 0.5
    known = {letter.text for letter in plan.letters}
    assert known == {text for pair in plan.meetings for text in pair}


def test_a_mirrored_plan_is_the_other_one_upside_down() -> None:
    plan, other = (flap_plan(DESIGNS["bilobed"], mirrored=mirrored) for mirrored in (False, True))
    for line, mirrored in zip(plan.incisions, other.incisions, strict=True):
        np.testing.assert_allclose(mirrored, line * (1.0, -1.0), atol=1e-9)


def test_a_flap_that_turns_goes_on_an_arc_about_its_pivot() -> None:
    plan = flap_plan(DESIGNS["z-plasty"])
    for way in plan.ways:
        radii = [np.linalg.norm(way - letter.at, axis=1) for letter in plan.letters]
        assert min(np.ptp(each) for each in radii) < 0.01 * length(way)
