"""What the check finds on a mesh and where; each button repairs what it says and loses neither groups nor texture."""

from __future__ import annotations

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix

from lappet.core.problem_code import ProblemCode
from lappet.tissue.surface import tissue_surface
from lappet_blender.interface.problem_repairs import repair_of
from lappet_blender.model.mesh_values import mesh_values
from lappet_blender.model.surface_border import open_edge_count
from lappet_blender.tissue.problem_places import ProblemPlace
from lappet_blender.tissue.tissue_check import check_tissue, last_check
from refusals import refusal
from tissue_scenes import add_box, add_mesh, add_sheet, fill_with_patch, read


def edit(obj: bpy.types.Object, change) -> None:  # type: ignore[no-untyped-def]
    """Changes the mesh by a function of its bmesh."""
    work = bmesh.new()
    work.from_mesh(obj.data)
    for part in (work.verts, work.edges, work.faces):
        part.ensure_lookup_table()
    change(work)
    work.to_mesh(obj.data)
    work.free()


def found(scene: bpy.types.Scene, code: ProblemCode) -> ProblemPlace:
    """The one problem of the tissue, which is of that code."""
    (place,) = check_tissue(scene).places
    assert place.problem.code is code
    return place


def kind_of(place: ProblemPlace) -> str:
    """The kind of `tissue_repair` that a problem's button calls."""
    repair = repair_of(place.problem)
    assert repair is not None
    return dict(repair.arguments)["kind"]


def held(scene: bpy.types.Scene) -> None:
    """Holds the tissue, so that the check has nothing to say about that."""
    bpy.ops.lappet.faces_assign(group="fixed", which="SIDES")


