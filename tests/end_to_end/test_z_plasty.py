"""The bundled Z-plasty, from its file through the real daemon: closed, flat, transposed, lengthened."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Usd, UsdGeom

from lappet.daemon.daemon_solver import connect_to
from lappet.demo import z_plasty
from lappet.output.report import report
from lappet.output.solve_to_cache import solve_procedure
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.reports.error_time.measurement import DEFAULT, skin_of
from lappet.reports.error_time.procedure_scenes import z_plasty_scene
from lappet.reports.error_time.reference import greatest, rms
from lappet.solve.coarse_program import coarse_program, expected_order
from lappet.solve.error_estimate import RestSkin, frame_error
from lappet.solve.solve_frames import FrameResult, SolveObserver, solve_program
from lappet.solve.store import FrameStore
from z_plasty_truth import kept_truth

THICKNESS = 4.0  # mm


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_z_plasty_closes_lies_flat_and_turns_its_limb_by_90_degrees(tmp_path: Path) -> None:
    cache = tmp_path / "z_plasty.usdc"
    # At 1.25 mm, with nearly twice as many cells, all that is asserted is the same within a tenth of its bound.
    settings, store = SolverSettings(spacing=1.5), FrameStore(tmp_path / "store")
    result = solve_procedure(z_plasty(), cache, settings, store=store, error_estimate=False)
    assert result.complete, result.reason
    values = report(result)
    frames = values["frames"]
    first, last = frames[0], frames[-1]
    assert 10_000 < values["lattice"]["cells"] < 12_000
    assert all(frame["converged"] and frame["residual"] <= 1e-3 for frame in frames)
    assert sum(frame["inverted_cells"] for frame in frames) == 0
    assert last["minimum_j"] > 0.5
    assert max(last["suture_gaps_mm"].values()) < 0.1

    def at(frame: dict, label: str) -> np.ndarray:
        return np.array([frame["landmarks"][f"{label} {k}"] for k in (1, 2)])

    # The central limb ran along x; the new one, from tip to tip, runs along y: 60° flaps turn it by 90°.
    tips = at(last, "flap tip")
    limb = tips[1] - tips[0]
    assert np.degrees(np.arctan2(abs(limb[1]), abs(limb[0]))) == pytest.approx(90.0, abs=5.0)
    # Held at its border, the sheet lengthens along the old central limb and narrows across it.
    before, after = at(first, "scar end"), at(last, "scar end")
    assert np.linalg.norm(after[0] - after[1]) > 1.1 * np.linalg.norm(before[0] - before[1])
    before, after = at(first, "scar side"), at(last, "scar side")
    assert np.linalg.norm(after[0] - after[1]) < 0.95 * np.linalg.norm(before[0] - before[1])
    # The flaps lie in the sheet, less than half their thickness above or below it.
    assert np.abs(at(last, "flap middle")[:, 2] - THICKNESS).max() < THICKNESS / 2

    # The wound is closed: below the skin's edge no wall is far from the other (the caches' own points, not anchors).
    stage = Usd.Stage.Open(str(cache))
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath(f"/Procedure/Skin/epoch_{last['epoch']:02d}"))
    points = np.array(mesh.GetPointsAttr().Get(last["time_code"]))
    faces = np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)
    wall = faces[np.array(UsdGeom.Subset(stage.GetPrimAtPath(f"{mesh.GetPath()}/woundWall")).GetIndicesAttr().Get())]
    corners = points[wall]
    centers = corners.mean(axis=1)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    apart = np.linalg.norm(centers[:, None] - centers[None], axis=2)
    apart[normals @ normals.T > -0.3] = np.inf  # only walls that face each other
    assert np.median(apart.min(axis=1)) < 0.6
    assert np.quantile(apart.min(axis=1), 0.95) < 1.5


FOUR = {"quadrature": 4}


class OnLattices:
    """The last frame of the Z-plasty on several lattices, beside a fine one."""

    def __init__(self, folder: Path) -> None:
        self.scene, self.folder = z_plasty_scene(), folder
        self.skin = skin_of(self.scene.program(2.0))
        self.truth = kept_truth(self.scene)

    def last(self, program: Program) -> FrameResult:
        found = solve_program(program, FrameStore(self.folder), connect_to(None), "test", SolveObserver())
        assert found.reason is None
        return found.frames[-1]

    def points(self, frame: FrameResult) -> np.ndarray:
        return frame.solved.points[self.skin].astype(float)

    def program(self, spacing: float, changed: dict[str, Any]) -> Program:
        return self.scene.program(spacing, **{**DEFAULT, **changed, "correction": True})

    def off(self, program: Program) -> np.ndarray:
        return self.points(self.last(program)) - self.truth


@pytest.fixture(scope="module")
def lattices(tmp_path_factory: pytest.TempPathFactory) -> OnLattices:
    """The Z-plasty on lattices, each solved once."""
    return OnLattices(tmp_path_factory.mktemp("lattices"))


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_z_plasty_rests_in_one_way_on_every_lattice(lattices: OnLattices) -> None:
    # Slack skin rests 0.6 mm from the truth wherever it buckles the other way. Four points lock in cells of 2 mm: they
    # err by 0.125 mm there.
    for spacing, changed in ((2.0, {}), (2.0, {"tolerance": 1e-2}), (4.0 / 3.0, {}), (4.0 / 3.0, FOUR)):
        assert rms(lattices.off(lattices.program(spacing, changed))) < 0.1, (spacing, changed)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("spacing", "changed"),
    [
        (2.0, {}),
        (2.0, FOUR),
        (2.0, {"tolerance": 1e-2}),
        # Its greatest error is 0.294 mm, estimated 3.04 times as large.
        pytest.param(4.0 / 3.0, {}, marks=pytest.mark.xfail(strict=True, reason="estimated 3.04 times too large")),
        (4.0 / 3.0, FOUR),
    ],
    ids=["2", "2-four", "2-loose", "4/3", "4/3-four"],
)
def test_the_error_of_the_z_plasty_is_estimated_within_a_factor_of_three(
    spacing: float, changed: dict[str, Any], lattices: OnLattices
) -> None:
    program = lattices.program(spacing, changed)
    frame, off = lattices.last(program), lattices.off(program)
    coarse = lattices.last(coarse_program(program)).solved
    rest = RestSkin.of(program.epochs[-1])
    estimate = frame_error(frame.solved, coarse, rest, expected_order(program), spacing)
    assert estimate is not None
    assert rms(off) / 3.0 < estimate.rms < 3.0 * rms(off), (rms(off), estimate.rms)
    assert greatest(off) / 3.0 < estimate.greatest < 3.0 * greatest(off), (greatest(off), estimate.greatest)
