"""The hatching of an area undermined stays inside its outline, on curved skin too."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
import trimesh

from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.plates.plate_scene import PlateScene
from lappet.plates.undermined_hatch import undermined_hatch

RADIUS = 20.0  # mm


LEAN = np.array([0.5, 0.0, np.sqrt(0.75)])  # the middle of the area, 30 degrees beside the top


def dome_scene(border: float) -> PlateScene:
    """A ball of skin seen from above, undermined up to an angle of `border` degrees from `LEAN`."""
    ball = trimesh.creation.icosphere(subdivisions=5, radius=RADIUS)
    triangles, rest = ball.faces.astype(np.int32), ball.vertices.astype(np.float32)
    epoch = SimpleNamespace(name="epoch_00", triangles=triangles, origin=np.full(len(triangles), FaceOrigin.SKIN))
    turn, tilt = np.linspace(0.0, 2.0 * np.pi, 200), np.radians(border)
    aside, along = np.cross(LEAN, (0.0, 1.0, 0.0)), np.array([0.0, 1.0, 0.0])
    around = np.cos(turn)[:, None] * aside + np.sin(turn)[:, None] * along
    ring = RADIUS * (np.cos(tilt) * LEAN + np.sin(tilt) * around)
    source = SimpleNamespace(
        events=[SimpleNamespace(kind="Undermine", start=1.0)],
        epochs=[epoch],
        epoch_at=lambda time: epoch,
        rest=lambda epoch: rest,
        positions=lambda epoch, time: rest,
        undermined_areas=lambda step: [ring],
    )
    scene: Any = SimpleNamespace(source=source, axes=np.eye(3), whole_skin=ClosestPoint(rest, triangles))
    return cast("PlateScene", scene)


@pytest.mark.parametrize("border", [15.0, 30.0, 45.0])
def test_the_hatching_of_a_dome_reaches_its_outline_and_does_not_leave_it(border: float) -> None:
    lines = undermined_hatch(dome_scene(border), 1.0, 2.0)
    places = np.concatenate([line.points for line in lines])
    away = np.degrees(np.arccos(np.clip(places @ LEAN / np.linalg.norm(places, axis=1), -1.0, 1.0)))
    np.testing.assert_allclose(np.linalg.norm(places, axis=1), RADIUS, atol=0.05)
    assert away.max() < border + 1.5
    assert away.max() > border - 4.0
    assert away.min() < 4.0


def test_no_area_is_hatched_before_it_is_undermined() -> None:
    assert undermined_hatch(dome_scene(45.0), 0.5, 2.0) == []
