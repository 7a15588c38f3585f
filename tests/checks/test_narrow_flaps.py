"""A flap on a base that is narrow for its length is warned about; what lives on what lies below it is not."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from lappet.checks.narrow_flaps import MOST_RATIO, NarrowFlap, narrow_flaps, narrowest_flap
from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import add_flap, flap_on_patch
from lappet.procedure import Incision, Point, Procedure, Undermine, Vessel
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch

TOP = 4.0
TWO_STAGES = "paramedian-forehead"
AROUND = ((-70.0, -40.0, TOP), (70.0, -40.0, TOP), (70.0, 40.0, TOP), (-70.0, 40.0, TOP))


def on_top(*points: tuple[float, float]) -> tuple[Point, ...]:
    return tuple((x, y, TOP) for x, y in points)


def strip(length: float, width: float) -> Incision:
    """A cut around a strip of skin that is left at its right end."""
    half = 0.5 * width
    return Incision("strip", 2.0, on_top((length, half), (0.0, half), (0.0, -half), (length, -half)))


def found_in(*cuts: Incision, above: float = 0.5) -> NarrowFlap:
    flap = narrowest_flap(list(cuts), [], [AROUND], [], above)
    assert flap is not None
    return flap


@pytest.mark.parametrize("ratio", [3.0, 4.0, 6.0])
def test_the_ratio_of_a_strip_is_its_length_to_its_width(ratio: float) -> None:
    """From the middle of the base to a far corner: sqrt(ratio² + 1/4), and what a grid's detours add."""
    flap = found_in(strip(ratio * 12.0, 12.0))
    assert flap.ratio == pytest.approx(math.hypot(ratio, 0.5), rel=0.12)
    assert flap.width == pytest.approx(12.0, rel=0.2)
    assert flap.tip[0] == pytest.approx(0.0, abs=1.0)
    assert flap.base[0] == pytest.approx(ratio * 12.0, abs=2.5)


@pytest.mark.parametrize("angle", [20.0, 30.0, 60.0])
def test_the_ratio_of_a_tip_is_that_of_its_angle(angle: float) -> None:
    far = 40.0 * np.array([math.cos(math.radians(0.5 * angle)), math.sin(math.radians(0.5 * angle))])
    flap = found_in(Incision("tip", 2.0, on_top((far[0], far[1]), (0.0, 0.0), (far[0], -far[1]))))
    assert flap.ratio == pytest.approx(0.5 / math.sin(math.radians(0.5 * angle)), rel=0.12)


