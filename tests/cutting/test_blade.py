"""A blade with a direction of its own: oblique cuts, and cuts through a rolled rim."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.procedure import Incision, Point, Procedure, Tissue
from lappet.tissue.patch import flat_patch
from lappet.tissue.thicken import thicken
from refusals import refuses
from surface_measures import areas, assert_closed, volume

TOP, THICK, RADIUS, FLAT = 4.0, 3.0, 4.0, 20.0
OBLIQUE = (0.0, 1.0, -1.0)


def cut(tissue: Tissue, *points: Point, **settings) -> Epoch:
    incision = Incision("cut", 1.0, points, **settings)
    epoch = build_epochs(Procedure(tissue, events=(incision,)))[-1]
    assert_closed(epoch.surface)
    return epoch


def rolled_lip() -> Tissue:
    """A sheet that hangs down in front of y = 0 and rolls back below, like a lip: z up, y to the front, 3 mm thick."""
    across = np.linspace(-15.0, 15.0, 31)
    bend = np.linspace(0.0, 0.75 * np.pi, 19)
    profile = [(RADIUS, z) for z in np.linspace(FLAT, 1.0, 20)]
    profile += [(RADIUS * np.cos(t), -RADIUS * np.sin(t)) for t in bend]
    rows = np.array([[(x, y, z) for x in across] for y, z in profile]).reshape(-1, 3)
    width, count = len(across), len(profile)
    a = (np.arange(count - 1)[:, None] * width + np.arange(width - 1)).ravel()
    triangles = np.vstack([np.column_stack([a, a + 1, a + width]), np.column_stack([a + 1, a + width + 1, a + width])])
    corners = rows[triangles[0]]
    if np.cross(corners[1] - corners[0], corners[2] - corners[0])[1] < 0.0:
        triangles = triangles[:, ::-1]
    sheet = thicken(rows, triangles, THICK, 3, "lip")
    faces = {"rim": sheet.rim, "underside": sheet.underside, "fixed": sheet.rim, "bed": sheet.underside}
    return Tissue(
        points=sheet.points.astype(np.float32).astype(np.float64),
        face_vertex_counts=np.full(len(sheet.triangles), 3, np.int32),
        face_vertex_indices=sheet.triangles.reshape(-1).astype(np.int32),
        uv=np.zeros((3 * len(sheet.triangles), 2), np.float32),
        subsets={name: np.flatnonzero(mask).astype(np.int32) for name, mask in faces.items()},
        spacing=1.0,
    )


def down(x: float, low: float) -> tuple[Point, ...]:
    """A line on the lip's front from its upper border to a height."""
    return tuple((x, RADIUS, float(z)) for z in np.linspace(FLAT + 1.0, low, 24))


def wall_normals(epoch: Epoch) -> NDArray[np.float64]:
    surface = epoch.surface
    corners = surface.points[surface.triangles[surface.origin == FaceOrigin.WOUND_WALL]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals[np.linalg.norm(normals, axis=1) > 1e-3]


def test_the_wall_of_an_oblique_cut_lies_along_the_blade() -> None:
    epoch = cut(flat_patch((40.0, 30.0, TOP), resolution=2.0), (-8.0, 0.0, TOP), (8.0, 0.0, TOP), direction=OBLIQUE)
    normals = wall_normals(epoch)
    long = normals[np.abs(normals[:, 0]) < 0.1 * np.linalg.norm(normals, axis=1)]
    assert len(long) > 10
    np.testing.assert_allclose(long @ np.array(OBLIQUE) / np.linalg.norm(long, axis=1), 0.0, atol=1e-3)


def test_an_oblique_cut_takes_its_length_times_the_oblique_depth_times_the_kerf() -> None:
    patch, kerf = flat_patch((40.0, 30.0, TOP), resolution=2.0), 0.2
    whole = volume(cut(patch, (0.0, 0.0, TOP), (1.0, 0.0, TOP), depth=0.01, kerf=0.01).surface)
    left = volume(cut(patch, (-30.0, 0.0, TOP), (30.0, 0.0, TOP), direction=OBLIQUE, kerf=kerf).surface)
    assert whole - left == pytest.approx(40.0 * np.sqrt(2.0) * TOP * kerf, rel=0.02)


def test_a_blade_against_the_normal_cuts_as_one_without_a_direction() -> None:
    patch = flat_patch((40.0, 30.0, TOP), resolution=2.0)
    ends = (-8.0, 1.0, TOP), (8.0, 2.0, TOP)
    plain, told = cut(patch, *ends).surface, cut(patch, *ends, direction=(0.0, 0.0, -3.0)).surface
    np.testing.assert_allclose(told.points, plain.points, atol=1e-9)
    np.testing.assert_array_equal(told.triangles, plain.triangles)


@pytest.mark.parametrize("low", [-RADIUS - 1.0, -3.9])
def test_a_blade_from_the_front_parts_a_lip_over_its_rolled_border(low: float) -> None:
    """Drawn on into the air below the lip, or only to where the skin turns out of the blade's sight."""
    epoch = cut(rolled_lip(), *down(1.3, low), direction=(0.0, -1.0, 0.0))
    assert epoch.fragments == 2
    wall = areas(epoch.surface)[epoch.surface.origin == FaceOrigin.WOUND_WALL].sum()
    inner = RADIUS - THICK
    section = THICK * FLAT + 0.75 * np.pi / 2.0 * (RADIUS**2 - inner**2)
    assert wall == pytest.approx(2.0 * section, rel=0.08)  # no tissue of the section is left, on either side


def test_a_blade_that_stops_above_the_border_leaves_the_lip_whole() -> None:
    assert cut(rolled_lip(), *down(1.3, 3.0), direction=(0.0, -1.0, 0.0)).fragments == 1


@pytest.mark.parametrize(
    ("direction", "code"),
    [
        ((0.0, 0.0, 0.0), ProblemCode.CUT_DIRECTION),
        ((float("nan"), 0.0, -1.0), ProblemCode.CUT_DIRECTION),
        ((0.0, 0.0, 1.0), ProblemCode.CUT_FROM_BEHIND),
        ((0.0, 1.0, -0.1), ProblemCode.CUT_FROM_BEHIND),
    ],
)
def test_directions_that_cannot_cut_are_refused_by_name(direction: Point, code: ProblemCode) -> None:
    patch = flat_patch((40.0, 30.0, TOP), resolution=2.0)
    with refuses(code, "/Procedure/Timeline/cut"):
        cut(patch, (-8.0, 0.0, TOP), (8.0, 0.0, TOP), direction=direction)


def test_a_closed_curve_over_the_border_frees_what_it_surrounds() -> None:
    """A wedge of the lip: two lines from a point on its front that run out below it."""
    wedge = ((0.0, RADIUS, 8.0), (-3.0, RADIUS, -6.0), (3.0, RADIUS, -6.0))
    epoch = cut(rolled_lip(), *wedge, closed=True, direction=(0.0, -1.0, 0.0))
    assert epoch.fragments == 2
    whole = build_epochs(Procedure(replace(rolled_lip(), spacing=1.0)))[0]
    assert volume(epoch.surface) == pytest.approx(volume(whole.surface), rel=0.02)
