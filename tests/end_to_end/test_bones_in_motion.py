"""Bones that move: what they press on is where it would be if the tissue had been carried against bones that stay."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from lappet import read_procedure, write_procedure
from lappet.output.solve_to_cache import solve_procedure
from lappet.procedure import Bone, Material, Procedure, Retractor
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

SPACING, FRAMES = 1.5, 4
BOX_FACES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def punch(motion: tuple[tuple[float, tuple[float, ...]], ...] = ()) -> Bone:
    """A long punch just above the skin of the block, turned in its plane."""
    corners = np.array([[x, y, z] for x in (-2.5, 2.5) for y in (-6.0, 6.0) for z in (9.1, 13.0)])
    turn = np.array([[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    return Bone("punch", corners @ turn, np.full(6, 4), BOX_FACES.ravel(), motion)


def row_motion(share: float) -> NDArray[np.float64]:
    """Down by 2 mm, aside by 1 mm, and 12° about the vertical; USD's row vectors."""
    angle = np.radians(12.0 * share)
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    matrix[3, :3] = (1.0 * share, 0.0, -2.0 * share)
    return matrix


def samples(inverse: bool) -> tuple[tuple[float, tuple[float, ...]], ...]:
    found = []
    for frame in range(1, FRAMES + 1):
        matrix = row_motion((frame - 1) / (FRAMES - 1))
        found.append((float(frame), tuple((np.linalg.inv(matrix) if inverse else matrix).ravel())))
    return tuple(found)


def block(held: str) -> Procedure:
    """A block 9 mm thick whose underside is the face subset `held`."""
    patch = flat_patch((24.0, 18.0, 9.0), resolution=1.5, gravity=0.0)
    middles = patch.points[patch.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    below = np.flatnonzero(middles[:, 2] < 1e-6).astype(np.int32)
    tissue = replace(patch, subsets={held: below}, spacing=SPACING)
    return Procedure(tissue, (Material(),), start_time=1.0, end_time=float(FRAMES))


def skin(procedure: Procedure, folder: Path) -> list[NDArray[np.float64]]:
    folder.mkdir()
    store = FrameStore(folder / "store")
    result = solve_procedure(procedure, folder / "cache.usdc", store=store, error_estimate=False)
    assert result.complete, result.reason
    stage = Usd.Stage.Open(str(folder / "cache.usdc"))
    points = UsdGeom.Mesh(stage.GetPrimAtPath("/Procedure/Skin/epoch_00")).GetPointsAttr()
    return [np.asarray(points.Get(frame), float) for frame in range(1, FRAMES + 1)]


def test_a_punch_that_moves_and_turns_presses_like_tissue_carried_against_one_that_stays(tmp_path: Path) -> None:
    moving = replace(block("fixed"), bones=(punch(samples(inverse=False)),))
    hold = Retractor("table", "table", samples(inverse=True), 1.0, FRAMES + 1.0)
    carried = replace(block("table"), bones=(punch(),), events=(hold,))
    pressed, relative = skin(moving, tmp_path / "moving"), skin(carried, tmp_path / "carried")
    matrix = row_motion(1.0)
    there = relative[-1] @ matrix[:3, :3] + matrix[3, :3]
    indented = (pressed[0] - pressed[-1])[:, 2].max()
    assert indented > 1.5
    assert np.abs(pressed[-1] - there).max() < 0.02 * indented


def test_two_spacings_in_one_frame_press_as_deep_as_in_three_frames(tmp_path: Path) -> None:
    far = np.eye(4)
    far[3, :3] = (0.0, 0.0, -3.0)
    ends = []
    for last in (2.0, 4.0):
        motion = ((1.0, tuple(np.eye(4).ravel())), (last, tuple(far.ravel())))
        rest, *_, end = skin(replace(block("fixed"), bones=(punch(motion),)), tmp_path / f"until_{last:g}")
        top = (np.linalg.norm(rest[:, :2], axis=1) < 2.0) & (rest[:, 2] > 9.0 - 1e-6)
        assert np.abs(end[top, 2] - (9.1 - 3.0)).max() < 0.15
        ends.append(end)
    assert np.abs(ends[0] - ends[1]).max() < 0.1


def test_a_moving_bone_comes_back_from_a_file_and_its_frames_from_the_store(tmp_path: Path) -> None:
    procedure = replace(block("fixed"), bones=(punch(samples(inverse=False)),))
    write_procedure(procedure, tmp_path / "punch.usda")
    read = read_procedure(tmp_path / "punch.usda")
    assert read == procedure
    store, other = FrameStore(tmp_path / "store"), FrameStore(tmp_path / "other")
    part = replace(procedure, end_time=2.0)
    assert solve_procedure(part, tmp_path / "part.usdc", store=store, error_estimate=False).complete
    resumed = solve_procedure(procedure, tmp_path / "resumed.usdc", store=store, error_estimate=False)
    fresh = solve_procedure(procedure, tmp_path / "fresh.usdc", store=other, error_estimate=False)
    assert [frame.looked_up for frame in resumed.frames] == [True, True, False, False]
    for one, other in zip(resumed.frames, fresh.frames, strict=True):
        assert np.array_equal(one.solved.points, other.solved.points)
