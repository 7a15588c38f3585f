"""The bed of a layer against the formulas of a wide layer, and the default against its derivation."""

from __future__ import annotations

import pytest

from lappet.core.problem_code import ProblemCode
from lappet.procedure import Material, Tissue
from lappet.tissue.bed import BEDS, bed_of
from lappet.tissue.uniaxial import nominal_stresses, stretches_under
from refusals import refuses


def test_a_layer_that_cannot_spread_gives_way_by_the_slope_of_the_law() -> None:
    """The oedometric modulus is the slope of a law whose sides are held."""
    layer = Material("layer", youngs_modulus=2.0 * 3.0 * 1.4, poissons_ratio=0.4)
    s = stretches_under(layer, {0: 1.0, 1: 1.0, 2: 1.0 - 1e-6}, {})
    assert bed_of(3.0, 2.0, 0.4).normal == pytest.approx(-nominal_stresses(layer, s)[2] / 1e-6 / 2.0, rel=1e-4)
    assert bed_of(3.0, 2.0, 0.4).shear == 1.5


def test_the_default_bed_is_that_of_two_millimetres_of_fat() -> None:
    fat = bed_of(0.75, 2.0)
    assert Tissue.bed_shear == pytest.approx(fat.shear)
    assert Tissue.bed_stiffness == pytest.approx(fat.normal, rel=0.01)
    assert 0.3 <= Tissue.bed_shear <= 1.0  # where undermining takes off what was measured
    assert BEDS["loose"].shear < BEDS["default"].shear < BEDS["tight"].shear


def test_a_layer_without_thickness_is_refused() -> None:
    with refuses(ProblemCode.LENGTH_NOT_POSITIVE):
        bed_of(1.0, 0.0)
