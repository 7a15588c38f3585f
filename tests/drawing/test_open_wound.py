"""What is left open of a wound is measured: a slit that gapes is, once it is sutured it is not."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import Polygon

import synthetic_skin_cache as synthetic
from lappet.drawing.open_wound import open_area
from lappet.drawing.skin_read import SkinCache

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
