"""The overlay of the lattice: the cells that the surface touches; how many there will be, how long they will take."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from lappet_blender.interface.duration_text import duration_text
from lappet_blender.model.decimals import decimal
from lappet_blender.tissue import expected_time
from lappet_blender.tissue.expected_time import cell_count, expected_seconds
from lappet_blender.tissue.lattice_lines import MOST_LINES, box_lines, cell_lines, lattice_lines, touched_cells
from lappet_blender.tissue.overlay import _lattice_batches, lattice_of
from tissue_scenes import add_box, add_sheet, fill_with_patch

SQUARE = np.array([[0.1, 0.1, 0.5], [9.9, 0.1, 0.5], [9.9, 9.9, 0.5], [0.1, 9.9, 0.5]])
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def test_a_square_of_10_mm_touches_100_cells_of_1_mm_and_they_have_341_edges(scene: bpy.types.Scene) -> None:
    cells = touched_cells(SQUARE, TWO, 1.0)
    assert {tuple(cell) for cell in cells.tolist()} == {(i, j, 0) for i in range(10) for j in range(10)}
    lines = cell_lines(cells, 1.0)
    assert len(lines) == 2 * 2 * 10 * 11 + 11 * 11  # along x and y on two levels, and upright
    np.testing.assert_allclose(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1), 1.0)
    assert len(np.unique(lines.reshape(-1, 6), axis=0)) == len(lines)


def test_every_cell_that_a_slanted_triangle_passes_well_through_is_there(scene: bpy.types.Scene) -> None:
    rng = np.random.default_rng(5)
    corners = rng.uniform(-20.0, 20.0, (3, 3))
    cells = {tuple(cell) for cell in touched_cells(corners, np.array([[0, 1, 2]]), 1.0).tolist()}
    weights = rng.dirichlet((1.0, 1.0, 1.0), 50_000)
    inside = weights @ corners
    deep = (np.abs(inside - np.floor(inside) - 0.5) < 0.2).all(axis=1)  # near the middle of a cell
    assert deep.sum() > 1000
    assert {tuple(cell) for cell in np.floor(inside[deep]).astype(int).tolist()} <= cells
    low, high = np.floor(corners.min(axis=0)), np.floor(corners.max(axis=0))
    assert all((low <= cell).all() and (cell <= high).all() for cell in map(np.array, cells))


def test_a_lattice_too_fine_to_draw_becomes_the_grid_on_its_box(scene: bpy.types.Scene) -> None:
    lines = lattice_lines(SQUARE, TWO, 0.01)
    assert len(lines) <= MOST_LINES
    np.testing.assert_array_equal(lines, box_lines(SQUARE, 0.01))
    np.testing.assert_allclose(lines.reshape(-1, 3).min(axis=0), (0.1, 0.1, 0.5), atol=0.011)
    np.testing.assert_allclose(lines.reshape(-1, 3).max(axis=0), (9.9, 9.9, 0.5), atol=0.011)


def test_the_overlay_is_that_of_the_scene_and_its_spacing(scene: bpy.types.Scene) -> None:
    assert lattice_of(scene).shape == (0, 2, 3)  # which Blender cannot draw: the overlay leaves it out
    assert _lattice_batches(scene, 1.0) == []
    fill_with_patch(scene)
    coarse = lattice_of(scene)
    points = scene.lappet.tissue.object.data.vertices
    low = np.min([vertex.co for vertex in points], axis=0)
    assert (coarse.reshape(-1, 3).min(axis=0) <= low + 1e-6).all()
    assert (coarse.reshape(-1, 3).min(axis=0) > low - 1.001).all()
    scene.lappet.tissue.spacing = 0.5
    assert len(lattice_of(scene)) > 3 * len(coarse)


def test_the_cell_count_of_a_block_is_its_volume_and_the_cells_at_its_skin(scene: bpy.types.Scene) -> None:
    assert cell_count(scene) is None
    add_box(scene, (0.0, 0.0, 0.0), (0.04, 0.03, 0.02))
    bpy.ops.lappet.tissue_set(spacing=1.0)
    # The estimate of the daemon: volume and half of the projected area of all faces, each counted from both sides.
    assert cell_count(scene) == pytest.approx(40 * 30 * 20, rel=0.2)
    coarse = cell_count(scene)
    scene.lappet.tissue.spacing = 0.5
    assert cell_count(scene) == pytest.approx(8 * coarse, rel=0.1)


def test_the_expected_time_grows_with_cells_and_frames_by_the_rate_of_earlier_solves(
    scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch
) -> None:

    class Rate:
        """A speed estimate of 2 µs a cell."""

        def seconds(self, cells: float) -> float:
            return 2e-6 * cells

    monkeypatch.setattr(expected_time, "speed_estimate", Rate)
    assert expected_seconds(scene) is None
    fill_with_patch(scene)
    assert expected_seconds(scene) == pytest.approx(2e-6 * cell_count(scene) * 10)
    scene.frame_end = 30
    assert expected_seconds(scene) == pytest.approx(2e-6 * cell_count(scene) * 30)


@pytest.mark.parametrize(
    ("seconds", "words"), [(0.2, "about 1 s"), (89.0, "about 89 s"), (200.0, "about 3 min"), (9000.0, "about 2.5 h")]
)
def test_durations_are_told_as_people_say_them(seconds: float, words: str) -> None:
    assert duration_text(seconds) == words


def test_a_thickened_surface_is_measured_as_the_sheet_that_it_becomes(scene: bpy.types.Scene) -> None:
    add_sheet(scene)
    bpy.ops.lappet.tissue_set(thickness=4.0, spacing=1.0)
    assert cell_count(scene) == pytest.approx(20 * 20 * 4, rel=0.5)
    heights = lattice_of(scene).reshape(-1, 3)[:, 2]
    assert heights.min() <= -4.0
    assert decimal(scene.lappet.tissue.thickness) == 4.0
