"""Tissue from mesh files: units, repairs, regions, sheets and refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Tissue
from lappet.tissue.patch import UV_SCALE
from lappet.tissue.surface import tissue_surface
from lappet.tissue.tissue_from_mesh import new_tissue
from refusals import refuses
from surface_measures import areas, assert_closed, volume

RADIUS = 90.0


def save(mesh: trimesh.Trimesh, path: Path) -> Path:
    mesh.export(path)
    return path


@pytest.fixture(scope="module")
def ball(tmp_path_factory) -> Path:
    return save(trimesh.creation.icosphere(subdivisions=4, radius=RADIUS), tmp_path_factory.mktemp("mesh") / "ball.stl")


def sheet(size: float = 40.0, count: int = 20, bend: float = 0.0) -> trimesh.Trimesh:
    """A square grid, rolled to the curvature `bend` (1/mm) about y, its normals up."""
    u, v = np.meshgrid(np.linspace(-size / 2, size / 2, count + 1), np.linspace(-size / 2, size / 2, count + 1))
    u, v = u.ravel(), v.ravel()
    if bend:
        points = np.column_stack([np.sin(bend * u) / bend, v, (np.cos(bend * u) - 1.0) / bend])
    else:
        points = np.column_stack([u, v, np.zeros_like(u)])
    i = (np.arange(count)[:, None] * (count + 1) + np.arange(count)).ravel()
    quads = np.column_stack([i, i + 1, i + count + 2, i + count + 1])
    return trimesh.Trimesh(points, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), process=False)


def edges_of(tissue: Tissue, face_uv: bool):
    """Lengths of the skin's edges, in space and in the texture (mm)."""
    surface = tissue_surface(tissue)
    skin = surface.origin == FaceOrigin.SKIN
    corners = surface.uv[skin] / UV_SCALE if face_uv else surface.points[surface.triangles[skin]]
    return np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=-1)


def test_the_surface_of_a_tissue_is_made_once_and_a_fault_is_found_each_time(ball):
    tissue, _ = new_tissue(ball)
    surface = tissue_surface(tissue)
    assert tissue_surface(replace(tissue)) is surface
    wider = tissue_surface(replace(tissue, points=1.1 * tissue.points))
    assert volume(wider) == pytest.approx(1.1**3 * volume(surface), rel=1e-6)
    counts, indices = tissue.face_vertex_counts[1:], tissue.face_vertex_indices[3:]
    torn = replace(tissue, face_vertex_counts=counts, face_vertex_indices=indices, subsets={}, uv=None)
    for _ in range(2):
        with refuses(ProblemCode.MESH_OPEN):
            tissue_surface(torn)


def test_a_closed_mesh_is_taken_as_it_is(ball):
    tissue, lines = new_tissue(ball)
    surface = tissue_surface(tissue)
    assert_closed(surface)
    assert volume(surface) == pytest.approx(4.0 / 3.0 * np.pi * RADIUS**3, rel=0.01)
    assert len(surface.triangles) == 5120
    assert not tissue.subsets
    report = "\n".join(lines.lines)
    assert "5120 triangles" in report
    assert "180 x 180 x 180 mm" in report
    assert "watertight" in report
    assert "units: mm, guessed" in report
    assert "merged" in report
    assert np.array_equal(tissue.points, tissue.points.astype(np.float32))
    assert tissue.spacing == pytest.approx(4.2, abs=0.3)


@pytest.mark.parametrize("suffix", [".stl", ".obj", ".ply", ".glb"])
def test_formats_agree(tmp_path, suffix):
    mesh = trimesh.creation.box((30.0, 40.0, 50.0))
    scale = 0.001 if suffix == ".glb" else 1.0
    mesh.apply_scale(scale)
    tissue, _ = new_tissue(save(mesh, tmp_path / f"box{suffix}"), units=None if suffix == ".glb" else "mm")
    assert volume(tissue_surface(tissue)) == pytest.approx(60_000.0, rel=1e-5)


