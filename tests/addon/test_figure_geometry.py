"""The plain functions behind the pictures: fields on the skin, stitches, hooks, framing, steps."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import cast

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet_blender.figure.figure_steps import MOST_PANELS, hook_height, step_captions, story_steps
from lappet_blender.figure.framing import FIELD_FILL, surgical_field, viewpoint
from lappet_blender.figure.sheet_layout import columns_for, sheet_layout
from lappet_blender.look.dashed_line import DASH, GAP, dashes
from lappet_blender.look.hook_path import ELEVATION, hook_directions, hook_path
from lappet_blender.look.skin_fields import SKIN, WOUND_WALL, border_chains, depth_below_skin, uv_scale, vertex_normals
from lappet_blender.look.skin_read import SkinCache
from lappet_blender.look.skin_source import FigureError, SkinSource, StepEvent, Strands
from lappet_blender.look.suture_bites import BITE, Bite, Lip, bites_at, buried, find_bites, find_lip, inward
from lappet_blender.look.suture_path import THREAD_RADIUS, stitch_path
from lappet_blender.look.thread_on_skin import laid_on_skin

UP = np.array([0.0, 0.0, 1.0])


def test_a_thread_with_many_bites_lies_on_the_skin_outside_and_runs_straight_inside() -> None:
    """Over a ridge along y, 0.5 mm high and 4 mm wide: down, across, up, and back over it."""
    x, y = np.meshgrid(np.linspace(-8.0, 8.0, 65), np.linspace(-8.0, 8.0, 17), indexing="ij")
    points = np.stack([x, y, 0.5 * np.maximum(1.0 - np.abs(x) / 2.0, 0.0)], axis=-1).reshape(-1, 3)
    at = np.arange(65 * 17).reshape(65, 17)
    a, b, c, d = (each.ravel() for each in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    bites = np.array([(-4.0, 0.3, 0.0), (-4.0, 0.3, -2.0), (4.0, 0.3, -2.0), (4.0, 0.3, 0.0), (-4.0, 0.3, 0.0)])
    line = laid_on_skin(bites, points, triangles, 0.05)
    assert line[:4] == pytest.approx(bites[:4])  # nothing between them: they are inside
    over = line[4:-1]
    assert over[:, 1] == pytest.approx(0.3)
    assert over[:, 2] == pytest.approx(0.5 * np.maximum(1.0 - np.abs(over[:, 0]) / 2.0, 0.0) + 0.05, abs=0.01)
    assert (np.diff(line[3:, 0]) < 0.0).all()
    assert line[-1] == pytest.approx(bites[-1])


def test_a_thread_over_an_open_wound_runs_straight_from_edge_to_edge() -> None:
    points = np.array([(-6.0, -3.0, 0.0), (-1.0, -3.0, 0.0), (-1.0, 3.0, 0.0), (-6.0, 3.0, 0.0)])
    points = np.concatenate([points, points + np.array([7.0, 0.0, 0.0])])
    triangles = np.array([(0, 1, 2), (0, 2, 3), (4, 5, 6), (4, 6, 7)])
    line = laid_on_skin(np.array([(-2.0, 0.0, 0.0), (2.0, 0.0, 0.0), (-2.0, 1.0, 0.0)]), points, triangles, 0.05)
    gap = np.abs(line[:, 0]) < 0.99
    assert gap.any()
    assert np.abs(line[gap, 2]).max() == 0.0
    assert line[(np.abs(line[:, 0]) > 1.01) & (np.abs(line[:, 0]) < 1.99), 2] == pytest.approx(0.05)


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


def lips_apart(rest: np.ndarray, gape: float) -> np.ndarray:
    """The slit patch with its two lips `gape` mm apart, float32."""
    moved = rest.copy()
    moved[:, 1] += np.where(rest[:, 1] > 0, gape / 2, -gape / 2)
    return moved.astype(np.float32)


def stitch_across(x: float, opened: float, closed: float) -> tuple[tuple[Bite, Bite], np.ndarray]:
    """Bites of a suture at x across the slit, told apart while it gapes `opened` mm and placed at `closed` mm."""
    rest, triangles, origin = synthetic.patch(1.0, True)

    def ends(gape: float) -> np.ndarray:
        return np.array([[x, -gape / 2 - 0.1, 0.0], [x, gape / 2 + 0.1, 0.0]], np.float32)

    lips = tuple(find_lip(lips_apart(rest, opened), triangles, origin, end) for end in ends(opened))
    points = lips_apart(rest, closed)
    bites = find_bites(points, (lips[0], lips[1]), ends(closed))
    return bites, np.stack([bite.carried(points) for bite in bites])


@pytest.mark.parametrize("x", [-12.0, 0.3, 7.7])
def test_the_bites_of_a_closed_suture_lie_at_right_angles_across_the_wound_each_on_its_side(x: float) -> None:
    bites, places = stitch_across(x, 4.0, 0.02)
    np.testing.assert_allclose(places, [[x, -BITE, 0.0], [x, BITE, 0.0]], atol=0.06)
    for bite in bites:
        assert bite.weights.sum() == pytest.approx(1.0)
        assert (bite.weights >= 0).all()


def test_the_bites_of_a_suture_that_never_closes_keep_their_distance_from_each_lip() -> None:
    _, places = stitch_across(4.0, 6.0, 5.0)
    np.testing.assert_allclose(places, [[4.0, -2.6 - BITE, 0.0], [4.0, 2.6 + BITE, 0.0]], atol=0.06)


@pytest.mark.parametrize("angle", [40.0, 60.0, 90.0])
def test_a_stitch_at_a_flaps_tip_halves_the_tips_angle(angle: float) -> None:
    half = np.radians(angle / 2)
    rows = np.linspace(0.0, 5.0, 11)
    points = np.array([[r * np.sin(t), r * np.cos(t), 0.0] for r in rows for t in (-half, 0.0, half)], np.float32)
    quads = [(3 * k + j, 3 * k + j + 1, 3 * k + j + 4, 3 * k + j + 3) for k in range(10) for j in (0, 1)]
    disk = np.array([t for a, b, c, d in quads for t in ((a, c, b), (a, d, c))], np.int32)
    edges = np.array([(3 * k + j, 3 * k + j + 3) for k in range(10) for j in (0, 2)], np.int32)
    tip = Lip(disk, edges)
    into = inward(points, tip, np.zeros(3), BITE)
    np.testing.assert_allclose(into, [0.0, 1.0, 0.0], atol=1e-6)
    far = 4.0 * np.array([np.sin(half), np.cos(half), 0.0])
    across = inward(points, tip, far, 0.4)
    np.testing.assert_allclose(across, [-np.cos(half), np.sin(half), 0.0], atol=1e-3)


def test_a_suture_is_buried_where_an_end_lies_on_the_wall_in_the_depth_even_under_the_other_lip() -> None:
    rest, triangles, origin = synthetic.patch(1.0, True)
    depth = depth_below_skin(rest.astype(np.float32), triangles, origin)
    for gape in (4.0, 0.05):
        points = lips_apart(rest, gape)

        def ends(z: float, gape: float = gape) -> np.ndarray:
            return np.array([[3.0, -gape / 2, z], [3.0, gape / 2, z]], np.float32)

        assert buried(points, triangles, depth, ends(-2.8))
        assert not buried(points, triangles, depth, ends(0.0))
        assert not buried(points, triangles, depth, ends(-0.3))
    folded = lips_apart(rest, 4.0)
    folded[:, 2] += np.where(rest[:, 1] > 0, -2.8, 0.0).astype(np.float32)  # one lip's skin beside the other's wall
    deep = np.array([[3.0, -2.0, -2.8], [3.0, 2.0, -5.6]], np.float32)
    assert buried(folded, triangles, depth, deep)


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
    gaping = lips_apart(rest.astype(np.float64), 6.0)
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


@pytest.mark.parametrize("scale", [0.8, 1.6])
def test_a_tied_stitch_lies_on_the_skin_with_a_small_knot_on_one_side(scale: float) -> None:
    bites = scale * np.array([[0.0, -BITE, 0.0], [0.0, BITE, 0.0]])
    stitch = stitch_path(bites, np.zeros((2, 3)), np.stack([UP, UP]), True, scale)
    assert stitch.thread[0, 2] < 0
    assert stitch.thread[-1, 2] < 0
    assert (stitch.thread[1:-1, 2] >= THREAD_RADIUS * scale - 1e-9).all()
    assert stitch.thread[:, 2].max() < 2.2 * THREAD_RADIUS * scale  # no arc through the air
    np.testing.assert_allclose(stitch.thread[:, 0], 0.0, atol=1e-9)
    assert len(stitch.knot) == 3
    for line in stitch.knot:
        assert np.isfinite(line).all()
        assert line[:, 1].max() < 0  # beside the wound, not on it
        assert np.abs(line - bites[0]).max() < 1.6 * scale


def test_the_thread_rises_with_the_edge_of_the_wound_and_spans_an_open_gap_straight_without_a_knot() -> None:
    bites = np.array([[0.0, -BITE, 0.0], [0.0, BITE, 0.0]])
    everted = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.5]])
    assert stitch_path(bites, everted, np.stack([UP, UP]), True).thread[:, 2].max() > 0.5 + THREAD_RADIUS
    lips = np.array([[0.0, -3.0, 0.0], [0.0, 4.0, 6.0]])
    apart = stitch_path(lips + bites, lips, np.stack([UP, UP]), False)
    assert apart.knot == ()
    np.testing.assert_allclose(apart.thread[[2, 3]], lips + THREAD_RADIUS * UP)


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


def test_the_filmstrip_tells_the_operation_in_order(cache: SkinCache) -> None:
    steps = story_steps(cache.events, cache.frames, synthetic.lift)
    assert [s.caption for s in steps] == [
        "Before",
        "Incised",
        "Lifted with hooks",
        "Transposed",
        "Sutured",
        "Final result",
    ]
    assert [s.frame for s in steps] == [1, 3, 6, 7, 11, 12]
    assert steps[3].frame == max(
        f for f in cache.frames if f < min(e.start for e in cache.events if e.kind == "Suture")
    )
    assert all(a.frame < b.frame for a, b in pairwise(steps))
    assert steps[1].detail == "central limb"
    assert steps[4].detail == "4 sutures"


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


def test_a_flap_is_transposed_into_what_was_excised_and_the_edges_of_a_mere_excision_are_advanced() -> None:
    hook, closing = StepEvent("Hook", "tip", 6, 14), StepEvent("Suture", "corner", 12, 16)
    excision = [StepEvent("Incision", "defect", 2, 2), StepEvent("Excision", "defect", 4, 4)]
    frames = [float(t) for t in range(1, 18)]
    for cuts, word in ((excision, "Advanced"), ([*excision, StepEvent("Incision", "limbs", 2, 2)], "Transposed")):
        captions = [step.caption for step in story_steps([*cuts, hook, closing], frames, lambda t: -abs(t - 8.0))]
        assert captions == ["Before", "Excised", "Lifted with hooks", word, "Sutured", "Final result"]


def test_the_story_names_undermining_and_tells_buried_sutures_apart() -> None:
    events = [
        StepEvent("Incision", "limb", 2, 2),
        StepEvent("Undermine", "around", 4, 4),
        StepEvent("Hook", "tip", 6, 12),
        *[StepEvent("Suture", f"s{k}", 9, 11) for k in range(5)],
        StepEvent("Excision", "dog_ear", 13, 13),
    ]
    frames = [float(t) for t in range(1, 15)]
    steps = story_steps(events, frames, buried=2)
    assert (steps[1].caption, steps[1].detail, steps[1].frame) == (
        "Incised and undermined",
        "limb; dashed: undermined",
        5,
    )
    assert [(s.caption, s.frame) for s in steps[3:]] == [("Transposed", 8), ("Sutured", 11), ("Final result", 14)]
    assert steps[4].detail == "skin sutures over buried ones"
    assert story_steps(events, frames, buried=5)[4].detail == "5 buried sutures"


def test_the_story_of_an_excision_shows_the_hooks_at_work_and_the_wound_drawn_together() -> None:
    events = [
        StepEvent("Incision", "ellipse", 2, 2),
        StepEvent("Excision", "lesion", 3, 3),
        StepEvent("Hook", "near", 5, 10),
        *[StepEvent("Suture", f"s{k}", 6, 18) for k in range(3)],
    ]
    frames = [float(t) for t in range(1, 21)]
    steps = story_steps(events, frames, lambda t: -abs(t - 8.0))
    assert [(s.caption, s.frame) for s in steps] == [
        ("Before", 1),
        ("Excised", 4),
        ("Lifted with hooks", 8),
        ("Drawn together", 12),
        ("Sutured", 18),
        ("Final result", 20),
    ]


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
