"""The Karapandzic flap: its cuts keep their distance from the mouth, and both flaps meet in the middle of the lip."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.designs import FlapDesign
from lappet.designs.flat_curves import length
from lappet.designs.library import library_design
from lappet.designs.library_operation import flap_on_patch
from refusals import refuses


def drawn(**values: float) -> FlapDesign:
    row = library_design("karapandzic")
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), **row.values(values))


def edges(design: FlapDesign, name: str) -> tuple[NDArray[np.float64], ...]:
    (seam,) = (each for each in design.seams if each.name == name)
    return tuple(np.array(edge.points)[:, :2] for edge in seam.edges)


def to_mouth(points: NDArray[np.float64], mouth: float, level: float) -> NDArray[np.float64]:
    """Distances to the slit from (-mouth / 2, level) to (mouth / 2, level)."""
    aside = np.maximum(np.abs(points[:, 0]) - 0.5 * mouth, 0.0)
    return np.hypot(aside, points[:, 1] - level)


@pytest.mark.parametrize("height", [10.0, 14.0])
def test_the_incisions_parallel_the_mouth_at_the_depth_of_the_defect(height: float) -> None:
    """Karapandzic: the skin incision parallels the lip margin at a distance equal to the depth of the defect."""
    design = drawn(height=height)
    for side in ("right_side", "left_side"):
        cut, _ = edges(design, side)
        assert to_mouth(cut, 54.0, 0.5 * height) == pytest.approx(np.full(len(cut), height), abs=1e-9)


def test_the_flaps_meet_in_the_middle_and_the_outer_lip_is_longer_by_half_the_defect() -> None:
    design = drawn(width=20.0)
    for side in ("right_side", "left_side"):
        own, outer = edges(design, side)
        assert length(outer) == pytest.approx(length(own) + 10.0)
        assert outer[0] == pytest.approx((0.0, -7.0))
        assert own[-1] == pytest.approx(outer[-1])
    one, other = edges(design, "stem")
    assert one == pytest.approx(other * (-1.0, 1.0))


def test_the_flaps_stay_joined_to_the_upper_lip_between_the_ends_of_the_cuts() -> None:
    ends = [cut[-1] for side in ("right_side", "left_side") for cut in edges(drawn(alar=12.0), side)[:1]]
    assert ends[0] == pytest.approx((12.0, 7.0 + 14.0))
    assert ends[1] == pytest.approx((-12.0, 7.0 + 14.0))
    assert [epoch.fragments for epoch in build_epochs(flap_on_patch("karapandzic", spacing=2.0))] == [1, 2, 1, 1]


def test_a_defect_of_more_than_two_thirds_of_the_mouth_is_refused() -> None:
    assert drawn(width=40.0, mouth=60.0).excised
    with refuses(ProblemCode.DESIGN_RANGE, "karapandzic") as found:
        drawn(width=40.1, mouth=60.0)
    assert [each.value for each in found] == ["40.1"]


def test_cuts_that_end_beyond_the_commissures_are_refused() -> None:
    with refuses(ProblemCode.DESIGN_RANGE, "karapandzic") as found:
        drawn(width=10.0, mouth=24.0, alar=13.0)
    assert [each.value for each in found] == ["13"]