def test_a_usd_mesh_is_read_in_its_units_and_placement(tmp_path):
    Usd = pytest.importorskip("pxr.Usd")
    from pxr import Gf, UsdGeom

    stage = Usd.Stage.CreateNew(str(tmp_path / "box.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    box = trimesh.creation.box((3.0, 4.0, 5.0))
    mesh = UsdGeom.Mesh.Define(stage, "/Box")
    mesh.CreatePointsAttr(box.vertices.tolist())
    mesh.CreateFaceVertexCountsAttr([3] * 12)
    mesh.CreateFaceVertexIndicesAttr(box.faces.ravel().tolist())
    UsdGeom.XformCommonAPI(mesh).SetTranslate(Gf.Vec3d(0, 0, 10))
    stage.Save()
    tissue, lines = new_tissue(tmp_path / "box.usda")
    assert volume(tissue_surface(tissue)) == pytest.approx(60_000.0, rel=1e-5)
    assert tissue.points[:, 2].min() == pytest.approx(75.0)
    assert any("the stage says 0.01 m per unit" in line for line in lines.lines)
    stage.ClearMetadata("metersPerUnit")
    stage.Save()
    silent, lines = new_tissue(tmp_path / "box.usda")
    assert np.array_equal(silent.points, tissue.points)
    assert any("cm by USD's default, as the stage says none; --units says" in line for line in lines.lines)


@pytest.mark.parametrize(("factor", "guess"), [(0.001, "m"), (0.1, "cm"), (1 / 25.4, "in"), (1.0, "mm")])
def test_units_are_guessed_from_the_size_of_a_head(tmp_path, factor, guess):
    head = trimesh.creation.icosphere(subdivisions=2, radius=120.0 * factor)
    tissue, lines = new_tissue(save(head, tmp_path / "head.ply"))
    assert np.ptp(tissue.points[:, 2]) == pytest.approx(240.0, rel=1e-4)
    assert f"units: {guess}, guessed" in "\n".join(lines.lines)


def test_a_region_of_a_closed_surface_becomes_a_sheet_with_a_round_rim(ball):
    tissue, lines = new_tissue(ball, thickness=5.0, sphere=((0.0, 0.0, RADIUS), 50.0))
    surface = tissue_surface(tissue)
    assert_closed(surface)
    skin = surface.origin == FaceOrigin.SKIN
    assert areas(surface)[skin].sum() == pytest.approx(np.pi * 50.0**2, rel=0.01)
    under = surface.points[surface.triangles[surface.origin == FaceOrigin.UNDERSIDE]]
    assert np.linalg.norm(under, axis=-1) == pytest.approx(RADIUS - 5.0, abs=0.4)
    rim = surface.points[surface.triangles[surface.origin == FaceOrigin.RIM]].reshape(-1, 3)
    upper = rim[np.linalg.norm(rim, axis=1) > RADIUS - 0.4]
    assert np.linalg.norm(upper - [0.0, 0.0, RADIUS], axis=1) == pytest.approx(50.0, abs=1e-3)
    assert surface.fixed.sum() == (surface.origin == FaceOrigin.RIM).sum()
    assert (surface.bed == (surface.origin == FaceOrigin.UNDERSIDE)).all()
    assert tissue.spacing == pytest.approx(1.25, abs=0.06)
    assert any("thickness: 5 mm" in line for line in lines.lines)


def test_a_box_cuts_a_region_too(ball):
    tissue, _ = new_tissue(ball, thickness=4.0, box=((-30.0, -20.0, 0.0), (30.0, 20.0, 100.0)))
    surface = tissue_surface(tissue)
    assert_closed(surface)
    skin = surface.points[surface.triangles[surface.origin == FaceOrigin.SKIN]].reshape(-1, 3)
    assert skin[:, 0].min() == pytest.approx(-30.0, abs=1e-3)
    assert skin[:, 1].max() == pytest.approx(20.0, abs=1e-3)


def test_an_open_sheet_is_thickened_and_its_texture_is_in_millimetres(tmp_path):
    tissue, _ = new_tissue(save(sheet(), tmp_path / "sheet.obj"), thickness=3.0, units="mm")
    surface = tissue_surface(tissue)
    assert_closed(surface)
    assert volume(surface) == pytest.approx(40.0 * 40.0 * 3.0, rel=1e-6)
    assert surface.points[:, 2].min() == pytest.approx(-3.0)
    assert np.allclose(edges_of(tissue, True), edges_of(tissue, False), rtol=1e-3)


def test_a_rolled_sheet_flattens_without_distortion_and_a_cap_with_little(tmp_path, ball):
    rolled, _ = new_tissue(save(sheet(bend=1 / 30.0), tmp_path / "sheet.obj"), thickness=3.0, units="mm")
    ratio = edges_of(rolled, True) / edges_of(rolled, False)
    assert np.quantile(np.abs(ratio - 1.0), 0.95) < 0.02
    cap, _ = new_tissue(ball, thickness=5.0, sphere=((0.0, 0.0, RADIUS), 50.0))
    ratio = edges_of(cap, True) / edges_of(cap, False)
    assert np.quantile(np.abs(ratio - 1.0), 0.95) < 0.06
    surface = tissue_surface(cap)
    uv = surface.uv[surface.origin == FaceOrigin.SKIN]
    u, v = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    assert (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0] > 0.0).all()


def test_flipped_faces_doubles_and_small_holes_are_repaired_and_named(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=3, radius=50.0)
    faces = mesh.faces.copy()
    faces[10:40] = faces[10:40][:, ::-1]
    faces = np.vstack([faces[:500], faces[501:], faces[:1], [[3, 3, 4]]])
    broken = trimesh.Trimesh(mesh.vertices, faces, process=False)
    tissue, lines = new_tissue(save(broken, tmp_path / "broken.ply"), units="mm")
    assert_closed(tissue_surface(tissue))
    assert volume(tissue_surface(tissue)) == pytest.approx(mesh.volume, rel=1e-3)
    report = "\n".join(lines.lines)
    for words in ("flipped normals: 30 faces", "degenerate faces: 1", "doubled faces: 1", "small holes: 1 filled"):
        assert words in report


def test_a_sheet_with_a_small_hole_is_filled_and_one_with_a_large_hole_keeps_a_rim(tmp_path):
    mesh = sheet()
    middle = mesh.triangles_center
    small = trimesh.Trimesh(mesh.vertices, mesh.faces[np.abs(middle[:, :2]).max(axis=1) > 1.9], process=False)
    _, lines = new_tissue(save(small, tmp_path / "small.ply"), thickness=3.0, units="mm")
    assert any("small holes: 1 filled" in line for line in lines.lines)
    large = trimesh.Trimesh(mesh.vertices, mesh.faces[np.abs(middle[:, :2]).max(axis=1) > 9.9], process=False)
    tissue, lines = new_tissue(save(large, tmp_path / "large.ply"), thickness=3.0, units="mm")
    assert any("borders: 2" in line for line in lines.lines)
    assert volume(tissue_surface(tissue)) == pytest.approx((1600.0 - 400.0) * 3.0, rel=1e-3)


def _two_spheres() -> trimesh.Trimesh:
    one, two = (trimesh.creation.icosphere(subdivisions=2, radius=50.0) for _ in range(2))
    two.apply_translation([41.0, 3.0, 7.0])
    return trimesh.util.concatenate([one, two])


def _moebius() -> trimesh.Trimesh:
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    points = []
    for side in (-8.0, 8.0):
        r = 50.0 + side * np.cos(turn / 2.0)
        points.append(np.column_stack([r * np.cos(turn), r * np.sin(turn), side * np.sin(turn / 2.0)]))
    i = np.arange(60)
    a, b, c, d = i, (i + 1) % 60, (i + 1) % 60 + 60, i + 60
    b[-1], c[-1] = 60, 0
    return trimesh.Trimesh(
        np.vstack(points), np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])]), process=False
    )


