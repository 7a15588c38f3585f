"""What is left open of a wound is measured: a slit that gapes is, once it is sutured it is not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from shapely import Polygon

import synthetic_skin_cache as synthetic
from lappet.drawing.open_wound import open_area
from lappet.drawing.skin_read import SkinCache
from lappet.geometry.labeled_surface import FaceOrigin

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=2.0))


def lips(cache: SkinCache, time: float) -> np.ndarray:
    """The edge of the slit at a frame, once around, in the plane of the skin."""
    epoch = cache.epoch_at(time)
    rest, now = cache.rest(epoch), cache.positions(epoch, time)
    skin = np.unique(epoch.triangles[epoch.origin == 0])
    on_slit = skin[(np.abs(rest[skin, 1]) < 1.0) & (np.abs(rest[skin, 0]) < synthetic.HALF_SLIT + 1e-6)]
    middle = now[on_slit, 1].mean()
    upper = on_slit[now[on_slit, 1] >= middle]
    lower = on_slit[now[on_slit, 1] < middle]
    ring = [*upper[np.argsort(rest[upper, 0])], *lower[np.argsort(-rest[lower, 0])]]
    return np.asarray(now[ring, :2])


def test_a_slit_that_hooks_hold_apart_is_open_by_the_area_between_its_lips(cache: SkinCache) -> None:
    expected = Polygon(lips(cache, synthetic.LIFTED)).buffer(-1.5).area
    assert expected > 50.0
    assert open_area(cache, synthetic.LIFTED, UP) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("time", [1.0, 12.0])
def test_whole_skin_and_a_sutured_slit_are_closed(cache: SkinCache, time: float) -> None:
    assert open_area(cache, time, UP) == 0.0


@dataclass
class Island:
    """A sheet 40 mm wide with a square hole, and in it a square of skin; walls go down from both edges of the wound."""

    hole: float  # mm, half of its side
    half: float

    def __post_init__(self) -> None:
        square = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
        rings = [(20.0, 0.0), (self.hole, 0.0), (self.half, 0.0), (self.hole, -4.0), (self.half, -4.0)]
        self.points = np.concatenate([np.column_stack([half * square, np.full(4, z)]) for half, z in rings])

        def band(outer: int, inner: int) -> list[tuple[int, int, int]]:
            a, b, after = 4 * outer, 4 * inner, lambda k: (k + 1) % 4
            quads = [(a + k, a + after(k), b + after(k), b + k) for k in range(4)]
            return [triangle for w, x, y, z in quads for triangle in ((w, x, y), (w, y, z))]

        skin = [*band(0, 1), (8, 9, 10), (8, 10, 11)]
        walls = [*band(1, 3), *band(2, 4)]
        self.triangles = np.array(skin + walls)
        self.origin = np.array([FaceOrigin.SKIN] * len(skin) + [FaceOrigin.WOUND_WALL] * len(walls))

    def epoch_at(self, time: float) -> Island:
        return self

    def positions(self, epoch: Island, time: float) -> np.ndarray:
        return self.points


def test_an_island_that_fills_its_wound_leaves_nothing_open() -> None:
    assert open_area(Island(6.0, 5.0), 1.0, UP) == 0.0


def test_around_an_island_the_ring_that_gapes_is_open() -> None:
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    ring = Polygon(10.0 * square).buffer(-1.5).area - Polygon(5.0 * square).buffer(1.5).area
    assert open_area(Island(10.0, 5.0), 1.0, UP) == pytest.approx(ring, rel=0.01)
