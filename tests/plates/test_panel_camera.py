"""The plan that opens a plate on a body shows more of it than the panels that follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.drawing.scenery_read import SceneryMesh
from lappet.drawing.skin_read import SkinCache
from lappet.plates.panel_camera import MOST_AROUND, with_body
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


@pytest.mark.parametrize("context", [1.1, 1.5, 2.5, 3.3])
def test_the_panel_that_opens_a_plate_shows_the_body_and_the_others_are_nearer(
    scene: PlateScene, context: float
) -> None:
    whole = on_body(scene, context)
    opening, other = (with_body(whole, opens).projection(SIZE).scale for opens in (True, False))
    around_opening, around_other = (context * whole.projection(SIZE).scale / each for each in (opening, other))
    assert 1.0 < around_other <= around_opening + 1e-9
    assert around_other < context
    # As much of the body as there is, but the operation stays large enough to be seen.
    assert around_opening == pytest.approx(max(min(context, MOST_AROUND), around_other))
    np.testing.assert_array_equal(with_body(whole, False).view.position, whole.view.position)  # a lens, not a step


def test_a_flat_patch_is_seen_alike_in_all_panels(scene: PlateScene) -> None:
    assert {with_body(scene, opens).zoom for opens in (True, False)} == {1.0}
