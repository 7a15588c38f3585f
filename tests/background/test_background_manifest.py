"""The manifest of a procedure: the store keeps it, and its surfaces know where on the tissue they lie."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_background_message import a_manifest, same_bits

from lappet.anatomy.tissue_layers import layer_search
from lappet.background.compilation import Compilation
from lappet.background.kept_frames import KeptFrames
from lappet.background.make_manifest import epoch_shapes
from lappet.background.manifest import EpochShape, Manifest
from lappet.background.manifest_store import get_manifest, put_manifest
from lappet.background.tissue_face import TissueFaces
from lappet.core.problem import RefusedError
from lappet.cutting.epochs import build_epochs
from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.geometry.skin_shape import depth_below_skin, uv_scale
from lappet.procedure import Hook, Incision, Procedure, Suture
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.program.settings import SolverSettings
from lappet.solve.store import FrameStore
from lappet.tissue.fan_triangles import fan_triangles
from lappet.tissue.patch import flat_patch
from small_procedure import TOP, small_procedure

SETTINGS = SolverSettings()


def silent() -> None:
    pass


def compilation(folder: Path) -> Compilation:
    return Compilation("solver", KeptFrames(folder))


@pytest.fixture(scope="module")
def manifest(tmp_path_factory: pytest.TempPathFactory) -> Manifest:
    return compilation(tmp_path_factory.mktemp("manifest")).manifest(small_procedure(), SETTINGS, silent)


def test_a_manifest_has_the_frames_and_keys_of_the_program_that_lappet_solve_makes(manifest: Manifest) -> None:
    program = compile_program(small_procedure())
    assert tuple(frame.key for frame in manifest.frames) == frame_keys(program, "solver")
    assert [frame.time for frame in manifest.frames] == list(range(1, 9))
    assert [frame.epoch for frame in manifest.frames] == [0, 0, 1, 1, 1, 1, 1, 1]
    assert [frame.hooks for frame in manifest.frames] == [(), (), (), (0,), (0,), (0,), (), ()]
    assert [frame.sutures for frame in manifest.frames] == [()] * 4 + [(0,)] * 4
    assert (manifest.hooks, manifest.sutures, manifest.landmarks) == (("hook",), ("stitch",), ("corner",))
    assert manifest.landmarks_at == ((0,), (0,))
    for shape, epoch in zip(manifest.epochs, program.epochs, strict=True):
        np.testing.assert_array_equal(shape.rest, epoch.surface.points.astype(np.float32))
        np.testing.assert_array_equal(shape.triangles, epoch.surface.triangles)
        np.testing.assert_array_equal(shape.origin, epoch.surface.origin)


def test_the_grid_of_the_skin_is_in_millimetres_along_it(manifest: Manifest) -> None:
    for shape in manifest.epochs:
        skin = shape.origin == FaceOrigin.SKIN
        along = shape.grid[skin][:, 1:] - shape.grid[skin][:, :1]
        corners = shape.rest[shape.triangles[skin]]
        length = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2)
        np.testing.assert_allclose(np.linalg.norm(along, axis=2), length, atol=0.02)  # what tidying moves a vertex by


def test_the_depth_of_a_wall_is_how_far_below_the_flat_skin_it_is(manifest: Manifest) -> None:
    shape = manifest.epochs[1]
    walls = np.unique(shape.triangles[shape.origin == FaceOrigin.WOUND_WALL])
    within = walls[np.abs(shape.rest[walls, 0]) < 4.0]  # away from where the slit ends
    assert shape.depth[within].max() > 0.9 * TOP
    assert (shape.depth[within] >= TOP - shape.rest[within, 2] - 1e-4).all()
    # The nearest vertex of the edge is at most half an edge (1.5 mm) to the side, and across the slit.
    assert (shape.depth[within] <= np.hypot(TOP - shape.rest[within, 2], 0.8) + 1e-4).all()
    assert (shape.depth[np.unique(shape.triangles[shape.origin == FaceOrigin.SKIN])] == 0.0).all()


def test_a_uv_map_in_any_unit_is_scaled_back_and_a_surface_without_skin_has_no_depth() -> None:
    rest = np.array([[0, 0, 0], [4, 0, 0], [0, 2, 0]], np.float32)
    triangles = np.array([[0, 1, 2]], np.int32)
    st = np.array([[[0, 0], [0.5, 0], [0, 0.1]]], np.float32)
    np.testing.assert_allclose(uv_scale(rest, triangles, st), [8.0, 20.0], rtol=1e-6)
    assert not depth_below_skin(rest, triangles, np.array([FaceOrigin.RIM], np.uint8)).any()


def test_each_triangle_lies_on_the_face_of_the_tissue_that_is_named() -> None:
    procedure = small_procedure()
    tissue = procedure.tissue
    shapes = epoch_shapes(build_epochs(procedure), tissue, layer_search(tissue, procedure.materials))
    fans, of_face = fan_triangles(tissue)
    for shape in shapes:
        walls = shape.origin == FaceOrigin.WOUND_WALL
        assert (shape.face[walls] == -1).all()
        assert (shape.face[~walls] >= 0).all()
        centers = shape.rest[shape.triangles].mean(axis=1)
        for face in np.unique(shape.face[~walls]):
            on = centers[shape.face == face]
            distance = ClosestPoint(tissue.points, fans[of_face == face]).query(on)[2]
            assert distance.max() < 1e-4


def test_the_nearest_face_is_found_as_the_slow_search_finds_it_near_and_far() -> None:
    tissue = flat_patch((12.0, 8.0, 2.0), resolution=1.5)
    random = np.random.default_rng(5)
    near = random.uniform([-7, -5, -1], [7, 5, 3], (300, 3))
    far = random.normal(0.0, 500.0, (20, 3))
    points = np.concatenate([near, far])
    shaken = replace(tissue, points=tissue.points + random.normal(0.0, 0.2, tissue.points.shape))
    fans = replace(
        shaken,
        face_vertex_counts=np.full(len(fan_triangles(shaken)[0]), 3),
        face_vertex_indices=fan_triangles(shaken)[0].reshape(-1),
        uv=None,
        subsets={},
    )
    expected = ClosestPoint(fans.points, fans.face_vertex_indices.reshape(-1, 3)).query(points)
    found = TissueFaces(fans).nearest(points)
    distance = [
        ClosestPoint(fans.points, fans.face_vertex_indices.reshape(-1, 3)[face : face + 1]).query(point)[2][0]
        for face, point in zip(found, points, strict=True)
    ]
    np.testing.assert_allclose(distance, expected[2], atol=1e-9)


def test_a_manifest_comes_back_from_the_store_with_every_bit(manifest: Manifest, tmp_path: Path) -> None:
    for each in (manifest, a_manifest()):
        store = FrameStore(tmp_path / each.key[:4])
        assert get_manifest(store, each.key) is None
        assert put_manifest(store, each)
        back = get_manifest(FrameStore(store.folder), each.key)
        assert same_bits(back, each)


def test_a_manifest_whose_surface_was_pruned_is_not_there(manifest: Manifest, tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    put_manifest(store, manifest)
    store.path(manifest.epochs[1].key).unlink()
    assert get_manifest(store, manifest.key) is None
    put_manifest(store, manifest)
    assert get_manifest(store, manifest.key) is not None


def test_surfaces_that_the_owner_holds_are_not_read_again(manifest: Manifest, tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    put_manifest(store, manifest)
    held: dict[str, EpochShape] = {}
    first = get_manifest(store, manifest.key, held)
    for epoch in manifest.epochs:
        store.path(epoch.key).unlink()
    again = get_manifest(store, manifest.key, held)
    assert first is not None
    assert again is not None
    assert [a is b for a, b in zip(first.epochs, again.epochs, strict=True)] == [True, True]


def test_frames_and_plans_are_not_taken_for_each_other(manifest: Manifest, tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    put_manifest(store, manifest)
    points = np.ones((2, 3), np.float32)
    store.put("ab" * 32, SolvedFrame(2.0, points))
    found = store.get("ab" * 32, SolvedFrame)
    assert found is not None
    np.testing.assert_array_equal(found.points, points)
    assert get_manifest(store, "ab" * 32) is None
    assert store.get(manifest.key, SolvedFrame) is None
    assert store.get(manifest.epochs[0].key, SolvedFrame) is None


def test_only_what_cuts_builds_epochs_again(tmp_path: Path) -> None:
    base = small_procedure()
    slit, hook, stitch, mark = base.events
    assert isinstance(hook, Hook)
    assert isinstance(slit, Incision)
    compiled = compilation(tmp_path)
    first = compiled.manifest(base, SETTINGS, silent)
    moved = replace(hook, targets=((4.0, (0.0, 2.0, TOP)), (6.0, (0.0, 5.0, TOP))))
    second = Suture("second", ((-2.0, -1.0, TOP), (-2.0, 1.0, TOP)), 6.0)
    for other in (
        replace(base, events=(slit, moved, stitch, mark)),
        base.with_events(second),
        replace(base, events=(replace(slit, name="cut"), hook, stitch, mark)),
        replace(base, tissue=replace(base.tissue, gravity=3.7)),
    ):
        manifest = compiled.manifest(other, SETTINGS, silent)
        assert manifest.key != first.key
        assert [frame.key for frame in manifest.frames] == list(frame_keys(compile_program(other), "solver"))
        assert compiled.epochs_built == 1
    for other in (
        replace(base, events=(replace(slit, kerf=0.2), hook, stitch, mark)),
        replace(base, events=(replace(slit, time=4.0), hook, stitch, mark)),
    ):
        compiled.manifest(other, SETTINGS, silent)
    compiled.manifest(base, replace(SETTINGS, spacing=1.5), silent)
    assert compiled.epochs_built == 4


def test_edits_share_the_keys_of_the_frames_before_them(tmp_path: Path) -> None:
    base = small_procedure()
    compiled = compilation(tmp_path)
    first = compiled.manifest(base, SETTINGS, silent)
    second = Suture("second", ((-2.0, -1.0, TOP), (-2.0, 1.0, TOP)), 6.0)
    edited = compiled.manifest(base.with_events(second), SETTINGS, silent)
    same = [a.key == b.key for a, b in zip(first.frames, edited.frames, strict=True)]
    assert same == [True] * 5 + [False] * 3


@pytest.mark.parametrize(
    ("change", "path", "says"),
    [
        ({"start_time": 9.0}, "/Procedure", "holds no frame"),
        (
            {"events": (Hook("h", (0.0, 90.0, TOP), ((1.0, (0.0, 0.0, 9.0)),), 1.0, 3.0),)},
            "/Procedure/Timeline/h",
            "90",
        ),
        (
            {"events": (Incision("far", 2.0, ((50.0, 0.0, TOP), (60.0, 0.0, TOP))),)},
            "/Procedure/Timeline/far",
            "mm",
        ),
    ],
)
def test_what_cannot_be_solved_is_refused_with_the_path_and_its_sentence(
    change: dict[str, object], path: str, says: str, tmp_path: Path
) -> None:
    with pytest.raises(RefusedError) as refused:
        compilation(tmp_path).manifest(small_procedure(**change), SETTINGS, silent)
    assert path in [problem.prim for problem in refused.value.problems]
    assert says in str(refused.value)


def test_all_problems_are_told_at_once_errors_first(tmp_path: Path) -> None:
    base = small_procedure()
    hook = Hook("h", (0.0, 90.0, TOP), ((1.0, (0.0, 0.0, 9.0)),), 1.0, 3.0, stiffness=-1.0)
    broken = Procedure(replace(base.tissue, spacing=-1.0), events=(hook,), end_time=4.0)
    with pytest.raises(RefusedError) as refused:
        compilation(tmp_path).manifest(broken, SETTINGS, silent)
    problems = refused.value.problems
    assert {problem.prim for problem in problems} >= {"/Procedure/Tissue", "/Procedure/Timeline/h"}
    assert [problem.severity for problem in problems] == sorted(problem.severity for problem in problems)
