"""Incisions: fragments, volumes, walls, labels and UVs of cut surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.cutting.incision import cutter
from lappet.cutting.ribbon import Ribbon
from lappet.geometry.curve import sample_curve
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Incision, Procedure
from lappet.tissue.patch import UV_SCALE, flat_patch
from refusals import refuses
from self_intersection import passes_through_itself
from surface_measures import areas, assert_closed, euler_number, heights, spherical_cap, volume

TOP = 4.0


def patch(**settings):
    return flat_patch((40.0, 30.0, TOP), resolution=2.0, **settings)


def cut(*incisions: Incision, tissue=None) -> Epoch:
    epoch = build_epochs(Procedure(tissue or patch(), events=incisions))[-1]
    assert_closed(epoch.surface)
    return epoch


def line(*points, name="cut", **settings) -> Incision:
    return Incision(name, 1.0, tuple((float(x), float(y), TOP) for x, y in points), **settings)


def circle(radius: float, count: int = 60, **settings) -> Incision:
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return line(*zip(radius * np.cos(turn), radius * np.sin(turn), strict=True), closed=True, **settings)


Z = ((8.0, 0.0), (0.0, 6.0), (0.0, -6.0), (-8.0, 0.0))
ACROSS = ((-30.0, 1.3), (30.0, 1.3))
EIGHT = tuple((9.0 * np.sin(t), 6.0 * np.sin(2.0 * t)) for t in np.linspace(0.0, 2.0 * np.pi, 80, endpoint=False))


@pytest.mark.parametrize("kerf", [0.01, 0.1, 1.0])
@pytest.mark.parametrize(
    ("incisions", "fragments"),
    [
        ([line((-10.0, 0.0), (10.0, 0.7))], 1),
        ([line(*Z)], 1),
        ([line(*ACROSS)], 2),
        ([line((-20.0, 3.0), (20.0, 3.0))], 2),
        ([line((-19.99, 3.0), (19.99, 3.0))], 2),
        ([line(*ACROSS, name="a"), line((2.0, -30.0), (2.7, 30.0), name="b")], 4),
        ([line((2.0, -20.0), (2.0, 1.3), name="b"), line(*ACROSS, name="a")], 3),
        ([line(*Z[:2], name="a"), line(*Z[1:3], name="b"), line(*Z[2:], name="c")], 1),
        ([line((-8.0, -8.0), (8.0, -8.0), (0.0, 8.0), (-8.0, -8.0))], 2),
        ([circle(8.0)], 2),
        ([circle(8.0, name="a"), circle(8.0, name="b")], 2),
        ([line(*EIGHT, closed=True)], 3),
        ([circle(9.0, name="a"), line((-12.0, 0.5), (12.0, 0.0), name="b")], 3),
    ],
    ids=[
        "inside", "Z", "across", "edge to edge", "almost to the edge", "crossing", "touching", "Z of three",
        "drawn back to its begin", "circle", "same curve twice", "figure of eight", "circle with diameter",
    ],
)  # fmt: skip
def test_the_number_of_fragments_does_not_depend_on_the_kerf(incisions, fragments, kerf):
    changed = [Incision(i.name, i.time, i.points, kerf=kerf, closed=i.closed) for i in incisions]
    assert cut(*changed).fragments == fragments


@pytest.mark.parametrize("kerf", [0.01, 0.1, 0.5])
@pytest.mark.parametrize("depth", [None, 1.5])
def test_the_volume_removed_is_length_times_depth_times_kerf(kerf, depth):
    surface = cut(line((-10.0, 0.3), (9.0, 2.0), kerf=kerf, depth=depth)).surface
    length = np.hypot(19.0, 1.7)
    removed = 40.0 * 30.0 * TOP - volume(surface)
    assert removed == pytest.approx(length * (depth or TOP) * kerf, rel=0.02)


def test_a_partial_cut_leaves_one_fragment_and_a_floor_at_its_depth():
    epoch = cut(line(*ACROSS, depth=1.5, kerf=0.2))
    assert epoch.fragments == 1
    surface = epoch.surface
    wall = surface.origin == FaceOrigin.WOUND_WALL
    corners = surface.points[surface.triangles[wall]]
    assert corners[..., 2].min() == pytest.approx(TOP - 1.5, abs=1e-9)
    floor = np.ptp(corners[..., 2], axis=1) < 1e-9
    assert areas(surface)[wall][floor].sum() == pytest.approx(40.0 * 0.2, rel=1e-3)
    assert areas(surface)[wall].sum() == pytest.approx(40.0 * (0.2 + 2 * 1.5), rel=1e-3)


def test_a_through_cut_inside_is_a_hole_and_a_partial_one_is_not():
    assert euler_number(cut().surface) == 2
    assert euler_number(cut(line((-5.0, 0.0), (5.0, 0.0))).surface) == 0
    assert euler_number(cut(line((-5.0, 0.0), (5.0, 0.0), depth=2.0)).surface) == 2


def test_walls_stand_on_the_curve_and_nowhere_else():
    surface = cut(line((-7.0, -3.0), (6.0, 5.0), kerf=0.1)).surface
    corners = surface.points[surface.triangles[surface.origin == FaceOrigin.WOUND_WALL]].reshape(-1, 3)
    along = np.array([13.0, 8.0]) / np.hypot(13.0, 8.0)
    offset = corners[:, :2] - [-7.0, -3.0]
    across = np.abs(offset @ [-along[1], along[0]])
    # Corners of less than the tidying tolerance (a tenth of the kerf) may have been merged.
    assert across.max() < 0.061
    length = np.hypot(13.0, 8.0)
    assert np.abs(offset @ along - length / 2.0).max() < length / 2.0 + 0.03
    at_ends = np.abs(offset @ along - length / 2.0) > length / 2.0 - 0.02
    assert across[~at_ends].min() > 0.039


def test_labels_survive_a_cut_and_walls_carry_none():
    uncut, surface = cut().surface, cut(line(*ACROSS, kerf=0.2)).surface
    assert areas(surface)[surface.bed].sum() == pytest.approx(40.0 * (30.0 - 0.2), rel=1e-4)
    ends = 2 * 0.2 * TOP
    assert areas(surface)[surface.fixed].sum() == pytest.approx(areas(uncut)[uncut.fixed].sum() - ends, rel=1e-4)
    wall = surface.origin == FaceOrigin.WOUND_WALL
    assert wall.any()
    assert not surface.fixed[wall].any()
    assert not surface.bed[wall].any()
    assert (surface.origin[surface.bed] == FaceOrigin.UNDERSIDE).all()
    assert (surface.origin[surface.fixed] == FaceOrigin.RIM).all()


def test_grip_subsets_ride_through_a_cut():
    tissue = patch()
    left = np.flatnonzero(tissue.points[tissue.face_vertex_indices.reshape(-1, 4), 0].max(axis=1) < -19.9)
    tissue.subsets["left"] = left.astype(np.int32)
    surface = cut(line(*ACROSS, kerf=0.2), tissue=tissue).surface
    assert areas(surface)[surface.grips["left"]].sum() == pytest.approx((30.0 - 0.2) * TOP, rel=1e-4)


def test_uvs_of_the_skin_stay_where_they_were():
    surface = cut(line(*Z, name="z"), circle(11.0, depth=2.0, kerf=0.3)).surface
    for origin in (FaceOrigin.SKIN, FaceOrigin.UNDERSIDE):
        chosen = surface.origin == origin
        expected = UV_SCALE * surface.points[surface.triangles[chosen]][..., :2]
        assert np.abs(surface.uv[chosen] - expected).max() < 5e-3 * UV_SCALE


def test_walls_have_uvs_of_arc_length_and_depth():
    surface = cut(line((-10.0, 0.0), (10.0, 0.0), kerf=0.05)).surface
    wall = surface.origin == FaceOrigin.WOUND_WALL
    points, uv = surface.points[surface.triangles[wall]], surface.uv[wall] / UV_SCALE
    assert np.abs(uv[..., 0] - (points[..., 0] + 10.0)).max() < 0.1
    assert np.abs(uv[..., 1] - (TOP - points[..., 2])).max() < 0.1


def test_no_edge_is_longer_than_two_spacings_and_the_triangles_stay_few():
    tissue = flat_patch((100.0, 80.0, 4.0), resolution=2.0, spacing=1.0)
    z = ((17.3, 0.0), (0.0, 10.0), (0.0, -10.0), (-17.3, 0.0))
    surface = cut(line(*z), tissue=tissue).surface
    corners = surface.points[surface.triangles]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    assert edges.max() < 2.0
    assert len(surface.triangles) < 60_000


@pytest.mark.parametrize("kerf", [0.01, 0.05, 0.3])
def test_no_triangle_is_flatter_than_a_twentieth_of_the_kerf(kerf):
    surface = cut(line(*Z, kerf=kerf), circle(11.0, kerf=kerf)).surface
    assert heights(surface).min() > 0.02 * kerf


@pytest.mark.parametrize("spacing", [1.0, 0.6])
@pytest.mark.parametrize("points", [Z, EIGHT])
def test_walls_have_no_edges_shorter_than_a_tenth_of_the_kerf(points, spacing: float) -> None:
    """Nor in the rows that refining makes of long triangles: there walls meet themselves with the least motion."""
    surface = cut(line(*points, kerf=0.05), tissue=patch(spacing=spacing)).surface
    corners = surface.points[surface.triangles]
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).min() >= 0.1 * 0.05


def test_a_wound_edge_is_sampled_at_the_lattice_spacing():
    surface = cut(line((-9.7, 0.9), (9.7, 0.9))).surface
    wall = surface.origin == FaceOrigin.WOUND_WALL
    corners = surface.points[surface.triangles[wall]]
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    on_top = (corners[..., 2] > TOP - 1e-6) & (np.roll(corners, -1, axis=1)[..., 2] > TOP - 1e-6)
    assert edges[on_top].max() <= 1.0 + 1e-6


def test_a_cut_through_a_curved_cap_goes_through_at_every_angle():
    tissue = spherical_cap()
    radius = 60.0
    turn = np.linspace(-0.8, 0.8, 60)
    points = tuple((radius * float(np.sin(t)), 2.0, float(radius * np.cos(t))) for t in turn)
    across = cut(Incision("a", 1.0, points, kerf=0.05), tissue=tissue)
    assert across.fragments == 2
    ring = np.linspace(0.0, 2.0 * np.pi, 50, endpoint=False)
    around = tuple((25.0 * float(np.cos(t)), 25.0 * float(np.sin(t)), float(np.sqrt(3600.0 - 625.0))) for t in ring)
    epoch = cut(Incision("a", 1.0, around, closed=True), tissue=tissue)
    assert epoch.fragments == 2


# Found by the strip of the upper eyelid: between the two lines at its tips there is less room than to which cuts are
# tidied, and on curved skin a vertex that goes over it comes to lie behind what is across.
@pytest.mark.parametrize("spacing", [1.0, 0.7])
def test_a_strip_with_fine_tips_on_a_curved_cap_does_not_pass_through_itself(spacing: float) -> None:
    along = np.linspace(0.0, 1.0, 24)
    rise = 4.0 * along * (1.0 - along)
    x = 37.0 * (along - 0.5)
    upper, lower = np.stack([x, 3.95 * rise], axis=1), np.stack([x, 0.95 * rise], axis=1)
    around = np.concatenate([upper, lower[-2:0:-1]])
    points = tuple((float(x), float(y), float(np.sqrt(3600.0 - x * x - y * y))) for x, y in around)
    strip = Incision("strip", 1.0, points, closed=True)
    surface = cut(strip, tissue=replace(spherical_cap(rings=24), spacing=spacing)).surface
    assert not passes_through_itself(surface.points, surface.triangles)


def test_the_depth_of_a_partial_cut_follows_the_normals_of_a_curved_skin():
    turn = np.linspace(-0.4, 0.4, 20)
    points = tuple((60.0 * float(np.sin(t)), 0.0, 60.0 * float(np.cos(t))) for t in turn)
    surface = cut(Incision("a", 1.0, points, depth=1.5, kerf=0.1), tissue=spherical_cap(rings=24)).surface
    wall = surface.points[surface.triangles[surface.origin == FaceOrigin.WOUND_WALL]].reshape(-1, 3)
    assert np.linalg.norm(wall, axis=1).min() == pytest.approx(58.5, abs=0.1)


@pytest.mark.parametrize("basis", ["bspline", "catmullRom", "bezier"])
def test_cubic_curves_open_and_closed_cut(basis):
    ring = [(8.0 * np.cos(t), 8.0 * np.sin(t)) for t in np.linspace(0.0, 2.0 * np.pi, 6, endpoint=False)]
    assert cut(line(*ring, basis=basis, closed=True)).fragments == 2
    wave = [(-12.0, 0.0), (-8.0, 5.0), (-4.0, -5.0), (0.0, 0.0), (4.0, 5.0), (8.0, -5.0), (12.0, 0.0)]
    assert cut(line(*wave, basis=basis)).fragments == 1


def test_cubic_samples_lie_on_the_curves_of_the_textbook():
    control = np.array([(0.0, 0.0, 0.0), (1.0, 2.0, 0.0), (3.0, 2.0, 0.0), (4.0, 0.0, 0.0)])
    bezier = sample_curve(control, "bezier", step=0.1)
    assert np.allclose(bezier[[0, -1]], control[[0, -1]])
    assert np.allclose(np.abs(bezier - [2.0, 1.5, 0.0]).sum(axis=1).min(), 0.0, atol=0.06)
    catmull = sample_curve(control, "catmullRom", step=0.1)
    assert np.allclose(catmull[[0, -1]], control[[1, 2]])
    bspline = sample_curve(control, "bspline", step=0.1)
    assert np.allclose(bspline[0], (control[0] + 4 * control[1] + control[2]) / 6.0)
    assert np.linalg.norm(np.diff(bspline, axis=0), axis=1).max() <= 0.1 + 1e-9


@pytest.mark.parametrize(
    ("incision", "code"),
    [
        (line((0.0, 0.0)), ProblemCode.CURVE_TOO_SHORT),
        (line((1.0, 1.0), (1.0, 1.0)), ProblemCode.CURVE_TOO_SHORT),
        (line((0.0, 0.0), (5.0, 0.0), closed=True), ProblemCode.CURVE_TOO_SHORT),
        (line((60.0, 0.0), (70.0, 0.0)), ProblemCode.CUT_MISSES_TISSUE),
        (Incision("cut", 1.0, ((0.0, 0.0, 4.0), (5.0, 0.0, 9.0))), ProblemCode.CUT_POINT_OFF_SKIN),
        (line((0.0, 0.0), (float("nan"), 0.0)), ProblemCode.CURVE_NOT_FINITE),
        (line((0.0, 0.0), (5.0, 0.0), kerf=0.0), ProblemCode.CUT_KERF),
        (line((0.0, 0.0), (5.0, 0.0), depth=-1.0), ProblemCode.CUT_DEPTH),
        (line((0.0, 0.0), (5.0, 0.0), (6.0, 1.0), basis="bspline"), ProblemCode.CURVE_OPEN_POINTS),
        (line((0.0, 0.0), (5.0, 0.0), (6.0, 1.0), basis="bezier"), ProblemCode.CURVE_BEZIER_POINTS),
        (line((0.0, 0.0), (5.0, 0.0), basis="nurbs"), ProblemCode.CURVE_UNKNOWN_BASIS),
    ],
)
def test_curves_that_cannot_cut_are_refused_by_name(incision, code):
    with refuses(code, "/Procedure/Timeline/cut"):
        cut(incision)


@pytest.mark.parametrize("rise", [8.0, -8.0])
def test_the_two_walls_of_a_cut_that_winds_around_a_finger_do_not_pass_through_each_other(rise: float) -> None:
    radius, count = 8.0, 20  # a helix, along which the skin's normals turn about the curve
    turn = np.linspace(0.0, 1.5, count)
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), rise * turn])
    normals = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    ahead = np.column_stack([-radius * np.sin(turn), radius * np.cos(turn), np.full(count, rise)])
    sides = np.cross(normals, ahead / np.linalg.norm(ahead, axis=1, keepdims=True))
    along = np.hypot(radius, rise) * turn
    ribbon = Ribbon(points, normals, sides, np.full(count, 4.0), along, False, float(along[-1]))
    mesh = cutter(ribbon, 0.05, 0.2, (1, 2, 3)).to_mesh64()
    assert not passes_through_itself(np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts))
