"""A unilateral cleft of the lip: what it does to the lip and the nose, and that no tissue is turned inside out."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops
from lappet.models.body_shape import NEUTRAL, BodyShape
from lappet.models.body_surface import BodySurface, body_surface
from lappet.models.catalogue import BODY_MODELS
from lappet.models.cleft import COMPLETE, INCOMPLETE, Cleft

KINDS = pytest.mark.parametrize("cleft", [INCOMPLETE, COMPLETE], ids=["incomplete", "complete"])
MODEL = BODY_MODELS["cleft-lip"]
PEAK, OTHER_PEAK = (-5.0, 152.5, 678.0), (5.0, 152.5, 678.0)
ALA_BASE, BORDER = (-11.0, 143.0, 689.5), (-8.0, 146.0, 669.6)


def moved(cleft: Cleft, *places: tuple[float, float, float]) -> NDArray[np.float64]:
    at = np.array(places)
    return at + cleft.moved(at)


@KINDS
def test_space_is_never_turned_inside_out(cleft: Cleft) -> None:
    """The Jacobian of the movement, by central differences, is positive all over the lip and the nose."""
    axes = [np.arange(low, high, 0.7) for low, high in ((-28.0, 20.0), (132.0, 162.0), (660.0, 708.0))]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    step = 1e-4 * np.eye(3)
    columns = [(cleft.moved(grid + each) - cleft.moved(grid - each)) / 2e-4 for each in step]
    jacobian = np.stack(columns, axis=2) + np.eye(3)
    assert np.linalg.det(jacobian).min() > 0.05


@KINDS
def test_cupids_bow_rises_towards_the_cleft_and_the_border_is_notched(cleft: Cleft) -> None:
    peak, other, border = moved(cleft, PEAK, OTHER_PEAK, BORDER)
    assert 2.5 < peak[2] - other[2] < 6.0
    assert border[2] > BORDER[2] + 6.0
    assert other[2] == pytest.approx(OTHER_PEAK[2], abs=0.5)


@KINDS
def test_the_base_of_the_ala_goes_to_the_side_and_back(cleft: Cleft) -> None:
    (base,) = moved(cleft, ALA_BASE)
    assert base[0] < ALA_BASE[0] - 1.5
    assert base[1] < ALA_BASE[1] - 1.5


def test_the_lower_lip_and_what_is_far_away_stay() -> None:
    still = np.array([(0.0, 150.0, 663.0), (-10.0, 147.0, 666.0), (40.0, 120.0, 700.0), (0.0, 145.0, 735.0)])
    assert np.abs(COMPLETE.moved(still)).max() < 0.05


@cache
def surface(cleft: Cleft | None, shape: BodyShape = NEUTRAL) -> BodySurface:
    return body_surface(shape, MODEL.surround, 1, cleft).inside(MODEL.region)


def test_a_complete_cleft_opens_the_mouth_into_the_nostril() -> None:
    """The border of the model, the mouth and two nostrils; a complete cleft makes one of the mouth and a nostril."""
    assert len(border_loops(surface(INCOMPLETE).triangles)) == 4
    assert len(border_loops(surface(COMPLETE).triangles)) == 3


def test_a_childs_cleft_is_as_much_smaller_as_its_mouth() -> None:
    child = surface(INCOMPLETE, BodyShape(age=5.0))
    adult = surface(INCOMPLETE)
    rise = [np.linalg.norm(each.cleft(INCOMPLETE) - each.points, axis=1).max() for each in (child, adult)]
    corners = [np.ptp(each.carried([(-21.0, 138.0, 667.6), (21.0, 138.0, 667.6)])[0][:, 0]) for each in (child, adult)]
    assert corners[0] < 0.95 * corners[1]
    assert rise[0] / rise[1] == pytest.approx(corners[0] / corners[1], rel=0.02)
