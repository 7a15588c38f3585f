"""The printed grid in millimetres and the depth of walls."""

from __future__ import annotations

import numpy as np

import synthetic_skin_cache as synthetic
from lappet.drawing.skin_fields import SKIN, WOUND_WALL
from lappet.geometry.skin_shape import depth_below_skin, uv_scale


def test_the_grid_is_in_millimetres_whatever_the_unit_of_st() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    triangles = triangles[origin == SKIN]
    for units in ((100.0, 80.0), (1.0, 1.0), (12.5, 3.0)):
        st = (rest[triangles][:, :, :2] / units).astype(np.float32)
        np.testing.assert_allclose(uv_scale(rest.astype(np.float32), triangles, st), units, rtol=1e-4)
    np.testing.assert_array_equal(uv_scale(rest.astype(np.float32), triangles, np.zeros_like(st)), 1.0)


def test_depth_is_zero_on_the_skin_and_the_thickness_at_the_foot_of_a_wall() -> None:
    rest, triangles, origin = synthetic.patch(4.0, True)
    depth = depth_below_skin(rest.astype(np.float32), triangles, origin)
    assert not depth[np.unique(triangles[origin == SKIN])].any()
    foot = np.setdiff1d(triangles[origin == WOUND_WALL], triangles[origin == SKIN])
    np.testing.assert_allclose(depth[foot], synthetic.THICKNESS, rtol=1e-4)
