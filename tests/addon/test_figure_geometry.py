"""The plain functions behind the pictures: what is read of a cache, fields on the skin, hooks and framing."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import cast

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet_blender.figure.figure_steps import hook_height, story_steps
from lappet_blender.figure.framing import FIELD_FILL, NEARER, WIDEST, surgical_field, viewpoint, widened
from lappet_blender.look.dashed_line import DASH, GAP, dashes
from lappet_blender.look.hook_path import ELEVATION, hook_directions, hook_path
from lappet_blender.look.skin_fields import SKIN, WOUND_WALL, border_chains, depth_below_skin, uv_scale, vertex_normals
from lappet_blender.look.skin_read import SkinCache
from lappet_blender.look.skin_source import FigureError, SkinSource, StepEvent, Strands
from lappet_blender.look.suture_bites import bites_at, buried

UP = np.array([0.0, 0.0, 1.0])


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


def test_the_nearest_points_of_the_skin_to_points_above_it_are_below_them() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    points = rest.astype(np.float32)
    above = np.array([[3.3, -7.1, 2.0], [-20.0, 11.0, 0.5]])
    for bite, point in zip(bites_at(points, triangles[origin == SKIN], above), above, strict=True):
        np.testing.assert_allclose(bite.carried(points), [*point[:2], 0.0], atol=1e-5)


def test_hooks_come_in_from_opposite_sides_and_rise_however_their_flaps_cross_over() -> None:
    left = np.array([[-9.0, 0.0, 0.0], [0.0, 5.0, 10.0], [0.5, 15.0, 0.0]])
    for courses in ([left, -left * [1, 1, -1]], [-left * [1, 1, -1], left]):
        directions = hook_directions(courses, np.zeros(3), np.eye(3))
        for course, direction in zip(courses, directions, strict=True):
            assert np.linalg.norm(direction) == pytest.approx(1.0)
            assert np.degrees(np.arcsin(direction[2])) == pytest.approx(np.degrees(ELEVATION))
            assert np.sign(direction[0]) == np.sign(course[0, 0])
            assert abs(direction[0]) > 0.35
            assert np.sign(direction[1]) == np.sign(course[:, 1].mean())
    assert 35 <= np.degrees(ELEVATION) <= 50
    (alone,) = hook_directions([left[:1]], np.zeros(3), np.eye(3))
    assert alone[0] < -0.6
    assert hook_directions([], np.zeros(3), np.eye(3)) == []


@pytest.mark.parametrize("edge", [np.array([1.0, 0.0, 0.0]), UP])
def test_a_hooks_point_comes_up_at_the_anchor_and_its_crook_runs_under_the_skin(edge: np.ndarray) -> None:
    (direction,) = hook_directions([np.array([[5.0, 0.0, 0.0]])], np.zeros(3), np.eye(3))
    anchor = np.array([5.0, 1.0, 2.0])
    line, radii = hook_path(anchor, direction, UP, edge)
    assert 0.2 < line[0, 2] - anchor[2] < 1.0
    assert np.linalg.norm(line - anchor, axis=1).min() < 0.1
    assert line[:, 2].min() < anchor[2] - 0.5
    assert line[-1, 2] > anchor[2] + 20
    assert len(line) == len(radii)
    assert radii[0] < 0.1 < radii.max()
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    assert steps[:26].max() < 0.6  # crook and bend are smooth
    turns = np.diff(line[:27], axis=0) / steps[:26, None]
    assert np.einsum("ij,ij->i", turns[1:], turns[:-1]).min() > np.cos(np.radians(50))


def test_an_undermined_area_is_marked_in_dashes_that_close_evenly() -> None:
    turn = np.linspace(0.0, 2 * np.pi, 181)
    circle = 20.0 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    parts = dashes(circle)
    around = 2 * np.pi * 20.0
    assert len(parts) == round(around / (DASH + GAP))
    length = sum(float(np.linalg.norm(np.diff(part, axis=0), axis=1).sum()) for part in parts)
    assert length == pytest.approx(around * DASH / (DASH + GAP), rel=0.01)
    gaps = [np.linalg.norm(b[0] - a[-1]) for a, b in pairwise([*parts, parts[0]])]
    np.testing.assert_allclose(gaps, GAP, rtol=0.05)


@pytest.mark.parametrize("view", ["oblique", "top", "low"])
@pytest.mark.parametrize("halves", [(0.2, 0.15), (0.1, 0.2)])
def test_the_camera_holds_the_whole_region_and_not_much_more(
    cache: SkinCache, view: str, halves: tuple[float, float]
) -> None:
    field = surgical_field(cache, cache.frames)
    np.testing.assert_allclose(field.normal, UP, atol=1e-6)
    assert np.abs(field.points[:, 0]).max() < 35
    seen = viewpoint(field, view, halves)
    np.testing.assert_allclose(seen.axes @ seen.axes.T, np.eye(3), atol=1e-9)
    local = (field.points - seen.position) @ seen.axes.T
    assert (local[:, 2] < 0).all()
    ends = local[:, :2] / -local[:, 2:] / halves
    filled = np.abs(ends).max(axis=0) / FIELD_FILL
    assert filled.max() <= 1.0 + 1e-6
    assert filled.max() > 0.97
    np.testing.assert_allclose(ends.max(axis=0), -ends.min(axis=0), atol=0.02)  # in the middle of the picture


def test_normals_of_the_flat_skin_point_up() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    normals = vertex_normals(rest.astype(np.float32), triangles, origin, SKIN)
    np.testing.assert_allclose(normals[np.unique(triangles[origin == SKIN])], np.tile(UP, (546, 1)), atol=1e-6)


def test_a_flap_on_the_side_of_a_head_is_lifted_most_where_it_stands_out_most_from_the_skin_there() -> None:
    class Sideways:
        """A hook that rises along x, up to frame 9, while it goes along z; another one that is never active."""

        def hooks(self, time: float) -> Strands:
            held = [[8.0 - abs(time - 9.0), 0.0, -100.0 + 3.0 * time], [0.0, 0.0, 0.0]]
            ends = np.repeat(np.array(held, np.float32)[:, None], 2, axis=1)
            return Strands(ends, np.array([6 <= time < 14, False]))

    height = hook_height(cast(SkinSource, Sideways()), np.array([1.0, 0.0, 0.0]))
    assert height(5.0) == -np.inf
    hook, closing = StepEvent("Hook", "tip", 6, 14), StepEvent("Suture", "corner", 12, 16)
    steps = story_steps([StepEvent("Incision", "limb", 2, 2), hook, closing], [float(t) for t in range(1, 18)], height)
    assert [step.frame for step in steps if step.caption == "Lifted with hooks"] == [9.0]


def test_a_body_around_a_wound_is_shown_with_its_top_up_and_the_wound_stays_in_sight(cache: SkinCache) -> None:
    field = surgical_field(cache, cache.frames)
    own = float(np.linalg.norm(np.ptp(field.points, axis=0)))
    on_side = replace(field, normal=np.array([1.0, 0.0, 0.0]))
    tissue = np.array([[0.0, 0.0, 0.0], [0.0, 2.0 * own, 0.0]])
    wide = widened(on_side, tissue)
    np.testing.assert_allclose(wide.up, (0.0, 0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(np.cross(wide.up, wide.normal), wide.right, atol=1e-12)
    twice = 2.0**NEARER
    assert wide.context == pytest.approx(twice)
    assert wide.fill == pytest.approx((FIELD_FILL[0] / twice, FIELD_FILL[1] / twice))
    assert widened(field, 100.0 * tissue).context == pytest.approx(WIDEST**NEARER)
    assert widened(field, 0.1 * tissue).context == 1.0
    np.testing.assert_allclose(widened(field, tissue).up, (0.0, 1.0, 0.0), atol=1e-12)  # seen from above


def test_skin_of_a_body_that_faces_down_is_drawn_from_above(cache: SkinCache) -> None:
    field = surgical_field(cache, cache.frames)
    for normal, up, above in (((0.0, 0.8, -0.6), (0.0, 0.6, 0.8), True), ((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), False)):
        lid = replace(field, context=2.0, normal=np.array(normal), up=np.array(up), right=np.array([-1.0, 0.0, 0.0]))
        view = viewpoint(lid, "oblique", (0.2, 0.15))
        assert (view.axes[2][2] > normal[2]) == above  # the camera stands higher, or lower, than along the normal
        assert view.axes[1][2] > 0.5  # the patient's head is up
