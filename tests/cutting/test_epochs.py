"""Epochs: order, excision, undermining, determinism and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.cutting.ribbon import Ribbon, skin_ribbons
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Excision, Incision, Procedure, Tissue, Undermine
from lappet.tissue.patch import flat_patch
from lappet.tissue.surface import tissue_surface
from refusals import refuses
from surface_measures import areas, assert_closed, spherical_cap, volume

TOP = 4.0
SIZE = (40.0, 30.0, TOP)


def ring(x: float, y: float, a: float, b: float, count: int = 40):
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return tuple((x + a * float(np.cos(t)), y + b * float(np.sin(t)), TOP) for t in turn)


def polygon_area(points) -> float:
    x, y = np.array(points)[:, 0], np.array(points)[:, 1]
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def epochs(*events, tissue: Tissue | None = None):
    found = build_epochs(Procedure(tissue or flat_patch(SIZE), events=events, end_time=100.0))
    for epoch in found:
        assert_closed(epoch.surface)
    return found


LEFT, RIGHT = ring(-10.0, 0.0, 6.0, 4.0), ring(9.0, 2.0, 5.0, 5.0)
CUT_LEFT = Incision("left", 5.0, LEFT, kerf=0.05, closed=True)
CUT_RIGHT = Incision("right", 5.0, RIGHT, kerf=0.05, closed=True)


def test_events_make_epochs_in_the_order_of_their_times():
    found = epochs(
        Incision("late", 9.0, ((-30.0, 8.0, TOP), (30.0, 8.0, TOP))),
        CUT_LEFT,
        Excision("out", 7.0, ((-10.0, 0.0, TOP),)),
        CUT_RIGHT,
    )
    assert [e.index for e in found] == [0, 1, 2, 3]
    assert [e.start_time for e in found] == [1.0, 5.0, 7.0, 9.0]
    assert [e.fragments for e in found] == [1, 3, 2, 3]
    assert volume(found[0].surface) == pytest.approx(np.prod(SIZE), rel=1e-6)


def test_events_at_the_start_belong_to_the_first_epoch():
    found = epochs(replace(CUT_LEFT, time=1.0), replace(CUT_RIGHT, time=-3.0))
    assert [(e.start_time, e.fragments) for e in found] == [(1.0, 3)]


@pytest.mark.parametrize("seeds", [[(-10.0, 0.0)], [(9.0, 2.0)], [(-10.0, 0.0), (9.0, 2.0)]])
def test_an_excision_removes_the_fragments_of_its_seeds(seeds):
    found = epochs(CUT_LEFT, CUT_RIGHT, Excision("out", 5.0, tuple((x, y, TOP) for x, y in seeds)))
    gone = sum(polygon_area(LEFT if x < 0 else RIGHT) for x, _ in seeds)
    assert found[-1].fragments == 3 - len(seeds)
    kerf = 0.05 * TOP * 2 * np.pi * 12
    assert volume(found[-1].surface) == pytest.approx(np.prod(SIZE) - TOP * gone, abs=kerf)


def test_an_excised_fragment_stays_away_in_later_epochs():
    found = epochs(
        CUT_LEFT,
        Excision("out", 5.0, ((-10.0, 0.0, TOP),)),
        Incision("late", 8.0, ((-18.0, 0.0, TOP), (18.0, 0.0, TOP)), kerf=0.02),
    )
    inside = np.linalg.norm((found[-1].surface.points[:, :2] - [-10.0, 0.0]) / [6.0, 4.0], axis=1) < 0.97
    assert not inside.any()
    assert found[-1].fragments == 1


@pytest.mark.parametrize("resolution", [1.0, 2.0, 10.0])
def test_undermining_frees_the_area_of_the_curve(resolution):
    curve = ring(1.3, -0.7, 11.0, 7.0)
    surface = epochs(Undermine("free", 3.0, curve), tissue=flat_patch(SIZE, resolution))[-1].surface
    freed = areas(surface)[(surface.origin == FaceOrigin.UNDERSIDE) & ~surface.bed].sum()
    assert freed == pytest.approx(polygon_area(curve), rel=0.01)
    assert areas(surface)[surface.bed].sum() == pytest.approx(1200.0 - freed, rel=1e-9)
    freed_points = surface.points[surface.triangles[(surface.origin == FaceOrigin.UNDERSIDE) & ~surface.bed]]
    assert np.linalg.norm((freed_points[..., :2] - [1.3, -0.7]) / [11.0, 7.0], axis=-1).max() < 1.03


# Found by the fuzz: both ends of the line met in the one sharp corner and left a hole there.
@pytest.mark.parametrize("width", [0.5, 1.0, 2.0, 8.0])
def test_a_curve_with_one_sharp_corner_parts_what_it_surrounds(width):
    wedge = ((5.0, 0.0, 2.0), (-3.0, width, 2.0), (-3.0, 0.0, 2.0))
    tissue = flat_patch((16.0, 12.0, 2.0), resolution=1.0, spacing=1.0)
    freed = epochs(Undermine("u", 1.0, wedge), tissue=tissue)[-1].surface
    area = areas(freed)[freed.resting].sum()
    assert area == pytest.approx(4.0 * width, rel=0.15)
    cut = epochs(Incision("i", 1.0, wedge, closed=True), Excision("e", 1.0, ((-2.0, 0.4 * width, 2.0),)), tissue=tissue)
    assert volume(cut[-1].surface) == pytest.approx(16 * 12 * 2 - 2 * 4.0 * width, rel=0.01)


# Found by the fuzz: no vertex of the underside lay in the area.
@pytest.mark.parametrize("radius", [0.2, 0.5, 0.9])
def test_an_area_smaller_than_the_faces_of_the_underside_is_undermined(radius):
    tissue = flat_patch((16.0, 12.0, 2.0), resolution=2.0, spacing=2.0)
    around = tuple((0.9 + x, 0.9 + y, 2.0) for x, y, _ in ring(0.0, 0.0, radius, radius, 12))
    freed = epochs(Undermine("u", 1.0, around), tissue=tissue)[-1].surface
    area = areas(freed)[freed.resting].sum()
    assert area == pytest.approx(polygon_area(around), rel=0.3)


def test_undermining_a_cut_tissue_twice_adds_up_and_ignores_the_direction():
    first, second = ring(-8.0, 0.0, 6.0, 6.0), ring(8.0, 0.0, 5.0, 5.0)[::-1]
    found = epochs(
        Incision("cut", 2.0, ((-15.0, 0.3, TOP), (15.0, 0.3, TOP)), kerf=0.02),
        Undermine("one", 3.0, first),
        Undermine("two", 4.0, second),
    )
    bed = [areas(e.surface)[e.surface.bed].sum() for e in found]
    assert bed[1] - bed[2] == pytest.approx(polygon_area(first), rel=0.02)
    assert bed[2] - bed[3] == pytest.approx(polygon_area(second), rel=0.02)


# Found by the five-flap Z-plasty of a web of the hand: what is nearest to a chord below a ridge jumps from one side of
# it to the other, the skin between stayed whole, and all of the tissue counted as inside.
def test_undermining_reaches_over_a_ridge_along_the_skin():
    radius, half = 6.0, np.radians(60.0)  # of the bend of the skin; half of the angle between its sides

    def bent(points):
        x, y, z = np.asarray(points, np.float64).T
        turn = np.clip(x / radius, -half, half)
        out, past = radius - (TOP - z), x - radius * turn
        return np.stack(
            [out * np.sin(turn) + past * np.cos(turn), y, TOP - radius + out * np.cos(turn) - past * np.sin(turn)],
            axis=1,
        )

    flat = flat_patch(SIZE, 1.0)
    corners = bent([(-12.0, -6.0, TOP), (12.0, -6.0, TOP), (12.0, 6.0, TOP), (-12.0, 6.0, TOP)])
    event = Undermine("over", 3.0, tuple(tuple(map(float, corner)) for corner in corners))
    surface = epochs(event, tissue=replace(flat, points=bent(flat.points)))[-1].surface
    freed = areas(surface)[(surface.origin == FaceOrigin.UNDERSIDE) & ~surface.bed].sum()
    assert freed == pytest.approx(12.0 * (24.0 - 2.0 * TOP * half), rel=0.03)


def test_a_curve_that_leaves_the_tissue_in_one_piece_is_refused_and_frees_nothing(monkeypatch):
    def with_a_gap(*args: object, **options: object) -> list[Ribbon]:
        return [
            replace(
                ribbon,
                closed=False,
                length=float(ribbon.along[-4]),
                **{name: getattr(ribbon, name)[:-3] for name in ("points", "normals", "sides", "depth", "along")},
            )
            for ribbon in skin_ribbons(*args, **options)
        ]

    monkeypatch.setattr("lappet.cutting.undermining.skin_ribbons", with_a_gap)
    with refuses(ProblemCode.AREA_NOT_PARTED, "/Procedure/Timeline/around"):
        epochs(Undermine("around", 5.0, RIGHT))


def test_undermining_may_reach_over_the_edge():
    curve = ((-30.0, -5.0, TOP), (0.0, -5.0, TOP), (0.0, 5.0, TOP), (-30.0, 5.0, TOP))
    surface = epochs(Undermine("free", 3.0, curve))[-1].surface
    assert areas(surface)[surface.bed].sum() == pytest.approx(1200.0 - 200.0, rel=0.01)


def test_undermining_a_curved_cap_follows_its_normals():
    polar = np.radians(25.0)
    curve = tuple(
        (60.0 * float(np.sin(polar) * np.cos(t)), 60.0 * float(np.sin(polar) * np.sin(t)), 60.0 * float(np.cos(polar)))
        for t in np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    )
    surface = epochs(Undermine("free", 3.0, curve), tissue=spherical_cap(rings=24))[-1].surface
    freed = areas(surface)[(surface.origin == FaceOrigin.UNDERSIDE) & ~surface.bed].sum()
    assert freed == pytest.approx(2.0 * np.pi * 56.0**2 * (1.0 - np.cos(polar)), rel=0.02)


def test_the_same_procedure_gives_the_same_bytes():
    events = (CUT_LEFT, Excision("out", 5.0, ((-10.0, 0.0, TOP),)), Undermine("free", 5.0, ring(0.0, 0.0, 15.0, 10.0)))
    one, two = epochs(*events), epochs(*events)
    for a, b in zip(one, two, strict=True):
        for name in ("points", "triangles", "uv", "origin", "fixed", "bed"):
            assert getattr(a.surface, name).tobytes() == getattr(b.surface, name).tobytes(), name


@pytest.mark.parametrize(
    ("events", "code"),
    [
        ([Excision("out", 5.0, ((0.0, 0.0, TOP),))], ProblemCode.EXCISION_IN_ONE_PIECE),
        ([CUT_LEFT, Excision("out", 5.0, ((0.0, 0.0, 24.0),))], ProblemCode.EXCISION_SEED_OFF_SKIN),
        ([CUT_LEFT, Excision("out", 5.0, ())], ProblemCode.EXCISION_NO_SEED),
        ([CUT_LEFT, Excision("out", 5.0, ((-10.0, 0.0, TOP), (0.0, 12.0, TOP)))], ProblemCode.EXCISION_OF_ALL),
        (
            [CUT_LEFT, Excision("first", 5.0, ((-10.0, 0.0, TOP),)), Excision("out", 6.0, ((-10.0, 0.0, TOP),))],
            ProblemCode.EXCISION_SEED_GONE,
        ),
        ([Undermine("out", 5.0, ((0.0, 0.0, TOP), (5.0, 0.0, TOP)))], ProblemCode.CURVE_TOO_SHORT),
        ([Undermine("out", 5.0, ring(90.0, 0.0, 5.0, 5.0))], ProblemCode.CUT_MISSES_TISSUE),
        (
            [Undermine("first", 5.0, ring(0.0, 0.0, 9.0, 9.0)), Undermine("out", 6.0, ring(0.0, 0.0, 6.0, 6.0))],
            ProblemCode.UNDERMINE_NO_BED,
        ),
    ],
)
def test_events_that_cannot_act_are_refused_by_name(events, code):
    with refuses(code, "/Procedure/Timeline/out"):
        epochs(*events)


def broken(change):
    tissue = flat_patch((10.0, 8.0, 2.0), triangles=True)
    points, faces = tissue.points.copy(), tissue.face_vertex_indices.reshape(-1, 3).copy()
    points, faces = change(points, faces)
    return Tissue(points, np.full(len(faces), 3, np.int32), faces.reshape(-1).astype(np.int32))


def _flip(points, faces):
    faces[7] = faces[7][::-1]
    return points, faces


def _fold(points, faces):
    """Pushes one vertex of the skin through the underside."""
    middle = int(np.linalg.norm(points - [1.0, 0.0, 2.0], axis=1).argmin())
    points[middle, 2] = -1.0
    return points, faces


def _flat(points, faces):
    points[:, 2] = 0.0
    return points, faces


def _nan(points, faces):
    points[5, 1] = np.nan
    return points, faces


@pytest.mark.parametrize(
    ("change", "code", "placed"),
    [
        (lambda p, f: (p, f[1:]), ProblemCode.MESH_OPEN, True),
        (lambda p, f: (p, np.vstack([f, f[:1]])), ProblemCode.MESH_NOT_MANIFOLD, True),
        (_flip, ProblemCode.MESH_NOT_ORIENTED, True),
        (_fold, ProblemCode.MESH_SELF_INTERSECTING, True),
        (_flat, ProblemCode.MESH_NO_VOLUME, False),
        (_nan, ProblemCode.MESH_NOT_FINITE, False),
        (lambda p, f: (p, f + 1), ProblemCode.MESH_INDEX_RANGE, False),
        (lambda p, f: (p[:0], f[:0]), ProblemCode.MESH_EMPTY, False),
    ],
)
def test_broken_surfaces_are_refused_with_the_place(change, code, placed):
    with refuses(code, "/Procedure/Tissue") as problems:
        tissue_surface(broken(change))
    found = next(each for each in problems if each.code is code)
    assert (found.place is not None) == placed
    if found.place is not None:
        assert found.place.points
        assert found.place.faces


def test_a_surface_turned_inside_out_is_turned_around():
    tissue = broken(lambda p, f: (p, f[:, ::-1]))
    assert volume(tissue_surface(tissue)) == pytest.approx(160.0)


def test_polygons_are_triangulated_without_losing_area():
    outline = np.array([(0, 0), (6, 0), (6, 2), (2, 2), (2, 5), (0, 5)], float)
    points = np.vstack([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 3.0)])
    sides = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    faces = [list(range(5, -1, -1)), list(range(6, 12)), *sides]
    tissue = Tissue(
        points, np.array([len(f) for f in faces], np.int32), np.concatenate(faces).astype(np.int32), spacing=1.0
    )
    surface = tissue_surface(tissue)
    assert_closed(surface)
    assert volume(surface) == pytest.approx(3.0 * 18.0)
    assert areas(surface).sum() == pytest.approx(2 * 18.0 + 3.0 * 22.0)
    assert (surface.origin == FaceOrigin.SKIN).all()


def test_faces_are_labeled_by_the_subsets():
    tissue = flat_patch(SIZE)
    surface = tissue_surface(tissue)
    by_origin = [areas(surface)[surface.origin == o].sum() for o in FaceOrigin]
    assert by_origin == pytest.approx([1200.0, 0.0, 1200.0, 2 * 70.0 * TOP])
    named = tissue_surface(replace(tissue, subsets={"rim": tissue.subsets["bed"], "fixed": tissue.subsets["fixed"]}))
    assert areas(named)[named.origin == FaceOrigin.RIM].sum() == pytest.approx(1200.0)
    with refuses(ProblemCode.SUBSET_INDEX_RANGE, "/Procedure/Tissue/bed"):
        tissue_surface(replace(tissue, subsets={"bed": np.array([99999], np.int32)}))