def test_what_cannot_be_mended_is_refused_with_the_place(tmp_path, ball):
    hemisphere = trimesh.creation.icosphere(subdivisions=3, radius=50.0)
    hemisphere.update_faces(hemisphere.triangles_center[:, 2] > 0.0)
    text = tmp_path / "text.obj"
    text.write_text("nothing here\n")
    half = save(hemisphere, tmp_path / "half.ply")
    two, strip = save(_two_spheres(), tmp_path / "two.ply"), save(_moebius(), tmp_path / "strip.ply")
    creased = save(sheet(size=60.0, bend=1 / 8.0), tmp_path / "creased.ply")
    cases = [
        (lambda: new_tissue(tmp_path / "none.obj"), ProblemCode.FILE_MISSING, False),
        (lambda: new_tissue(text), None, False),
        (lambda: new_tissue(ball, units="furlong"), ProblemCode.FILE_UNKNOWN_UNITS, False),
        (lambda: new_tissue(ball, thickness=-1.0), ProblemCode.LENGTH_NOT_POSITIVE, False),
        (lambda: new_tissue(ball, spacing=0.0), ProblemCode.LENGTH_NOT_POSITIVE, False),
        (lambda: new_tissue(ball, thickness=4.0), ProblemCode.SHEET_OF_CLOSED_SURFACE, False),
        (lambda: new_tissue(half, sphere=((0, 0, 50), 20.0), units="mm"), ProblemCode.REGION_NEEDS_THICKNESS, False),
        (lambda: new_tissue(ball, 4.0, sphere=((0, 0, 300), 40.0)), ProblemCode.REGION_EMPTY, False),
        (lambda: new_tissue(ball, 4.0, sphere=((0, 0, 0), 400.0)), ProblemCode.REGION_WHOLE_SURFACE, False),
        (lambda: new_tissue(half, units="mm"), ProblemCode.MESH_LARGE_HOLE, True),
        (lambda: new_tissue(two, units="mm"), ProblemCode.MESH_SELF_INTERSECTING, True),
        (lambda: new_tissue(strip, thickness=1.0, units="mm"), ProblemCode.MESH_NOT_ORIENTED, True),
        (lambda: new_tissue(creased, thickness=6.0, units="mm"), ProblemCode.MESH_SELF_INTERSECTING, True),
        (lambda: new_tissue(ball, 4.0, at=((0, 0, 300), 40.0)), ProblemCode.REGION_POINT_OFF_SURFACE, False),
    ]
    for act, code, placed in cases:
        with pytest.raises(RefusedError) as refusal:
            act()
        (found,) = refusal.value.problems
        assert code in (None, found.code)
        assert Path(found.prim).suffix in (".obj", ".ply", ".stl")
        assert (found.place is not None and len(found.place.points) > 0) == placed


