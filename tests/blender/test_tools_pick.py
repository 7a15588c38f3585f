"""Picking and drawing on the skin as it is shown: flat, deformed, cut."""

from __future__ import annotations

import time
from collections.abc import Iterator

import bpy
import numpy as np
import pytest
from mathutils import Matrix, Vector

from lappet_blender.tools import shown_surface as shown
from lappet_blender.tools import surface_trees
from lappet_blender.tools.fragment import fragment_of
from lappet_blender.tools.handles import TARGET, handles_of, nearest_handle
from lappet_blender.tools.plan_lines import plan_key
from lappet_blender.tools.plan_overlay import plan_lines
from lappet_blender.tools.rest_line import beside, line_length, rest_line, rest_samples, segment_at, world_runs
from lappet_blender.tools.skin_pick import pick_along_ray
from lappet_blender.tools.surface_ray import SurfaceBlocks, SurfaceRay
from lappet_blender.tools.view_under_mouse import nearest_on_line, project
from tool_scenes import dome_tissue, flat_tissue, solved_skin, stand_in_display


@pytest.fixture(autouse=True)
def _display(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    stand_in_display(monkeypatch)
    shown.clear_cache()
    yield
    shown.clear_cache()


def test_a_ray_on_flat_tissue_gives_the_point_it_was_aimed_at(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    for x, y in ((0.0, 0.0), (3.21, -7.77), (19.9, 19.9), (-12.5, 4.0)):
        hit = pick_along_ray(scene, (x + 5.0, y, 30.0), (-5.0, 0.0, -30.0))
        assert hit is not None
        assert np.linalg.norm(np.subtract(hit.rest, (x, y, 0.0))) < 1e-4
        assert np.allclose(hit.normal, (0, 0, 1), atol=1e-6)


def test_the_unit_of_the_scene_does_not_change_the_millimetres(scene: bpy.types.Scene) -> None:
    flat_tissue(scene, scale_length=1.0)  # metres: the tissue is 0.04 units wide
    hit = pick_along_ray(scene, (0.004, -0.003, 1.0), (0.0, 0.0, -1.0))
    assert hit is not None
    assert np.linalg.norm(np.subtract(hit.rest, (4.0, -3.0, 0.0))) < 1e-4
    assert hit.world.length == pytest.approx(0.005, abs=1e-6)


def test_a_ray_on_bent_skin_gives_the_material_point_that_was_carried_there(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    skin, bend = solved_skin(scene)
    skin.matrix_world = Matrix.Translation((100.0, 0.0, 0.0))  # as a skin that is shown beside another
    surface = shown.shown_surface(scene)
    assert surface is not None
    assert surface.solved
    # Aimed at exact places of the bent triangles, from above along a slanted ray.
    rng = np.random.default_rng(3)
    for triangle in rng.choice(np.flatnonzero(surface.rest.origin == 0), 40):
        weights = rng.dirichlet((1, 1, 1))
        corners = surface.rest.triangles[triangle]
        world, rest = weights @ surface.positions[corners], weights @ surface.rest.points[corners]
        assert np.linalg.norm(bend(rest[None])[0] + (100, 0, 0) - world) < 0.3  # it really is bent
        hit = pick_along_ray(scene, world + np.array([1.0, 2.0, 40.0]), (-1.0, -2.0, -40.0))
        assert hit is not None
        assert np.linalg.norm(np.subtract(hit.rest, rest)) < 1e-4
        assert hit.face == surface.rest.face[triangle]


def test_the_underside_and_wound_walls_are_picked_only_where_any_face_will_do(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    skin, _ = solved_skin(scene)
    below = ((-5.0, 2.0, -60.0), (0.0, 0.0, 1.0))
    assert pick_along_ray(scene, *below) is None
    hit = pick_along_ray(scene, *below, any_face=True)
    assert hit is not None
    assert hit.origin == 2
    origin = skin.data.attributes["origin"]
    origin.data.foreach_set("value", np.ones(len(skin.data.polygons), np.int32))
    shown.clear_cache()
    above = ((-5.0, 2.0, 60.0), (0.0, 0.0, -1.0))
    assert pick_along_ray(scene, *above) is None
    wall = pick_along_ray(scene, *above, any_face=True)
    assert wall is not None
    assert wall.origin == 1


def test_bed_faces_of_a_closed_tissue_are_no_skin_and_painting_them_is_noticed(scene: bpy.types.Scene) -> None:
    tissue = flat_tissue(scene)
    below = ((-5.0, 2.0, -60.0), (0.0, 0.0, 1.0))
    assert pick_along_ray(scene, *below) is not None  # nothing is marked: all is skin
    bed = tissue.data.attributes.new("lappet_bed", "BOOLEAN", "FACE")
    down = [polygon.normal.z < -0.5 for polygon in tissue.data.polygons]
    bed.data.foreach_set("value", down)
    assert pick_along_ray(scene, *below) is None


def test_nothing_is_picked_without_a_tissue_or_off_it_or_where_it_is_hidden(scene: bpy.types.Scene) -> None:
    assert pick_along_ray(scene, (0, 0, 9), (0, 0, -1)) is None
    tissue = flat_tissue(scene)
    assert pick_along_ray(scene, (50.0, 0, 9), (0, 0, -1)) is None
    tissue.hide_set(True)
    assert pick_along_ray(scene, (0, 0, 9), (0, 0, -1)) is None


def test_new_positions_of_the_same_mesh_are_noticed(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    skin, _ = solved_skin(scene)
    before = pick_along_ray(scene, (1.0, 1.0, 60.0), (0, 0, -1))
    moved = np.empty(3 * len(skin.data.vertices), np.float32)
    position = skin.data.attributes["position"].data
    position.foreach_get("vector", moved)
    position.foreach_set("vector", moved + np.tile(np.float32([0, 0, 2.5]), len(moved) // 3))
    after = pick_along_ray(scene, (1.0, 1.0, 60.0), (0, 0, -1))
    assert before is not None
    assert after is not None
    assert after.world.z - before.world.z == pytest.approx(2.5, abs=1e-4)
    assert np.allclose(after.rest, before.rest, atol=1e-4)


def test_rays_agree_with_every_triangle_tried_one_by_one() -> None:
    rng = np.random.default_rng(7)
    points, triangles = rng.normal(size=(300, 3)), rng.integers(0, 300, (700, 3)).astype(np.int32)
    ray = SurfaceRay(SurfaceBlocks(points, triangles), points)
    for _ in range(60):
        origin, way = 4.0 * rng.normal(size=3), rng.normal(size=3)
        nearest = np.inf
        for a, b, c in points[triangles]:
            matrix = np.column_stack([-way, b - a, c - a])
            if abs(np.linalg.det(matrix)) > 1e-12:
                t, u, v = np.linalg.solve(matrix, origin - a)
                if u >= 0 and v >= 0 and u + v <= 1 and t >= 0:
                    nearest = min(nearest, t)
        found = ray.first(origin, way)
        assert (found is None) == (nearest == np.inf)
        if found is not None:
            assert found[2] == pytest.approx(nearest, rel=1e-9)


def test_a_line_hugs_a_dome(scene: bpy.types.Scene) -> None:
    _, height = dome_tissue(scene)
    surface = shown.shown_surface(scene)
    assert surface is not None
    ends = np.array([[-30.0, -10.0, height(-30.0, -10.0)], [30.0, 20.0, height(30.0, 20.0)]])
    rest = surface.rest.at(rest_line(surface.rest, ends))
    assert np.abs(rest[:, 2] - height(rest[:, 0], rest[:, 1])).max() < 0.05  # the facets' sag
    chord = rest_samples(ends)
    assert np.abs(chord[:, 2] - height(chord[:, 0], chord[:, 1])).max() > 3.0  # which the chord is far from
    assert line_length(surface.rest, ends) > 1.02 * np.linalg.norm(ends[1] - ends[0])
    (run,) = world_runs(surface, chord, surface.rest.locate(chord), lift=0.2)
    assert np.abs(run[:, 2] - height(run[:, 0], run[:, 1])).max() < 0.3


def test_a_line_costs_little(scene: bpy.types.Scene) -> None:
    _, height = dome_tissue(scene, 141)  # 20 000 vertices
    surface = shown.shown_surface(scene)
    assert surface is not None
    ends = np.array([[-30.0, -10.0, height(-30.0, -10.0)], [30.0, 20.0, height(30.0, 20.0)]])
    rest_line(surface.rest, ends)  # makes the tree
    took = []
    for _ in range(7):
        begin = time.perf_counter()
        rest_line(surface.rest, ends)
        took.append(time.perf_counter() - begin)
    begin = time.perf_counter()
    SurfaceBlocks(surface.rest.points, surface.rest.triangles)  # made once an epoch: what this machine takes for it
    assert min(took) < max(0.005, 0.5 * (time.perf_counter() - begin))


def test_the_lines_beside_a_line_are_as_far_from_it_as_asked(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    surface = shown.shown_surface(scene)
    assert surface is not None
    left = beside(surface.rest, np.array([[-10.0, 0, 0], [10.0, 0, 0]]), "LINEAR", False, 0.5)
    assert np.allclose(left[:, 1], 0.5, atol=1e-9)
    circle = [[8 * np.cos(a), 8 * np.sin(a), 0] for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)]
    inner = beside(surface.rest, np.array(circle), "CATMULL_ROM", True, 1.0)
    assert np.allclose(np.linalg.norm(inner[:, :2], axis=1), 7.0, atol=0.05)


def test_a_new_point_goes_into_the_segment_it_lies_on() -> None:
    line = [(0, 0, 0), (0, 0, 0), (10, 0, 0), (10, 10, 0), (10, 10, 0)]
    assert segment_at(line, (4, 0.1, 0), False) == 2
    assert segment_at(line, (10.1, 5, 0), False) == 3
    assert segment_at(line, (-1, 0, 0), False) == 2  # never between the doubled ends
    assert segment_at([(0, 0, 0), (10, 0, 0), (10, 10, 0)], (5, 5, 0), True) == 3


def test_every_point_of_the_plan_has_a_handle_where_it_is_shown(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    _, bend = solved_skin(scene)
    events = scene.lappet.events
    cut = events.add()
    cut.uid, cut.name, cut.kind, cut.basis = "a", "incision_1", "INCISION", "CATMULL_ROM"
    for x in (-6.0, -6.0, 0.0, 6.0, 6.0):  # a smooth line: its ends are doubled
        cut.points.add().co = (x, 1.0, 0.0)
    hook = events.add()
    hook.uid, hook.name, hook.kind = "b", "hook_1", "HOOK"
    hook.points.add().co = (3.0, -4.0, 0.0)
    target = bpy.data.objects.new("target", None)
    target.location = (3.0, -4.0, 22.0)
    scene.collection.objects.link(target)
    hook.target = target
    bpy.context.view_layer.update()

    handles = handles_of(scene, 1.0)
    assert [(h.event_uid, h.index) for h in handles] == [("a", 0), ("a", 2), ("a", 3), ("b", 0), ("b", TARGET)]
    for handle in handles[:4]:
        assert (handle.world - Vector(bend(np.array([handle.rest]))[0])).length < 0.1
    assert np.allclose(handles[4].rest, (3, -4, 22))

    def from_above(places: np.ndarray) -> np.ndarray:
        return 10.0 * places[:, :2]

    anchor = handles[3].world
    mouse = (10 * anchor.x + 4, 10 * anchor.y - 3)
    assert nearest_handle(handles[:4], from_above, mouse, 12.0) is handles[3]
    assert nearest_handle(handles[:4], from_above, (mouse[0] + 30, mouse[1]), 12.0) is None
    assert nearest_handle([], from_above, mouse, 12.0) is None
    # Where two are as near, the active event's is taken.
    assert nearest_handle([handles[0], handles[3]], lambda p: 0.0 * p[:, :2], (1, 1), 12.0, "b") is handles[3]
    # A target before the anchor that it hides.
    target = next(handle for handle in handles if handle.index == TARGET)
    others = [handle for handle in handles if handle is not target]
    assert nearest_handle([*others, target], lambda p: 0.0 * p[:, :2], (1, 1), 12.0) is target


def test_points_whose_tissue_is_gone_have_no_handle(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    solved_skin(scene, keep=lambda centers: centers[:, 0] < 2.0)
    event = scene.lappet.events.add()
    event.uid, event.kind = "a", "LANDMARK"
    for x in (-5.0, 10.0):
        event.points.add().co = (x, 0.0, 0.0)
    assert [handle.index for handle in handles_of(scene, 1.0)] == [0]


def test_the_plan_is_dashed_before_its_time_and_on_both_lips_after_it(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    solved_skin(scene)
    cut = scene.lappet.events.add()
    cut.uid, cut.kind, cut.start, cut.kerf = "a", "INCISION", 10.0, 0.05
    for x in (-8.0, 8.0):
        cut.points.add().co = (x, 0.0, 0.0)
    surface = shown.shown_surface(scene)
    assert surface is not None

    def drawn() -> tuple[float, np.ndarray]:
        points = np.concatenate([p for pieces in plan_lines(scene, surface).segments.values() for p in pieces])
        return float(np.linalg.norm(points[1::2] - points[::2], axis=1).sum()), points

    scene.frame_set(1)
    dashed, _ = drawn()
    scene.frame_set(10)
    both, points = drawn()
    assert 0.4 < dashed / 16.0 < 0.75  # dashes of 1.6 mm with gaps of 1.1 mm
    assert 1.9 < both / 16.0 < 2.5
    assert (np.abs(points[:, 1]) > 0.1).all()  # beside the cut, none in it
    cut.enabled = False
    assert all(color[3] < 0.5 for color, _ in plan_lines(scene, surface).segments)


def test_the_plan_shows_every_stitch_of_a_run_and_other_ones_when_its_spacing_changes(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    edges = [[{"name": "", "co": (x, y, 0.0)} for x in (-8.0, 8.0)] for y in (0.5, -0.5)]
    bpy.ops.lappet.suture_run(first_edge=edges[0], second_edge=edges[1], spacing=4.0, start=1)
    surface = shown.shown_surface(scene)
    assert surface is not None
    (run,) = scene.lappet.events

    def across() -> list[float]:
        """Where threads run from one edge to the other."""
        pieces = [p for drawn in plan_lines(scene, surface).segments.values() for p in drawn]
        points = np.concatenate(pieces).reshape(-1, 2, 3)
        crossing = points[np.abs(points[:, 0, 1] - points[:, 1, 1]) > 0.9]
        return sorted(set(np.round(crossing[:, 0, 0], 2).tolist()))

    assert across() == [-6.0, -2.0, 2.0, 6.0]
    before = plan_key(scene)
    run.spacing = 5.0
    assert plan_key(scene) != before
    assert len(across()) == 3


def test_a_fragment_is_what_hangs_together(scene: bpy.types.Scene) -> None:
    flat_tissue(scene)
    whole = shown.shown_surface(scene)
    assert whole is not None
    assert len(fragment_of(whole.rest, 0)) == 0  # one piece: there is no fragment
    shown.clear_cache()
    solved_skin(scene, keep=lambda centers: np.abs(centers[:, 0] - 4.5) > 1.0)
    surface = shown.shown_surface(scene)
    assert surface is not None
    hit = pick_along_ray(scene, (12.0, 0.0, 60.0), (0, 0, -1))
    assert hit is not None
    held = fragment_of(surface.rest, hit.triangle)
    x = surface.rest.points[surface.rest.triangles[held]][..., 0]
    assert x.min() > 4.0
    assert len(held) == (surface.rest.points[surface.rest.triangles][..., 0].min(axis=1) > 4.0).sum()


def test_projection_agrees_with_blenders_own(scene: bpy.types.Scene) -> None:
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    camera.location = (40, -60, 50)
    camera.rotation_euler = (-camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.render.resolution_x, scene.render.resolution_y = 800, 600
    bpy.context.view_layer.update()
    window = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=800, y=600)
    matrix = window @ camera.matrix_world.inverted()
    from bpy_extras.object_utils import world_to_camera_view

    for place in ((0, 0, 0), (7, -3, 2), (-11, 8, 4)):
        expected = world_to_camera_view(scene, camera, Vector(place))
        assert np.allclose(project(matrix, 800, 600, place)[0], (800 * expected.x, 600 * expected.y), atol=0.01)
    behind = camera.matrix_world @ Vector((0, 0, 5))
    assert np.isnan(project(matrix, 800, 600, behind)).all()


def test_pulling_along_a_normal_ends_where_it_is_nearest_to_the_ray() -> None:
    place = nearest_on_line(Vector((1, 2, 0)), Vector((0, 0, 3)), Vector((11, 2, 7)), Vector((-1, 0.3, 0)))
    assert (place - Vector((1, 2, 7))).length < 1e-6
    assert nearest_on_line(Vector((1, 2, 0)), Vector((0, 0, 1)), Vector((5, 5, 5)), Vector((0, 0, -1))).z == 0


def test_a_large_surface_is_searched_as_a_small_one(scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    dome_tissue(scene, 41)
    rest = shown.shown_surface(scene).rest
    near = rest.points[::7] + np.random.default_rng(3).normal(scale=0.4, size=rest.points[::7].shape)
    small = {skin_only: rest.locate(near, skin_only) for skin_only in (True, False)}
    monkeypatch.setattr(shown, "_LARGE", 0)
    monkeypatch.setattr(surface_trees, "_PART", 300)
    large = shown.RestShape(rest.points, rest.triangles, rest.origin, rest.face)
    end = time.monotonic() + 20.0
    while not large.is_ready and time.monotonic() < end:
        time.sleep(0.01)
    assert large.is_ready
    for skin_only, located in small.items():
        found = large.locate(near, skin_only)
        assert np.allclose(large.at(found), rest.at(located), atol=1e-5)
        if skin_only:
            assert np.isin(found.triangle, rest.skin).all()
    assert (large.blocks.order == rest.blocks.order).all()