def test_a_turned_strip_has_the_same_ratio() -> None:
    straight = strip(36.0, 12.0)
    turn = math.radians(30.0)
    matrix = np.array([[math.cos(turn), -math.sin(turn), 0.0], [math.sin(turn), math.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    turned = replace(straight, points=tuple(map(tuple, np.array(straight.points) @ matrix.T)))
    assert found_in(turned).ratio == pytest.approx(found_in(straight).ratio, rel=0.08)


def patch(*events: object, **more: object) -> Procedure:
    return Procedure(flat_patch((160.0, 100.0, TOP), spacing=2.0), events=events, end_time=9.0, **more)  # type: ignore[arg-type]


def test_a_long_flap_is_warned_about_with_its_place_and_ratio() -> None:
    problems = check(patch(strip(48.0, 12.0), Undermine("freed", 3.0, AROUND)))
    (narrow,) = (each for each in problems if each.code == ProblemCode.FLAP_NARROW_BASE)
    assert narrow.severity == "warning"
    assert narrow.prim == "/Procedure/Timeline/strip"
    assert float(str(narrow.value)) == pytest.approx(4.0, rel=0.12)
    assert narrow.place is not None
    assert narrow.place.points[0][0] == pytest.approx(0.0, abs=1.0)
    assert "3:1" in narrow.message
    assert "Baker" in narrow.remedy


def test_a_short_flap_is_not() -> None:
    assert narrow_flaps(patch(strip(30.0, 12.0), Undermine("freed", 3.0, AROUND)), set()) == []


def test_skin_that_stays_on_its_bed_is_not() -> None:
    assert narrow_flaps(patch(strip(60.0, 12.0)), set()) == []
    elsewhere = Undermine("freed", 3.0, on_top((30, 20), (60, 20), (60, 40), (30, 40)))
    assert narrow_flaps(patch(strip(60.0, 12.0), elsewhere), set()) == []


def test_an_island_is_not() -> None:
    ring = Incision("ring", 2.0, on_top((-30, -5), (30, -5), (30, 5), (-30, 5)), closed=True)
    assert narrow_flaps(patch(ring, Undermine("freed", 3.0, AROUND)), set()) == []


def test_a_flap_with_a_vessel_of_its_own_is_not() -> None:
    artery = Vessel("artery", ((70.0, 0.0, 2.0), (40.0, 0.0, 2.0), (10.0, 0.0, 2.0)))
    assert narrow_flaps(patch(strip(60.0, 12.0), Undermine("freed", 3.0, AROUND), vessels=(artery,)), set()) == []


def test_a_vessel_that_the_cut_divides_keeps_no_flap_alive() -> None:
    across = Vessel("artery", ((20.0, -40.0, 2.0), (20.0, 40.0, 2.0)))
    (narrow,) = narrow_flaps(patch(strip(60.0, 12.0), Undermine("freed", 3.0, AROUND), vessels=(across,)), set())
    assert narrow.code == ProblemCode.FLAP_NARROW_BASE


def test_a_flap_is_looked_at_before_its_pedicle_is_divided() -> None:
    """The division makes an island of it; until then it hangs on its base."""
    division = Incision("division", 6.0, on_top((40.0, 6.0), (40.0, -6.0)))
    (narrow,) = narrow_flaps(patch(strip(48.0, 12.0), Undermine("freed", 3.0, AROUND), division), set())
    assert narrow.prim == "/Procedure/Timeline/strip"
    assert float(str(narrow.value)) == pytest.approx(4.0, rel=0.12)


def test_a_strip_that_is_undermined_after_it_was_made_an_island_is_not() -> None:
    closing = Incision("closing", 3.0, on_top((48.0, 6.0), (48.0, -6.0)))
    assert narrow_flaps(patch(strip(48.0, 12.0), closing, Undermine("freed", 4.0, AROUND)), set()) == []


def test_a_forehead_flap_is_warned_about_unless_its_artery_is_there() -> None:
    """Five widths of its pedicle long: only with the supratrochlear vessels does it live."""
    procedure = flap_on_patch(TWO_STAGES, spacing=2.0)
    (narrow,) = narrow_flaps(procedure, set())
    assert float(str(narrow.value)) == pytest.approx(5.0, rel=0.12)  # (36 + 6 + 8) / 10 mm
    cut = next(event for event in procedure.events if isinstance(event, Incision) and event.name == "limbs")
    (start, end), far = np.array([cut.points[0], cut.points[-1]]), np.mean(cut.points, axis=0)
    root, tip = 0.5 * (start + end) - (0.0, 0.0, 2.0), far - (0.0, 0.0, 2.0)
    artery = Vessel("supratrochlear", tuple(map(tuple, np.linspace(root, 1.6 * tip - 0.6 * root, 12))))
    assert narrow_flaps(replace(procedure, vessels=(artery,)), set()) == []


@pytest.mark.parametrize("name", [name for name in DESIGNS if name != TWO_STAGES])
def test_no_other_design_has_a_narrow_base_at_its_defaults(name: str) -> None:
    assert narrow_flaps(flap_on_patch(name, spacing=2.0), set()) == []


def test_a_u_flap_of_four_widths_is_warned_about_also_on_a_dome() -> None:
    flat = flap_on_patch("u-plasty", {"length": 4.0}, spacing=2.0)
    dome = Procedure(dome_scalp(90.0, 75.0, 6.0, resolution=2.0), start_time=1, end_time=1)
    curved = add_flap(dome, "u-plasty", (0.0, 0.0, 90.0), (1.0, 0.0, 0.0), {"length": 4.0, "width": 11.0})
    for procedure in (flat, curved):
        (narrow,) = narrow_flaps(procedure, set())
        assert narrow.code == ProblemCode.FLAP_NARROW_BASE
        assert float(str(narrow.value)) > MOST_RATIO + 0.7


def test_flaps_far_from_each_other_are_each_looked_at() -> None:
    """On one grid of both, a small flap would be a few cells."""
    small = Incision("small", 2.0, on_top((74, 3), (60, 3), (60, -3), (74, -3)))
    large = Incision("large", 2.0, on_top((-40, 8), (-75, 8), (-75, -8), (-40, -8)))
    assert narrow_flaps(patch(small, large, Undermine("freed", 3.0, AROUND)), set()) == []
    long = Incision("long", 2.0, on_top((74, 3), (48, 3), (48, -3), (74, -3)))
    (narrow,) = narrow_flaps(patch(long, large, Undermine("freed", 3.0, AROUND)), set())
    assert narrow.prim.endswith("/long")
