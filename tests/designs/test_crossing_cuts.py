"""Cuts of a design that cross are refused before anything is solved; those that meet are not."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.designs.crossing_cuts import crossing_cuts
from lappet.designs.flap_design import Excised, FlapDesign
from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import flap_on_patch
from refusals import refuses

SQUARE = Excised("defect", ((-5.0, -5.0, 0.0), (5.0, -5.0, 0.0), (5.0, 5.0, 0.0), (-5.0, 5.0, 0.0)), (0.0, 0.0, 0.0))


def cuts(*incisions: tuple[tuple[float, float], ...], excised: tuple[Excised, ...] = ()) -> FlapDesign:
    return FlapDesign(excised, tuple(tuple((x, y, 0.0) for x, y in curve) for curve in incisions), ())


def test_two_limbs_that_cross_are_found_with_their_place() -> None:
    assert crossing_cuts(cuts(((0, 0), (10, 10)), ((0, 10), (10, 0)))) == pytest.approx((5.0, 5.0, 0.0))


def test_an_incision_that_crosses_itself_is_found() -> None:
    assert crossing_cuts(cuts(((0, 0), (10, 0), (10, 5), (4, -5)))) is not None


def test_an_incision_through_what_is_excised_is_found_and_one_from_it_is_not() -> None:
    assert crossing_cuts(cuts(((-20, 0), (20, 0)), excised=(SQUARE,))) is not None
    assert crossing_cuts(cuts(((4.7, 0), (20, 0)), excised=(SQUARE,))) is None


def test_cuts_that_meet_in_a_point_of_both_do_not_cross() -> None:
    assert crossing_cuts(cuts(((0, 0), (10, 0), (20, 0)), ((10, -5), (10, 0), (10, 5)))) is None


def test_a_lazy_s_with_too_much_swing_is_refused_before_solving() -> None:
    with refuses(ProblemCode.DESIGN_CROSSES):
        flap_on_patch("s-excision", {"length": 15.4, "width": 10.0, "swing": 22.5}, spacing=2.0)


# Those that bend: with a swing, a turn or a drop beyond their size their own cuts come in the way.
BENT = {"s-excision", "dual-s-plasty", "cervicofacial"}


@pytest.mark.parametrize("name", DESIGNS)
def test_no_other_design_crosses_anywhere_in_its_ranges(name: str) -> None:
    """At all ends of the ranges, up to 64 of them, where the design can be drawn at all."""
    design = DESIGNS[name]
    ends = list(product(*((each.least, each.most) for each in design.parameters)))
    drawn = 0
    for values in ends[:: max(1, len(ends) // 64)]:
        given = {each.name: value for each, value in zip(design.parameters, values, strict=True)}
        try:
            flat = design.draw(np.zeros(3), (1.0, 0.0, 0.0), **given)
        except RefusedError:
            continue
        drawn += 1
        if name not in BENT:
            assert crossing_cuts(flat) is None, given
    assert drawn
