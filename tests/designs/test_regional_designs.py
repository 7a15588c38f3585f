"""Designs of a region of the body against the geometry that defines them: eyelid, ala, nose, and the keystone."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.designs import FlapDesign, flap_on_patch
from lappet.designs.flat_curves import length
from lappet.designs.library import library_design
from lappet.designs.nasolabial_flap import nasolabial_flap
from lappet.procedure import Undermine
from refusals import refuses


def drawn(name: str, **values: float) -> FlapDesign:
    row = library_design(name)
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), **row.values(values))


def edges(design: FlapDesign) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Points (k, 2) of the flap's and the wound's edge of each seam."""
    return {
        seam.name: (np.array(seam.edges[0].points)[:, :2], np.array(seam.edges[1].points)[:, :2])
        for seam in design.seams
    }


def test_a_keystone_is_as_broad_as_its_defect_and_its_ends_are_square_to_its_arcs() -> None:
    design = drawn("keystone", length=42.0, width=14.0)
    cut = np.array(design.incisions[0])[1:-1, :2]  # without the nicks
    inner, outer = edges(design)["defect"][1] * (1.0, -1.0), edges(design)["back"][0]
    middle = 0.5 * 14.0 - (42.0**2 + 14.0**2) / (4.0 * 14.0)  # of both arcs, on y
    radii = [np.linalg.norm(arc - (0.0, middle), axis=1) for arc in (inner, outer)]
    for radius in radii:
        assert radius == pytest.approx(np.full(len(radius), radius[0]), rel=1e-9)
    assert radii[1][0] - radii[0][0] == pytest.approx(14.0)
    for start, end in ((cut[0], outer[0]), (cut[-1], outer[-1])):
        along, radial = end - start, start - (0.0, middle)
        assert along @ radial == pytest.approx(float(np.linalg.norm(along) * np.linalg.norm(radial)))


def test_a_keystone_leaves_its_ends_as_far_behind_as_it_goes_into_the_defect() -> None:
    found = edges(drawn("keystone", length=42.0, width=14.0, advance=0.5))
    assert length(found["stem_left"][0]) == pytest.approx(7.0)
    assert length(found["back"][0]) - length(found["back"][1]) == pytest.approx(2.0 * 7.0, rel=0.01)
    assert length(found["left"][0]) == pytest.approx(14.0 - 7.0)


@pytest.mark.parametrize("name", ["keystone", "upper-lid"])
def test_what_stays_on_its_bed_is_not_undermined(name: str) -> None:
    assert not any(isinstance(event, Undermine) for event in flap_on_patch(name, spacing=2.0).events)
    assert any(isinstance(event, Undermine) for event in flap_on_patch("limberg", spacing=2.0).events)


def test_a_nasolabial_flap_reaches_from_its_pivot_to_the_far_side_of_the_defect() -> None:
    design = drawn("nasolabial", diameter=12.0, angle=60.0)
    (carry,) = design.carries
    pivot = np.array(carry.pivot)
    assert np.linalg.norm(pivot) == pytest.approx(2.0 * 6.0)
    reach = [float(np.linalg.norm(np.array(spot.point) - pivot)) for spot in (carry.corner, carry.lay)]
    assert reach == pytest.approx([18.0, 18.0], rel=0.02)
    donor = edges(design)["donor"]
    assert length(donor[0]) == pytest.approx(length(donor[1]), rel=0.01)  # it closes in a line
    assert design.excised[1].name == "tip"


def test_a_nasolabial_flap_longer_than_its_donor_site_is_refused() -> None:
    with refuses(ProblemCode.DESIGN_RANGE, "nasolabial") as problems:
        nasolabial_flap(np.zeros(3), (1.0, 0.0, 0.0), 12.0, angle=140.0, height=2.5)
    assert problems[0].value == "2.5"  # the height, which may be as the flap needs it


def test_a_dorsal_nasal_flap_slides_along_the_groove_by_what_was_asked_for() -> None:
    design = drawn("dorsal-nasal", diameter=14.0, length=56.0, slide=0.5)
    found = edges(design)
    circle = np.linalg.norm(found["front"][1], axis=1)
    assert circle == pytest.approx(np.full(len(circle), 7.0))
    assert length(found["front"][0]) == pytest.approx(7.0 * np.radians(120.0) + 7.0, rel=0.01)
    assert found["side"][1][0] == pytest.approx(found["front"][1][-1])  # the cheek's lip begins at the defect
    apex = np.array(design.corners[1].flap.point)[:2]
    assert apex == pytest.approx((56.0, 0.0))
    assert length(found["donor_stem"][0]) == pytest.approx(7.0, rel=0.01)


def test_the_crescent_of_an_upper_lid_has_its_height_where_it_is_widest() -> None:
    design = drawn("upper-lid", length=30.0, width=8.0, arch=2.5, tail=0.0, widest=0.6)
    lower, upper = edges(design)["closure"]
    x = np.linspace(-14.0, 14.0, 561)
    high = np.interp(x, upper[:, 0], upper[:, 1]) - np.interp(x, lower[:, 0], lower[:, 1])
    assert high.max() == pytest.approx(8.0, abs=0.05)
    assert x[high.argmax()] == pytest.approx((0.6 - 0.5) * 30.0, abs=1.0)  # points are 1 mm apart
    assert lower[:, 1].max() - lower[0, 1] == pytest.approx(2.5, abs=0.02)
    assert lower[0] == pytest.approx(upper[0])
    assert lower[-1] == pytest.approx(upper[-1])
    with refuses(ProblemCode.DESIGN_RANGE, "upper-lid") as problems:
        drawn("upper-lid", length=15.0, width=9.0)
    assert problems[0].value == "9"