def test_the_resulting_tissue_can_be_cut(ball):
    from lappet.cutting.epochs import build_epochs
    from lappet.procedure import Incision, Procedure

    tissue, _ = new_tissue(ball, thickness=5.0, sphere=((0.0, 0.0, RADIUS), 30.0))
    points = tuple((x, 1.0, float(np.sqrt(RADIUS**2 - x**2 - 1.0))) for x in np.linspace(-40.0, 40.0, 40).tolist())
    found = build_epochs(Procedure(replace(tissue, spacing=2.0), events=(Incision("a", 2.0, points),)))
    assert [epoch.fragments for epoch in found] == [1, 2]


def test_a_region_is_refined_to_the_resolution_that_is_asked(ball):
    def skin_edges(resolution: float | None) -> float:
        region = ((0.0, 0.0, RADIUS), 25.0)
        return float(np.median(edges_of(new_tissue(ball, 5.0, sphere=region, resolution=resolution)[0], face_uv=False)))

    assert skin_edges(1.5) < 1.6 < 2.5 < skin_edges(None)


def test_a_resolution_of_nothing_is_refused(ball):
    with refuses(ProblemCode.LENGTH_NOT_POSITIVE):
        new_tissue(ball, 5.0, sphere=((0.0, 0.0, RADIUS), 25.0), resolution=0.0)