def test_a_sound_tissue_has_no_problem(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    assert check_tissue(scene).places == ()
    assert bpy.ops.lappet.tissue_check() == {"FINISHED"}


def test_a_small_hole_is_shown_at_its_edges_and_filled_without_losing_groups(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    top = int(
        np.flatnonzero((given.tissue.points[given.tissue.face_vertex_indices.reshape(-1, 4)][..., 2] > 3.9).all(1))[40]
    )
    hole = given.tissue.points[given.tissue.face_vertex_indices.reshape(-1, 4)[top]]
    edit(obj, lambda work: bmesh.ops.delete(work, geom=[work.faces[top]], context="FACES_ONLY"))
    place = found(scene, ProblemCode.MESH_OPEN)
    assert kind_of(place) == "HOLES"
    assert len(place.lines) == 4
    assert {tuple(p) for p in place.lines.reshape(-1, 3).tolist()} == {tuple(p) for p in hole.tolist()}
    assert bpy.ops.lappet.tissue_repair(kind="HOLES") == {"FINISHED"}
    assert check_tissue(scene).places == ()
    repaired = read(scene).tissue
    assert len(repaired.face_vertex_counts) == len(given.tissue.face_vertex_counts) + 1  # two triangles for a quad
    for name in ("fixed", "bed"):
        assert len(repaired.subsets[name]) == len(given.tissue.subsets[name])
    new = repaired.uv[-6:]
    at = repaired.points[repaired.face_vertex_indices[-6:]][:, :2] / 100.0
    np.testing.assert_allclose(new, at, atol=1e-6)
    tissue_surface(repaired)


def test_a_hole_as_large_as_the_mesh_is_not_filled_unless_asked(scene: bpy.types.Scene) -> None:
    obj = add_box(scene)
    edit(obj, lambda work: bmesh.ops.delete(work, geom=[work.faces[1]], context="FACES_ONLY"))
    edit(obj, lambda work: bmesh.ops.subdivide_edges(work, edges=work.edges, cuts=1, use_grid_fill=True))
    bpy.ops.lappet.tissue_set()
    large = refusal(lambda: bpy.ops.lappet.tissue_repair(kind="HOLES"))
    assert (large.code, large.prim, large.value) == (ProblemCode.HOLES_LARGE, "block", "72")
    assert open_edge_count(mesh_values(scene, obj)) == 8
    bpy.ops.lappet.tissue_repair(kind="HOLES", everything=True)
    assert open_edge_count(mesh_values(scene, obj)) == 0


def test_a_hole_in_a_sheet_is_told_and_filled_and_the_rim_stays(scene: bpy.types.Scene) -> None:
    obj = add_sheet(scene, cells=16)
    edit(obj, lambda work: bmesh.ops.delete(work, geom=[work.faces[120]], context="FACES_ONLY"))
    bpy.ops.lappet.tissue_set(thickness=3.0)
    place = found(scene, ProblemCode.SHEET_BORDERS)
    assert kind_of(place) == "HOLES"
    assert place.problem.value == "2"
    assert place.problem.severity == "warning"
    assert len(place.lines) == 4  # of the hole; the rim is as it should be
    bpy.ops.lappet.tissue_repair(kind="HOLES")
    assert open_edge_count(mesh_values(scene, obj)) == 64
    assert check_tissue(scene).places == ()


def test_two_holes_that_share_a_corner_are_both_filled(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    quads = given.tissue.face_vertex_indices.reshape(-1, 4)
    top = np.flatnonzero((given.tissue.points[quads][..., 2] > 3.9).all(1))
    middle = next(f for f in top if (np.abs(given.tissue.points[quads[f]][:, :2]) < 3.0).all())
    corner = next(f for f in top if len(np.intersect1d(quads[f], quads[middle])) == 1)

    def open_both(work: bmesh.types.BMesh) -> None:
        bmesh.ops.delete(work, geom=[work.faces[int(f)] for f in (middle, corner)], context="FACES_ONLY")

    edit(obj, open_both)
    bpy.ops.lappet.tissue_repair(kind="HOLES")
    assert open_edge_count(mesh_values(scene, obj)) == 0
    tissue_surface(read(scene).tissue)


def test_doubled_vertices_are_shown_as_a_border_and_welded(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object
    edit(
        obj,
        lambda work: bmesh.ops.split_edges(work, edges=[edge for edge in work.edges if edge.calc_face_angle(0.0) > 1]),
    )
    assert open_edge_count(mesh_values(scene, obj)) > 0
    bpy.ops.lappet.tissue_repair(kind="WELD")
    assert open_edge_count(mesh_values(scene, obj)) == 0
    repaired = read(scene).tissue
    assert len(repaired.points) == len(given.tissue.points)
    assert {name: len(faces) for name, faces in repaired.subsets.items()} == {
        name: len(faces) for name, faces in given.tissue.subsets.items()
    }


def test_a_face_without_area_is_shown_and_welded_away(scene: bpy.types.Scene) -> None:
    obj = add_box(scene)

    def collapse(work: bmesh.types.BMesh) -> None:
        bmesh.ops.subdivide_edges(work, edges=[work.edges[0]], cuts=1)
        work.verts.ensure_lookup_table()
        vertex = work.verts[-1]
        vertex.co = work.verts[0].co

    edit(obj, collapse)
    bpy.ops.lappet.tissue_set(spacing=1.0)
    held(scene)
    place = found(scene, ProblemCode.MESH_NO_AREA)
    assert kind_of(place) == "WELD"
    assert len(place.lines) >= 3
    bpy.ops.lappet.tissue_repair(kind="WELD")
    assert check_tissue(scene).places == ()
    assert len(read(scene).tissue.points) == 8


def test_turned_faces_are_shown_at_their_edges_and_turned_back(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)
    obj = scene.lappet.tissue.object

    def flip(work: bmesh.types.BMesh) -> None:
        work.faces[5].normal_flip()

    edit(obj, flip)
    place = found(scene, ProblemCode.MESH_NOT_ORIENTED)
    assert kind_of(place) == "ORIENT"
    assert len(place.lines) == 4
    bpy.ops.lappet.tissue_repair(kind="ORIENT")
    assert check_tissue(scene).places == ()
    corners = given.tissue.face_vertex_indices.reshape(-1, 4)
    np.testing.assert_array_equal(np.sort(read(scene).tissue.face_vertex_indices.reshape(-1, 4)), np.sort(corners))


def test_a_turned_face_of_a_sheet_is_told_once(scene: bpy.types.Scene) -> None:
    obj = add_sheet(scene)
    bpy.ops.lappet.tissue_set(thickness=3.0)
    edit(obj, lambda work: work.faces[20].normal_flip())
    (place,) = check_tissue(scene).places
    assert place.problem.code is ProblemCode.MESH_NOT_ORIENTED
    bpy.ops.lappet.tissue_repair(kind="ORIENT")
    assert check_tissue(scene).places == ()


def test_a_surface_inside_out_is_a_warning_that_turning_repairs(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    scene.lappet.tissue.object.data.flip_normals()
    place = found(scene, ProblemCode.MESH_INSIDE_OUT)
    assert place.problem.severity == "warning"
    assert kind_of(place) == "ORIENT"
    bpy.ops.lappet.tissue_repair(kind="ORIENT")
    assert check_tissue(scene).places == ()


def test_vertices_without_a_face_are_shown_and_removed(scene: bpy.types.Scene) -> None:
    given = fill_with_patch(scene)

    def add(work: bmesh.types.BMesh) -> None:
        one, two = work.verts.new((0.0, 0.0, 30.0)), work.verts.new((0.0, 1.0, 30.0))
        work.edges.new((one, two))

    edit(scene.lappet.tissue.object, add)
    place = found(scene, ProblemCode.MESH_LOOSE_POINTS)
    assert kind_of(place) == "LOOSE"
    assert place.problem.value == "(0, 0, 30)"
    np.testing.assert_allclose(place.points, [(0.0, 0.0, 30.0), (0.0, 1.0, 30.0)])
    bpy.ops.lappet.tissue_repair(kind="LOOSE")
    assert len(read(scene).tissue.points) == len(given.tissue.points)
    assert check_tissue(scene).places == ()


def test_a_surface_through_itself_is_shown_at_its_triangles(scene: bpy.types.Scene) -> None:
    two = [
        (low, high) for low, high in (((0.0, 0.0, 0.0), (0.02, 0.02, 0.02)), ((0.01, 0.01, 0.01), (0.03, 0.03, 0.03)))
    ]
    objects = [add_box(scene, *each, name=f"block{k}") for k, each in enumerate(two)]
    with bpy.context.temp_override(active_object=objects[0], selected_editable_objects=objects):
        bpy.ops.object.join()
    scene.lappet.tissue.object = objects[0]
    (place,) = [each for each in check_tissue(scene).places if len(each.triangles)]
    assert place.problem.code is ProblemCode.MESH_SELF_INTERSECTING
    assert len(place.triangles) == 12
    # The edges of each cube pierce three faces of the other: of these only can a triangle be.
    middles = place.triangles.reshape(-1, 3)
    assert middles.min() >= 0.0
    assert middles.max() <= 30.0


def test_where_the_tissue_is_thinner_than_a_cell_is_shown_with_its_thickness(scene: bpy.types.Scene) -> None:
    axis = np.linspace(0.0, 0.02, 11)
    wedge = [(x, y, z * (0.0005 + 0.2 * x)) for z in (0, 1) for x in axis for y in axis]  # 0.5 mm to 4.5 mm thick
    grid = [[11 * i + j, 11 * i + 11 + j, 11 * i + 12 + j, 11 * i + 1 + j] for i in range(10) for j in range(10)]
    border = [11 * i for i in range(11)] + [110 + j for j in range(1, 11)]
    border += [120 - 11 * i for i in range(1, 11)] + [10 - j for j in range(1, 10)]
    faces = [face[::-1] for face in grid] + [[v + 121 for v in face] for face in grid]
    faces += [[a, b, b + 121, a + 121] for a, b in zip(border, [*border[1:], border[0]], strict=True)]
    add_mesh(scene, "wedge", wedge, faces)
    bpy.ops.lappet.tissue_set(spacing=1.5)
    held(scene)
    (place,) = [each for each in check_tissue(scene).places if len(each.triangles)]
    assert place.problem.severity == "warning"
    middles = place.triangles.mean(axis=1)
    # Straight down or up it is 0.5 + 0.2 x mm thick, square to the slope a fiftieth less.
    assert middles[:, 0].max() < 5.3
    thick = 0.5 + 0.2 * middles[:, 0].min()
    value = float(place.problem.value.removesuffix(" mm"))
    assert 0.9 * thick < value <= thick + 0.01
    scene.lappet.tissue.spacing = 0.4
    assert [each for each in check_tissue(scene).places if len(each.triangles)] == []


def test_a_lattice_larger_than_the_memory_gets_a_spacing_that_fits(scene: bpy.types.Scene) -> None:
    add_box(scene, (0.0, 0.0, 0.0), (0.2, 0.2, 0.2))
    bpy.ops.lappet.tissue_set(spacing=0.5)
    held(scene)
    place = found(scene, ProblemCode.LATTICE_MEMORY)
    assert kind_of(place) == "SPACING"
    bpy.ops.lappet.tissue_repair(kind="SPACING")
    assert read(scene).tissue.spacing > 0.5
    assert check_tissue(scene).places == ()


def test_what_the_procedure_itself_is_wrong_about_is_found_too(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    scene.lappet.tissue.material = "silk"
    bpy.ops.lappet.faces_clear(group="fixed")
    bpy.ops.lappet.faces_clear(group="bed")
    codes = {each.code for each in check_tissue(scene).problems()}
    assert {ProblemCode.TISSUE_MATERIAL_UNKNOWN, ProblemCode.TISSUE_NOT_HELD} <= codes


def test_what_was_found_is_forgotten_when_the_tissue_changes(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    first = check_tissue(scene)
    assert last_check(scene) is first
    scene.lappet.tissue.object.data.vertices[0].co.x += 1.0
    assert last_check(scene) is None
    check_tissue(scene)
    scene.lappet.tissue.spacing = 0.7
    assert last_check(scene) is None


def test_the_cursor_goes_to_a_problem(scene: bpy.types.Scene) -> None:
    fill_with_patch(scene)
    edit(scene.lappet.tissue.object, lambda work: work.verts.new((1.0, 2.0, 30.0)))
    bpy.ops.lappet.tissue_check()
    bpy.ops.lappet.tissue_show_problem(index=0)
    assert scene.cursor.location[:] == pytest.approx((0.001, 0.002, 0.03))
    assert refusal(lambda: bpy.ops.lappet.tissue_show_problem(index=7)).code is ProblemCode.PROBLEM_UNKNOWN


def test_a_part_that_nothing_joins_is_shown_at_its_middle(scene: bpy.types.Scene) -> None:
    add_box(scene, (0.0, 0.0, 0.0), (0.02, 0.02, 0.02))
    bpy.ops.lappet.tissue_set(spacing=2.0)
    held(scene)
    away = Matrix.Translation((0.05, 0.01, 0.01))
    edit(scene.lappet.tissue.object, lambda work: bmesh.ops.create_cube(work, size=0.01, matrix=away))
    place = found(scene, ProblemCode.TISSUE_SEPARATE)
    assert place.problem.severity == "warning"
    assert place.points == pytest.approx(np.array([(50.0, 10.0, 10.0)]), abs=1e-3)
    assert place.middle() == pytest.approx((50.0, 10.0, 10.0), abs=1e-3)
