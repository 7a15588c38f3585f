"""The picture of a mesh with what was taken of it: pixels, file and colors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from face_meshes import nose, roll
from lappet.output.mesh_picture import mesh_picture
from lappet.output.png_writer import write_png
from lappet.output.raster import rasterize
from lappet.tissue import Disc, tissue_of_mesh
from lappet.tissue.mesh_file import Mesh


def test_a_triangle_covers_the_pixels_whose_middles_lie_in_it() -> None:
    raster = rasterize(np.array([[[0.0, 0.0, 1.0], [8.0, 0.0, 1.0], [0.0, 8.0, 1.0]]]), (10, 10))
    x, y = np.meshgrid(np.arange(10) + 0.5, np.arange(10) + 0.5)
    np.testing.assert_array_equal(raster.triangle >= 0, x + y <= 8.0)
    place = raster.weights @ np.array([[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]])
    shown = raster.triangle >= 0
    assert place[shown] == pytest.approx(np.stack([x, y], axis=2)[shown])


def test_of_triangles_behind_each_other_the_nearest_is_seen_also_where_they_cross() -> None:
    level = [[0.0, 0.0, 5.0], [40.0, 0.0, 5.0], [0.0, 40.0, 5.0]]
    rising = [[0.0, 0.0, 0.0], [40.0, 0.0, 20.0], [0.0, 40.0, 0.0]]
    raster = rasterize(np.array([level, rising]), (12, 12))
    assert (raster.triangle[:, :9] == 1).all()
    assert (raster.triangle[:, 11:] == 0).all()


def test_a_png_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    picture = np.random.default_rng(0).integers(0, 256, (17, 23, 3)).astype(np.uint8)
    write_png(picture, tmp_path / "picture.png")
    np.testing.assert_array_equal(np.asarray(image.open(tmp_path / "picture.png")), picture)
    assert [file.name for file in tmp_path.iterdir()] == ["picture.png"]


def colored(picture: np.ndarray, strongest: int) -> np.ndarray:
    """Which pixels have red (0) or blue (2) as their strongest color by far."""
    other = np.delete(picture.astype(int), strongest, axis=2)
    return picture[:, :, strongest].astype(int) - other.max(axis=2) > 30


def test_what_was_taken_is_seen_in_color_in_both_views_wherever_it_lies_on_the_mesh() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=80.0)
    mesh = Mesh(np.asarray(ball.vertices), np.asarray(ball.faces, np.int64))
    for way in ((0.0, -1.0, 0.0), (0.6, 0.8, 0.0), (0.0, 0.0, 1.0)):
        tissue, _ = tissue_of_mesh(mesh, 4.0, Disc(tuple(80.0 * x for x in way), 25.0))
        picture = mesh_picture(mesh, tissue)
        red = colored(picture, 0)
        half = picture.shape[1] // 2
        # A disc of 25 mm on a mesh whose box has a half diagonal of 139 mm, then a view three times its size.
        assert red[:, :half].mean() == pytest.approx(np.pi * 0.25 * (24.6 / 138.6) ** 2, rel=0.15)
        assert red[:, half:].mean() > 0.04


def test_a_place_that_is_thin_is_blue() -> None:
    mesh = roll(radius=1.5, spacing=0.4)
    tissue, _ = tissue_of_mesh(mesh, 6.0)
    thin = colored(mesh_picture(mesh, tissue), 2)
    smooth, _ = tissue_of_mesh(nose(), 3.0)
    assert thin.mean() > 0.01
    assert not colored(mesh_picture(nose(), smooth), 2).any()
