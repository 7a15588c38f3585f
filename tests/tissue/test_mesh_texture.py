"""Texture coordinates of the source mesh ride through refining, cropping and thickening."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from face_meshes import grid_triangles
from lappet.core.problem_code import ProblemCode
from lappet.tissue import Disc, new_tissue, tissue_of_mesh
from lappet.tissue.mesh_file import Mesh, read_mesh
from refusals import refuses


def charts(x: NDArray[np.float64], y: NDArray[np.float64], right: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Two charts of a plane, left and right of x = 0: the right one lies elsewhere and is turned."""
    left = np.stack([0.01 * x + 0.3, 0.01 * y + 0.3], axis=-1)
    return np.where(right[..., None], np.stack([0.02 * y + 3.0, -0.02 * x + 3.0], axis=-1), left)


@pytest.fixture
def skin() -> Mesh:
    at = np.arange(-30.0, 30.1, 3.0)
    x, y = (each.ravel() for each in np.meshgrid(at, at))
    triangles = grid_triangles(len(at), len(at))
    points = np.stack([x, y, np.zeros_like(x)], axis=1)
    corners = points[triangles]
    right = np.repeat(corners[:, :, 0].mean(axis=1, keepdims=True) > 0.0, 3, axis=1)
    return Mesh(points, triangles, charts(corners[..., 0], corners[..., 1], right))


def test_the_skin_s_texture_stays_where_it_was_on_both_sides_of_a_seam(skin: Mesh) -> None:
    tissue, report = tissue_of_mesh(skin, 3.0, Disc((1.0, 2.0, 0.0), 17.0), resolution=1.3, texture="mesh")
    faces = tissue.face_vertex_indices.reshape(-1, 3)
    top = np.setdiff1d(np.arange(len(faces)), np.concatenate([*tissue.subsets.values()]))
    uv, corners = tissue.uv.reshape(-1, 3, 2)[top], tissue.points[faces[top]]
    x, y = corners[..., 0], corners[..., 1]
    right = np.repeat(uv[..., 0].mean(axis=1, keepdims=True) > 1.5, 3, axis=1)
    assert 0.3 < right[:, 0].mean() < 0.7
    assert uv == pytest.approx(charts(x, y, right), abs=1e-5)
    assert report["texture"] == "the mesh's own texture coordinates"


def test_the_underside_has_the_skin_s_texture_and_the_rim_that_of_the_border_above_it(skin: Mesh) -> None:
    tissue, _ = tissue_of_mesh(skin, 3.0, Disc((-15.0, 0.0, 0.0), 10.0), texture="mesh")
    corners = tissue.points[tissue.face_vertex_indices.reshape(-1, 3)]
    expected = charts(corners[..., 0], corners[..., 1], np.zeros(corners.shape[:2], bool))
    assert tissue.uv.reshape(-1, 3, 2) == pytest.approx(expected, abs=0.01)


def test_a_usd_mesh_s_texture_coordinates_are_read_per_corner_and_per_point(tmp_path: Path) -> None:
    usd = pytest.importorskip("pxr.Usd")
    from pxr import Sdf, UsdGeom

    for kind, count in (("faceVarying", 4), ("vertex", 5)):
        stage = usd.Stage.CreateNew(str(tmp_path / f"{kind}.usda"))
        UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
        mesh = UsdGeom.Mesh.Define(stage, "/Skin")
        mesh.CreatePointsAttr([(9, 9, 9), (0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
        mesh.CreateFaceVertexCountsAttr([4])
        mesh.CreateFaceVertexIndicesAttr([1, 2, 3, 4])
        st = UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", Sdf.ValueTypeNames.TexCoord2fArray, kind)
        st.Set([(9.0, 9.0)] * (count - 4) + [(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)])
        stage.Save()
        read, _ = read_mesh(tmp_path / f"{kind}.usda", "mm")
        assert read.uv == pytest.approx(0.5 * read.points[read.triangles][:, :, :2])


def test_a_mesh_without_texture_coordinates_has_none_to_keep(tmp_path: Path) -> None:
    trimesh.creation.icosphere(subdivisions=3, radius=50.0).export(tmp_path / "ball.stl")
    with refuses(ProblemCode.MESH_NO_TEXTURE):
        new_tissue(tmp_path / "ball.stl", 3.0, at=((0.0, 0.0, 50.0), 20.0), units="mm", texture="mesh")
