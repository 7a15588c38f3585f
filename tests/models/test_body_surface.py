from __future__ import annotations

import numpy as np

from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.triangles import areas
from lappet.models.body_shape import NEUTRAL, BodyShape
from lappet.models.body_surface import BodySurface, body_surface
from lappet.models.catalogue import BODY_MODELS

FACE = BODY_MODELS["face"]


def surface(shape: BodyShape = NEUTRAL) -> BodySurface:
    return body_surface(shape, FACE.surround, FACE.subdivision)


def test_the_face_has_six_borders_its_own_two_eyes_a_mouth_and_two_nostrils() -> None:
    skin = surface().inside(FACE.region)
    loops = sorted(border_loops(skin.triangles), key=lambda loop: -perimeter(skin.points, loop))
    middles = np.array([skin.points[loop].mean(axis=0) for loop in loops])
    lengths = [perimeter(skin.points, loop) for loop in loops]
    assert len(loops) == 6
    assert lengths[0] > 400.0
    assert 80.0 < lengths[1] < 120.0  # the mouth
    assert abs(middles[1][0]) < 0.5
    assert np.allclose(sorted(middles[2:4, 0]), [-30.5, 30.5], atol=3.0)  # the eyes
    assert all(15.0 < length < 40.0 for length in lengths[4:])  # the nostrils


def test_a_region_holds_the_same_skin_whatever_the_shape() -> None:
    young, old = surface().inside(FACE.region), surface(BodyShape(age=80.0, sex=1.0)).inside(FACE.region)
    assert np.allclose(young.neutral, old.neutral)
    assert np.linalg.norm(young.points - old.points, axis=1).max() > 2.0


def test_inside_and_outside_of_a_region_are_the_whole() -> None:
    whole = surface()
    parts = (whole.inside(FACE.region), whole.outside(FACE.region))
    total = sum(areas(part.points[part.triangles]).sum() for part in parts)
    assert abs(total - areas(whole.points[whole.triangles]).sum()) < 0.001 * total


def test_the_face_is_the_same_on_both_sides() -> None:
    skin = surface().inside(FACE.region)
    size, middle = areas(skin.points[skin.triangles]), skin.points[skin.triangles].mean(axis=1)
    left, right = size[middle[:, 0] < 0.0].sum(), size[middle[:, 0] > 0.0].sum()
    assert abs(left / right - 1.0) < 0.01


def test_a_place_of_the_neutral_body_is_carried_to_the_shaped_one() -> None:
    shape = BodyShape(age=70.0)
    skin = surface(shape)
    picked = np.arange(0, len(skin.points), 997)
    carried, away = skin.carried(skin.neutral[picked])
    assert np.allclose(carried, skin.points[picked], atol=1e-6)
    assert np.allclose(away, 0.0, atol=1e-6)


def test_what_is_shown_of_a_body_ends_in_a_clean_border() -> None:
    low, high = np.array(FACE.surround)
    skin = surface().within(FACE.surround)
    assert (skin.neutral > low - 1e-6).all()
    assert (skin.neutral < high + 1e-6).all()
    border = np.concatenate([loop for loop in border_loops(skin.triangles) if perimeter(skin.points, loop) > 200.0])
    on_box = np.minimum(np.abs(skin.neutral[border] - low), np.abs(skin.neutral[border] - high)).min(axis=1) < 1e-6
    assert on_box.all()
