"""Light on a drawn surface: its facets throw no bands, and no crack between meshes is seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.drawing.skin_source import SkinEpoch
from lappet.plates.drawn_surface import DrawnSurface
from lappet.plates.filled_areas import AreaKind, SeenPixels, without_cracks
from lappet.plates.smooth_normals import smooth_normals

SIDE = 60.0  # mm
STEP = 0.5
HOLLOW = tuple(AreaKind).index(AreaKind.HOLLOW)


def sheet(tilt: np.ndarray, origin: np.ndarray | None = None) -> DrawnSurface:
    """A flat sheet whose normals lean along x by `tilt` at each of its columns of vertices."""
    count = len(tilt)
    x, y = np.meshgrid(STEP * np.arange(count), STEP * np.arange(9), indexing="ij")
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    at = np.arange(len(points)).reshape(count, 9)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    normals = np.stack([np.sin(tilt), np.zeros(count), np.cos(tilt)], axis=1)[triangles // 9]
    kinds = np.zeros(len(triangles), np.int64) if origin is None else origin[triangles.min(axis=1) // 9]
    epoch = SkinEpoch("epoch_00", triangles.astype(np.int32), kinds.astype(np.uint8), None, (0.0,), None)
    return DrawnSurface(0.0, epoch, points, points, 0.0 * points[:, 0], triangles, kinds, 0 * kinds, normals)


@pytest.mark.parametrize("length", [0.0, 0.5, 2.0])
def test_a_wave_of_the_normals_keeps_the_share_that_diffusion_leaves_of_it(length: float) -> None:
    """1 / (1 + (2 pi length / wavelength)^2); of small tilts the unit length changes nothing."""
    wavelength, height = SIDE / 6.0, 0.01
    x = STEP * np.arange(round(SIDE / STEP) + 1)
    tilt = height * np.cos(2.0 * np.pi * x / wavelength)  # whole waves: no slope at the ends
    surface = sheet(tilt)
    left = smooth_normals(surface, length)[..., 0]
    share = float((left * tilt[surface.triangles // 9]).sum() / (tilt[surface.triangles // 9] ** 2).sum())
    assert share == pytest.approx(1.0 / (1.0 + (2.0 * np.pi * length / wavelength) ** 2), rel=0.01)


def test_normals_stay_apart_where_the_faces_are_of_another_origin() -> None:
    half = np.arange(41) >= 20
    before = sheet(np.where(half, 0.5, -0.5), half.astype(np.int64))
    normals = before.normals.copy()
    normals[before.origin == 0] = (np.sin(-0.5), 0.0, np.cos(0.5))
    normals[before.origin == 1] = (np.sin(0.5), 0.0, np.cos(0.5))
    surface = replace(before, normals=normals)
    np.testing.assert_allclose(smooth_normals(surface, 5.0), normals, atol=1e-9)


def test_a_crack_of_two_pixels_shows_what_is_beside_it_and_a_nostril_stays() -> None:
    shape = (40, 40)
    kind, triangle = np.zeros(shape, np.int64), np.full(shape, 7)
    kind[10:12, 5:30] = HOLLOW
    kind[25:35, 15:25] = HOLLOW
    kind[3, 3] = -1
    triangle[kind != 0] = -1
    depth = np.where(kind == 0, 100.0, np.inf)
    row = np.arange(40.0)
    closed = without_cracks(SeenPixels(triangle, depth, kind, row, row, np.where(kind == 0, 2.0, np.nan)))
    assert (closed.kind[:20] == 0).all()
    assert (closed.triangle[:20] == 7).all()
    assert np.isfinite(closed.depth[:20]).all()
    assert closed.quantity is not None
    assert np.isfinite(closed.quantity[:20]).all()
    assert (closed.kind[25:35, 15:25] == HOLLOW).all()
    assert (kind[10:12, 5:30] == HOLLOW).all()  # what was given is left as it was
