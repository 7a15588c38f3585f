"""A patch laid out in the plane: no triangle turned over, and lengths kept where the patch can be unrolled."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from face_meshes import fold, grid_triangles, nose, roll
from lappet.geometry.flatten import flatten
from lappet.geometry.injective_layout import injective_layout, signed_areas
from lappet.tissue.mesh_file import Mesh


def stretches(mesh: Mesh, layout: NDArray[np.float64]) -> NDArray[np.float64]:
    """The relative change of each edge's length."""
    following = np.roll(mesh.triangles, -1, axis=1)
    true = np.linalg.norm(mesh.points[following] - mesh.points[mesh.triangles], axis=2)
    return np.abs(np.linalg.norm(layout[following] - layout[mesh.triangles], axis=2) / true - 1.0)


@pytest.mark.parametrize("mesh", [roll(), fold()], ids=["roll", "fold"])
def test_what_can_be_unrolled_keeps_its_lengths(mesh: Mesh) -> None:
    layout = flatten(mesh.points, mesh.triangles)
    assert np.quantile(stretches(mesh, layout), 0.95) < 0.005


@pytest.mark.parametrize("noise", [0.0, 0.1], ids=["smooth", "scanned"])
def test_a_nose_s_grid_is_whole(noise: float) -> None:
    mesh = nose(noise=noise)
    layout = flatten(mesh.points, mesh.triangles)
    assert signed_areas(layout, mesh.triangles).min() > 0.0
    assert np.quantile(stretches(mesh, layout), 0.95) < 0.25


def test_a_patch_with_holes_is_laid_out_whole() -> None:
    mesh = nose()
    middle = mesh.points[mesh.triangles].mean(axis=1)
    holes = [(middle[:, 0] - x) ** 2 + (middle[:, 1] + 8.0) ** 2 < 2.5**2 for x in (-9.0, 9.0)]
    kept = mesh.part(~(holes[0] | holes[1]))
    assert signed_areas(injective_layout(kept.points, kept.triangles), kept.triangles).min() > 0.0


def test_more_than_half_of_a_ball_is_laid_out_whole_about_its_middle_and_not_mirrored() -> None:
    ball = trimesh.creation.icosphere(subdivisions=4, radius=30.0)
    cap = Mesh(np.asarray(ball.vertices), np.asarray(ball.faces, np.int64)).part(ball.triangles_center[:, 2] > -20.0)
    layout = injective_layout(cap.points, cap.triangles)
    assert signed_areas(layout, cap.triangles).min() > 0.0
    pole = layout[cap.points[:, 2].argmax()]
    rim = np.linalg.norm(layout[cap.points[:, 2] < -18.0] - pole, axis=1)
    assert np.ptp(rim) < 0.1 * rim.mean()


def test_a_layout_that_is_whole_at_once_is_left_as_the_springs_found_it() -> None:
    at = np.linspace(-10.0, 10.0, 21)
    x, y = (each.ravel() for each in np.meshgrid(at, at))
    flat = flatten(np.stack([x, y, np.zeros_like(x)], axis=1), grid_triangles(21, 21))
    assert flat == pytest.approx(np.stack([x, y], axis=1), abs=1e-6)


def test_the_second_layout_lies_as_the_first_one_does_near_the_middle() -> None:
    mesh = nose()
    layout = flatten(mesh.points, mesh.triangles)
    right, left = mesh.points[:, 0] > 30.0, mesh.points[:, 0] < -30.0
    back, front = mesh.points[:, 1] > 30.0, mesh.points[:, 1] < -30.0
    assert layout[right, 0].mean() > layout[left, 0].mean() + 40.0
    assert layout[back, 1].mean() > layout[front, 1].mean() + 40.0


def cap() -> Mesh:
    """More than half of a ball, the same from four sides: which point is nearest to its middle is left to rounding."""
    at = np.arange(-9.5, 10.0)
    x, y = (each.ravel() for each in np.meshgrid(at, at))
    away = np.maximum(np.abs(x), np.abs(y)) / 9.5
    around = np.arctan2(y, x)
    polar = 2.2 * away
    points = 30.0 * np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=1)
    return Mesh(points, grid_triangles(20, 20))


@pytest.mark.parametrize("mesh", [nose(spacing=2.0, noise=0.1), cap()], ids=["nose", "cap"])
def test_a_layout_does_not_depend_on_how_a_processor_rounds(mesh: Mesh) -> None:
    layout = flatten(mesh.points, mesh.triangles)
    noise = np.random.default_rng(3).standard_normal(mesh.points.shape)
    otherwise = flatten(mesh.points * (1.0 + 1e-14 * noise), mesh.triangles)
    assert np.abs(otherwise - layout).max() < 2e-4  # the last decimal, at most
    assert (otherwise == layout).mean() > 0.999


def test_an_injective_layout_has_the_least_energy_of_all_near_it() -> None:
    mesh = nose(spacing=4.0)
    layout = injective_layout(mesh.points, mesh.triangles)

    def energy(at: NDArray[np.float64]) -> float:
        corners, flat = mesh.points[mesh.triangles], at[mesh.triangles]
        true = corners[:, 1:] - corners[:, :1]  # edges as rows, (m, 2, 3)
        metric = true @ true.swapaxes(1, 2)
        laid = flat[:, 1:] - flat[:, :1]
        inverse = np.linalg.inv(metric)
        square = np.trace(inverse @ laid @ laid.swapaxes(1, 2), axis1=1, axis2=2)  # trace of JᵀJ
        ratio = np.linalg.det(laid) ** 2 / np.linalg.det(metric)
        return float((0.5 * np.sqrt(np.linalg.det(metric)) * square * (1.0 + 1.0 / ratio)).sum())

    least, random = energy(layout), np.random.default_rng(5)
    for size in (1e-1, 1e-2, 1e-3):
        way = size * random.standard_normal(layout.shape)
        more, less = energy(layout + way) - least, energy(layout - way) - least
        assert min(more, less) > 0.0
        if size < 0.1:
            # A slope would lower one side by what it adds to the other; this leaves the third derivative alone.
            assert abs(more - less) < 20.0 * size * (more + less)
