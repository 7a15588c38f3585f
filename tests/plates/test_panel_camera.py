"""The plan that opens a plate on a body shows more of it than the panels that follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.drawing.scenery_read import SceneryMesh
from lappet.drawing.skin_read import SkinCache
from lappet.plates.panel_camera import MOST_AROUND, from_afar
from lappet.plates.plate_cache import chosen_steps
from lappet.plates.plate_scene import PlateScene, plate_scene

SIZE = (54.0, 40.5)


@pytest.fixture(scope="module")
def scene(cache: SkinCache) -> PlateScene:
    return plate_scene(cache, [step.time for step in chosen_steps(cache)], "oblique", SIZE)


def on_body(scene: PlateScene, context: float) -> PlateScene:
    """The same scene, as if a body were shown around it."""
    mesh = SceneryMesh("face", "skin", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32))
    return replace(scene, scenery=(mesh,), field=replace(scene.field, context=context))


@pytest.mark.parametrize("context", [1.1, 1.5, 2.0])
def test_from_afar_more_of_the_body_is_in_the_picture_but_never_too_much(scene: PlateScene, context: float) -> None:
    near = on_body(scene, context)
    far = from_afar(near)
    wider = near.projection(SIZE).scale / far.projection(SIZE).scale
    assert 1.0 < wider * context <= MOST_AROUND + 1e-9
    assert wider > 1.0
    np.testing.assert_array_equal(far.view.position, near.view.position)  # a lens, not a step back


def test_a_flat_patch_and_a_wound_with_much_around_it_are_seen_as_they_were(scene: PlateScene) -> None:
    assert from_afar(scene) is scene
    wide = on_body(scene, MOST_AROUND + 0.1)
    assert from_afar(wide) is wide
