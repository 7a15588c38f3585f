"""The plain functions behind the pictures: fields on the skin, stitches, hooks, framing, steps."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet_blender.figure_steps import MOST_PANELS, step_captions, story_steps
from lappet_blender.framing import surgical_region, viewpoint
from lappet_blender.hook_path import hook_path, pull_direction
from lappet_blender.sheet_layout import columns_for, sheet_layout
from lappet_blender.skin_fields import SKIN, WOUND_WALL, border_chains, depth_below_skin, uv_scale, vertex_normals
from lappet_blender.skin_read import FigureError, SkinCache, StepEvent
from lappet_blender.suture_path import BITE, find_bite, nearest_bite, stitch_path

UP = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    pytest.importorskip("pxr")
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=2.0))


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


def test_the_edge_of_a_slit_is_one_closed_chain_of_its_two_lips() -> None:
    rest, triangles, origin = synthetic.patch(2.0, True)
    chains = border_chains(triangles, origin)
    assert sum(len(c) - 1 for c in chains) == 40  # 20 edges a lip
    points = np.concatenate([rest[c] for c in chains])
    np.testing.assert_allclose(points[:, 1:], 0.0, atol=1e-6)
    assert np.abs(points[:, 0]).max() == pytest.approx(synthetic.HALF_SLIT)
    for chain in chains:
        assert (np.linalg.norm(np.diff(rest[chain], axis=0), axis=1) < 2.001).all()
    whole, faces, label = synthetic.patch(2.0, False)
    assert border_chains(faces, label) == []
    assert len(whole)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("gape", [0.05, 3.0])
def test_a_bite_lies_beside_the_wound_on_its_own_side_even_where_the_lips_nearly_touch(side: int, gape: float) -> None:
    rest, triangles, origin = synthetic.patch(1.0, True)
    moved = synthetic.deform(rest, synthetic.INCISED, True).astype(np.float64)
    lips = np.abs(rest[:, 1]) < 1e-6
    upper = rest[:, 1] > 0
    moved[:, 1] = rest[:, 1] + np.where(upper, gape / 2, -gape / 2)
    assert lips.any()
    points = moved.astype(np.float32)
    anchor = np.array([4.0, side * gape / 2, 0.0], np.float32)
    bite = find_bite(points, triangles, origin, anchor)
    carried = bite.carried(points)
    assert np.sign(carried[1]) == side
    assert abs(carried[1]) - gape / 2 == pytest.approx(BITE, abs=0.35)
    assert carried[0] == pytest.approx(4.0, abs=0.8)
    assert bite.weights.sum() == pytest.approx(1.0)


def test_the_nearest_point_of_the_skin_to_a_point_above_it_is_below_it() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    points = rest.astype(np.float32)
    bite = nearest_bite(points, triangles, origin, np.array([3.3, -7.1, 2.0]))
    np.testing.assert_allclose(bite.carried(points), [3.3, -7.1, 0.0], atol=1e-5)


@pytest.mark.parametrize("span", [0.0, 0.5, 4.4, 15.0])
def test_a_stitch_enters_the_skin_at_both_ends_and_stays_above_it_between(span: float) -> None:
    ends = np.array([[0.0, -span / 2, 0.0], [0.0, span / 2, 0.0]])
    stitch = stitch_path(ends, np.stack([UP, UP]), thread_radius=0.17)
    assert stitch.thread[0, 2] < 0
    assert stitch.thread[-1, 2] < 0
    assert (stitch.thread[1:-1, 2] >= 0.17 - 1e-9).all()
    for line in (stitch.thread, stitch.knot, *stitch.tails):
        assert np.isfinite(line).all()
        assert line[1:-1, 2].min() > -0.3


def test_a_hook_leans_along_its_pull_and_its_tip_is_under_the_skin() -> None:
    course = np.array([[0.0, 0.0, 0.0], [2.0, 0.0, 6.0], [9.0, 0.0, 0.5]])
    direction = pull_direction(course, UP, np.array([0.0, 1.0, 0.0]))
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    assert direction[0] > 0.7
    assert direction[2] > 0.4
    still = pull_direction(course[:1], UP, np.array([0.0, -3.0, 1.0]))
    assert still[1] < -0.7
    line, radii = hook_path(course[-1], direction, UP)
    assert line[0, 2] < course[-1, 2]
    assert line[-1, 2] > course[-1, 2] + 20
    assert len(line) == len(radii)
    assert radii[0] < radii[-2]
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps[:13].max() < 0.6  # the crook is a smooth arc


@pytest.mark.parametrize("view", ["oblique", "top", "low"])
@pytest.mark.parametrize("halves", [(0.2, 0.15), (0.1, 0.2)])
def test_the_camera_holds_the_whole_region_and_not_much_more(
    cache: SkinCache, view: str, halves: tuple[float, float]
) -> None:
    region = surgical_region(cache, cache.frames)
    np.testing.assert_allclose(region.normal, UP, atol=1e-6)
    assert np.abs(region.points[:, 0]).max() < 35
    seen = viewpoint(region, view, halves)
    np.testing.assert_allclose(seen.axes @ seen.axes.T, np.eye(3), atol=1e-9)
    local = (region.points - seen.position) @ seen.axes.T
    assert (local[:, 2] < 0).all()
    filled = np.abs(local[:, :2] / -local[:, 2:]) / halves
    assert filled.max() <= 1.0 + 1e-6
    assert filled.max() > 0.97


def test_normals_of_the_flat_skin_point_up() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    normals = vertex_normals(rest.astype(np.float32), triangles, origin, SKIN)
    np.testing.assert_allclose(normals[np.unique(triangles[origin == SKIN])], np.tile(UP, (546, 1)), atol=1e-6)


def test_the_filmstrip_tells_the_operation_in_order(cache: SkinCache) -> None:
    steps = story_steps(cache.events, cache.frames, synthetic.lift)
    assert [s.caption for s in steps] == [
        "Before",
        "Incision",
        "Lifted with hooks",
        "Transposed",
        "Sutured",
        "Final result",
    ]
    assert [s.frame for s in steps] == [1, 3, 6, 7, 11, 12]
    assert all(a.frame < b.frame for a, b in pairwise(steps))
    assert steps[1].detail == "central limb"
    assert steps[4].detail == "4 sutures"


def test_a_story_never_has_more_panels_than_the_sheet_nor_two_of_one_frame() -> None:
    many = [
        StepEvent(k, f"{k}_{i}", 1 + i, 3 + i) for i in range(9) for k in ("Incision", "Excision", "Hook", "Suture")
    ]
    for frames in ([1.0], [1.0, 2.0], [float(t) for t in range(1, 60)]):
        steps = story_steps(many, frames)
        assert 1 <= len(steps) <= MOST_PANELS
        assert len({s.frame for s in steps}) == len(steps)
        assert {s.frame for s in steps} <= set(frames)
    bare = story_steps([], [float(t) for t in range(1, 40)])
    assert len(bare) == MOST_PANELS
    assert bare[0].caption == "Before"


def test_chosen_frames_are_captioned_by_their_number_and_newest_event() -> None:
    events = [StepEvent("Incision", "upper_limb", 3, 3), StepEvent("Suture", "tip", 8, 9)]
    steps = step_captions(events, [1.0, 5.0, 8.0])
    assert [(s.caption, s.detail) for s in steps] == [("Frame 1", ""), ("Frame 5", "upper limb"), ("Frame 8", "tip")]


@pytest.mark.parametrize("count", range(1, 7))
def test_panels_of_a_sheet_lie_inside_it_and_do_not_overlap(count: int) -> None:
    (width, height), corners, caption = sheet_layout(count, (640, 480))
    assert len(corners) == count
    assert columns_for(count) <= 3
    for k, (x, y) in enumerate(corners):
        assert x >= 0
        assert x + 640 <= width
        assert y + 480 + caption <= height
        for u, v in corners[:k]:
            assert abs(x - u) >= 640 or abs(y - v) >= 480 + caption
