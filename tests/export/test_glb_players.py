"""What three.js, Babylon and <model-viewer> play of a .glb is the cache, frame by frame, compressed or not."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.geometry.closest_point import ClosestPoint
from model_players import places, played, player_site

pytestmark = [pytest.mark.slow, pytest.mark.timeout(600)]
CLOSE = 0.05  # mm


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("players"), step=4.0))


@pytest.fixture(scope="module")
def models(cache: SkinCache) -> dict[str, Path]:
    pytest.importorskip("meshoptimizer")
    made = {}
    for name in ("", "quantized", "meshopt"):
        target = cache.path.with_name(f"skin_{name}.glb")
        (made[name],) = export(ExportRequest((cache.path,), target, {name: True} if name else {}))
    return made


def both_ways(a: np.ndarray, b: np.ndarray) -> float:
    """The greatest distance from a point of either set to the nearest of the other."""
    worst = 0.0
    for one, other in ((a, b), (b, a)):
        every = np.arange(len(other))
        worst = max(worst, float(ClosestPoint(other.astype(float), np.stack([every] * 3, 1)).query(one)[2].max()))
    return worst


@pytest.mark.parametrize("kind", ["", "meshopt"])
@pytest.mark.parametrize("player", ["three", "babylon", "model-viewer"])
def test_a_player_shows_the_right_epoch_and_instruments_where_they_were_solved(
    models: dict[str, Path], cache: SkinCache, tmp_path: Path, player: str, kind: str
) -> None:
    model = models[kind]
    begin = cache.frames[0]
    # A moment later: the file has its times in single precision, and meshes change places at once. After the end some
    # players begin anew.
    end = (cache.frames[-1] - begin) / cache.fps - 1e-5
    poses = [("Operation", min(end, (time - begin) / cache.fps + 1e-5)) for time in cache.frames]
    done = played(player_site(tmp_path, player, model), player, model, poses)
    animations, *frames = done.results
    assert animations[0] == "Operation"
    assert [each[:2] for each in animations[1:4]] == ["1 ", "2 ", "3 "]
    for time, shown in zip(cache.frames, frames, strict=True):
        epoch = cache.epoch_at(time)
        assert {found[0] for name in shown if (found := re.match(r"epoch_\d\d", name))} == {epoch.name}, time
        assert any("threads" in name for name in shown) == bool(cache.sutures(time).active.any()), time
        assert any("hooks" in name for name in shown) == bool(cache.hooks(time).active.any()), time
        skin = [part for name, parts in shown.items() if "epoch" in name for part in parts]
        assert both_ways(places(skin), cache.positions(epoch, time)) < CLOSE, time
        printed = [part["picture"] for part in skin if part["material"].startswith("Skin with grid")]
        assert printed
        assert all(printed)
    assert [
        line
        for line in done.console
        if not any(each in line for each in ("GPU stall", "THREE.WARNING", "rAF timed out"))
    ] == []


def test_compression_by_meshopt_takes_much_less_space_and_moves_nothing(models: dict[str, Path]) -> None:
    from lappet.export.glb_meshopt import unpacked

    sizes = {name: path.stat().st_size for name, path in models.items()}
    assert sizes["meshopt"] < 0.6 * sizes["quantized"]
    (packed, data), (plain, own) = (unpacked(models[name].read_bytes()) for name in ("meshopt", "quantized"))
    assert packed["extensionsRequired"] == ["KHR_mesh_quantization", "EXT_meshopt_compression"]
    for document, buffer in ((packed, data), (plain, own)):
        mesh = next(each for each in document["meshes"] if each["name"] == "epoch_01")
        accessor = document["accessors"][mesh["primitives"][0]["attributes"]["POSITION"]]
        view = document["bufferViews"][accessor["bufferView"]]
        found = buffer[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
        if document is packed:
            kept = found
    assert found == kept
