"""What is read of a skin cache, and which files are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.skin_fields import UNDERSIDE, WOUND_WALL
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError
from lappet.drawing.suture_bites import buried


def test_the_cache_is_read_with_its_epochs_frames_events_and_strands(cache: SkinCache) -> None:
    assert cache.frames == tuple(float(t) for t in synthetic.FRAMES)
    assert [e.name for e in cache.epochs] == ["epoch_00", "epoch_01"]
    assert cache.epoch_at(2.0).name == "epoch_00"
    assert cache.epoch_at(3.0).name == "epoch_01"
    assert not (cache.epochs[0].origin == WOUND_WALL).any()
    assert [e.kind for e in cache.events] == ["Incision", "Hook", "Hook", *["Suture"] * 4]
    assert cache.events[1].end == synthetic.SUTURED
    assert list(cache.sutures(8.0).active) == [True, True, False, False]
    assert cache.hooks(5.0).ends.shape == (2, 2, 3)
    (mark,) = cache.planned_incisions(1.0)
    np.testing.assert_allclose(mark[[0, -1], 0], [-synthetic.HALF_SLIT, synthetic.HALF_SLIT])


def test_a_file_that_is_not_usd_or_holds_no_skin_is_refused(tmp_path: Path) -> None:
    pytest.importorskip("pxr")
    (tmp_path / "noise.usdc").write_bytes(b"not a usd file")
    with pytest.raises(FigureError, match="not a USD file"):
        SkinCache(tmp_path / "noise.usdc")
    synthetic.write_procedure(tmp_path / "procedure.usda")
    with pytest.raises(FigureError, match="holds no skin"):
        SkinCache(tmp_path / "procedure.usda")


def test_a_cache_whose_sutures_and_flags_disagree_is_refused_with_the_frame(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    path = synthetic.write_cache(tmp_path, step=10.0)
    stage = usd.Stage.Open(str(path))
    stage.GetPrimAtPath("/Procedure/Skin/Sutures").GetAttribute("primvars:active").Set([1, 1], 9.0)
    stage.GetRootLayer().Save()
    with pytest.raises(FigureError, match=r"/Procedure/Skin/Sutures has 4 curves and 2 values of active at frame 9"):
        SkinCache(path).sutures(9.0)


def test_lips_are_told_apart_at_rest_where_the_procedure_says_where_the_anchors_are(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    sdf = pytest.importorskip("pxr.Sdf")
    path = synthetic.write_cache(tmp_path, step=5.0)
    cache = SkinCache(path)
    points, ends = cache.suture_apart(cache.epochs[1], 2)
    # Without labels: where the suture is first active.
    np.testing.assert_array_equal(points, cache.positions(cache.epochs[1], synthetic.LIFTED + 2))
    np.testing.assert_allclose(ends[:, 0], synthetic.SUTURES[2], atol=1e-5)
    stage = usd.Stage.Open(str(path))
    labels = [f"suture_{k + 1}" for k in range(4)]
    skin = stage.GetPrimAtPath("/Procedure/Skin/Sutures")
    skin.CreateAttribute("primvars:label", sdf.ValueTypeNames.StringArray).Set(labels)
    suture = stage.GetPrimAtPath("/Procedure/Timeline/suture_3")
    suture.CreateAttribute("lappet:anchors", sdf.ValueTypeNames.Point3fArray).Set([(4, -0.25, 0), (4, 0.25, 0)])
    stage.GetRootLayer().Save()
    cache = SkinCache(path)
    points, ends = cache.suture_apart(cache.epochs[1], 2)
    np.testing.assert_array_equal(points, cache.positions(cache.epochs[1], synthetic.INCISED))
    np.testing.assert_allclose(ends, [[4, -0.25, 0], [4, 0.25, 0]])


def test_taut_skin_that_parts_as_it_is_cut_is_read_at_the_rest_that_its_cache_holds(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    sdf = pytest.importorskip("pxr.Sdf")
    usd_geom = pytest.importorskip("pxr.UsdGeom")
    path = synthetic.write_cache(tmp_path, step=5.0)
    stage = usd.Stage.Open(str(path))
    mesh = usd_geom.Mesh(stage.GetPrimAtPath("/Procedure/Skin/epoch_01"))
    rest = np.array(mesh.GetPointsAttr().Get(float(synthetic.INCISED)))
    gaping = synthetic.lips_apart(rest.astype(np.float64), 6.0)
    mesh.GetPointsAttr().Set(rest)
    mesh.GetPointsAttr().Set(gaping, float(synthetic.INCISED))
    skin = stage.GetPrimAtPath("/Procedure/Skin/Sutures")
    skin.CreateAttribute("primvars:label", sdf.ValueTypeNames.StringArray).Set([f"suture_{k + 1}" for k in range(4)])
    anchors = [(4, -0.02, 0), (4, 0.02, 0)]
    suture = stage.GetPrimAtPath("/Procedure/Timeline/suture_3")
    suture.CreateAttribute("lappet:anchors", sdf.ValueTypeNames.Point3fArray).Set(anchors)
    stage.GetRootLayer().Save()
    cache = SkinCache(path)
    epoch = cache.epochs[1]
    assert np.abs(cache.positions(epoch, epoch.frames[0]) - gaping).max() < 1e-5
    np.testing.assert_array_equal(cache.rest(epoch), rest)
    points, ends = cache.suture_apart(epoch, 2)
    np.testing.assert_array_equal(points, rest)
    np.testing.assert_allclose(ends, anchors, atol=1e-6)
    assert not buried(points, epoch.triangles, cache.depth(epoch), ends)


def test_no_bed_is_drawn_below_what_lies_on_nothing(tmp_path: Path) -> None:
    usd, geom, vt = (pytest.importorskip(f"pxr.{name}") for name in ("Usd", "UsdGeom", "Vt"))
    path = synthetic.write_cache(tmp_path, step=5.0)
    whole = SkinCache(path)
    points, epoch = whole.rest(whole.epochs[0]), whole.epochs[0]
    middles = points[epoch.triangles].mean(axis=1)
    free = np.flatnonzero((epoch.origin == UNDERSIDE) & (middles[:, 0] > 0.0)).astype(np.int32)
    assert len(free)
    stage = usd.Stage.Open(str(path))
    mesh = geom.Mesh(stage.GetPrimAtPath("/Procedure/Skin/epoch_00"))
    geom.Subset.CreateGeomSubset(mesh, "lining", geom.Tokens.face, vt.IntArray.FromNumpy(free))
    stage.GetRootLayer().Save()
    kept = SkinCache(path)
    assert kept.epochs[0].lining is not None
    np.testing.assert_array_equal(np.flatnonzero(kept.epochs[0].lining), free)
    before, after = (DeepBed(cache) for cache in (whole, kept))
    assert 0 < len(after.triangles) < len(before.triangles)
    assert after.rest[after.triangles].mean(axis=1)[:, 0].max() <= 0.0
    assert before.rest[before.triangles].mean(axis=1)[:, 0].max() > 0.0
