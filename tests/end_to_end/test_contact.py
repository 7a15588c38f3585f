"""A patch of skin drawn across a dome of bone, from the procedure through the real daemon to its skin cache."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from lappet.core.problem import RefusedError
from lappet.output.report import report
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Bone, Hook, Material, Procedure
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

RADIUS, SPACING = 25.0, 1.5  # mm
MIDDLE = np.array([0.0, 0.0, -RADIUS - 0.3])
SAGITTA = 0.02  # mm by which the dome's triangles lie inside the sphere


def dome(lift: float = 0.0) -> Bone:
    ball = trimesh.creation.icosphere(subdivisions=5, radius=RADIUS)
    return Bone("dome", ball.vertices + MIDDLE + (0, 0, lift), np.full(len(ball.faces), 3), ball.faces.ravel())


def drawn_across(*bones: Bone) -> Procedure:
    """A patch held along x = -24, its free end drawn down and to the side by two hooks; frames 1 to 7."""
    patch = flat_patch((48.0, 24.0, 3.0), resolution=1.5, gravity=0.0)
    middles = patch.points[patch.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    held = np.flatnonzero(middles[:, 0] < -24.0 + 1e-9).astype(np.int32)
    tissue = replace(patch, subsets={"fixed": held}, spacing=SPACING)
    hooks = tuple(
        Hook(
            name,
            (22.5, y, 3.0),
            ((1.0, (22.5, y, 3.0)), (5.0, (19.0, y, -14.0)), (7.0, (18.0, y + 4.0, -15.0))),
            1.0,
            8.0,
            60.0,
        )
        for name, y in (("left", -7.5), ("right", 7.5))
    )
    return Procedure(tissue, (Material(),), hooks, bones=bones, start_time=1.0, end_time=7.0)


def solved(procedure: Procedure, folder: Path) -> tuple[SolveResult, list[NDArray[np.float64]]]:
    """The solve and the skin's points per frame, as the cache holds them."""
    cache = folder / "cache.usdc"
    result = solve_procedure(procedure, cache, store=FrameStore(folder / "store"), error_estimate=False)
    assert result.complete, result.reason
    stage = Usd.Stage.Open(str(cache))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/Procedure/Skin/epoch_00")).GetPointsAttr()
    return result, [np.asarray(points.Get(time), float) for time in range(1, 8)]


def depths(frames: list[NDArray[np.float64]]) -> list[float]:
    """How deep the deepest point of each frame is in the sphere, mm."""
    return [float(RADIUS - np.linalg.norm(points - MIDDLE, axis=1).min()) for points in frames]


def test_a_patch_drawn_across_a_dome_slides_on_it_and_does_not_enter(tmp_path: Path) -> None:
    result, frames = solved(drawn_across(dome()), tmp_path)
    values = report(result)
    assert values["scene_profile"]["contact"] is True
    told = [frame["largest_penetration_mm"] for frame in values["frames"]]
    assert max(depths(frames)) < 0.1 * SPACING
    assert max(told) < 0.1 * SPACING
    for depth, said in zip(depths(frames), told, strict=True):
        assert said == pytest.approx(max(depth, 0.0), abs=SAGITTA + 0.01 * SPACING)
    assert values["frames"][-1]["contacts"] > 50
    # From frame 5 on the hooks draw it sideways: what lies on the top of the dome slides along.
    rest = result.program.epochs[0].surface.points
    on_top = int(np.linalg.norm(rest - (6.0, 0.0, 0.0), axis=1).argmin())
    slide = frames[6][on_top] - frames[4][on_top]
    normal = (frames[6][on_top] - MIDDLE) / np.linalg.norm(frames[6][on_top] - MIDDLE)
    assert slide[1] > 0.3
    assert abs(slide @ normal) < 0.1 * np.linalg.norm(slide)


def test_without_the_bone_it_would_enter(tmp_path: Path) -> None:
    result, frames = solved(drawn_across(), tmp_path)
    values = report(result)
    assert values["scene_profile"]["contact"] is False
    assert all(frame["contacts"] == 0 and frame["largest_penetration_mm"] == 0.0 for frame in values["frames"])
    assert depths(frames)[-1] > 2.0


def test_tissue_that_starts_deep_in_bone_is_refused_with_the_depth_and_the_repair(tmp_path: Path) -> None:
    with pytest.raises(RefusedError, match=r"dome.*reach 1\.[67]\d* mm into each other.*Move them apart"):
        solve_procedure(drawn_across(dome(2.0)), tmp_path / "c.usdc", store=FrameStore(tmp_path / "store"))
