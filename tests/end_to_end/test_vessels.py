"""Vessels move with the tissue: in the solved frames, the skin cache and the report."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.output.report import report
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Hook, Incision, Landmark, Material, Procedure, Vessel
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import pxr

TOP = 6.0
DEEP = ((2.0, -9.0, 3.0), (2.0, 9.0, 3.0))
SKIN_LINE = ((-4.0, -10.0, TOP), (-4.0, -4.0, TOP))


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> tuple[SolveResult, Path]:
    """A patch that is slit at 2 across an artery and pulled by a hook from 3 on; its cache."""
    tissue = flat_patch((32.0, 24.0, TOP), resolution=2.0, spacing=2.0)
    events = (
        Incision("slit", 2.0, ((-8.0, 0.0, TOP), (8.0, 0.0, TOP))),
        Hook("hook", (0.0, -2.0, TOP), ((3.0, (0.0, -2.0, TOP)), (4.0, (0.0, -5.0, TOP + 2.0))), 3.0, 9.0),
        Landmark("deep", ((2.0, -5.0, 3.0),), "deep"),
    )
    vessels = (
        Vessel("artery", DEEP, "artery", 0.8, "angular artery"),
        Vessel("line", SKIN_LINE, "vein", 0.4, typical_course=True),
    )
    procedure = Procedure(tissue, (Material(),), events, end_time=4.0, vessels=vessels)
    cache = tmp_path_factory.mktemp("vessels") / "vessels.usdc"
    return solve_procedure(procedure, cache, error_estimate=False), cache


def test_a_vessel_in_the_skin_goes_where_the_vertices_of_the_skin_go(solved: tuple[SolveResult, Path]) -> None:
    """Vertices and vessels are embedded on their own; a patch of 2 mm has a vertex at each sample of the line."""
    result, _ = solved
    for frame in result.frames:
        epoch = frame.constraints.epoch
        rest = result.program.epochs[epoch].surface.points
        pieces = result.program.vessels_at[epoch]
        (line,) = (k for k, number in enumerate(pieces.vessel) if number == 1)
        points, now = pieces.split(pieces.points)[line], pieces.split(frame.solved.vessel_points)[line]
        apart = np.linalg.norm(rest[None] - points[:, None], axis=2)
        nearest = apart.argmin(axis=1)
        assert apart.min(axis=1).max() < 1e-6
        assert np.abs(frame.solved.points[nearest] - now).max() < 1e-5
    moved = np.linalg.norm(now - points, axis=1)
    assert moved.max() > 0.05


def test_a_landmark_on_a_vessel_stays_on_it(solved: tuple[SolveResult, Path]) -> None:
    """The sample 4 mm along the artery is the landmark's rest point."""
    result, _ = solved
    last = result.frames[-1].solved
    pieces = result.program.vessels_at[result.frames[-1].constraints.epoch]
    at = pieces.split(pieces.points)[0]
    (row,) = np.flatnonzero(np.linalg.norm(at - (2.0, -5.0, 3.0), axis=1) < 1e-9)
    assert np.array_equal(pieces.split(last.vessel_points)[0][row], last.landmarks[0])
    assert np.linalg.norm(last.landmarks[0] - (2.0, -5.0, 3.0)) > 0.1


def test_the_cut_ends_part_with_the_wound(solved: tuple[SolveResult, Path]) -> None:
    result, _ = solved
    ends = []
    for frame in result.frames[1:]:
        pieces = result.program.vessels_at[frame.constraints.epoch]
        first, second = pieces.split(frame.solved.vessel_points)[:2]
        assert pieces.divided[:2].tolist() == [[0, 1], [1, 0]]
        ends.append(float(np.linalg.norm(first[-1] - second[0])))
    assert ends[0] < 0.2 < 0.5 < ends[-1]


def test_the_skin_cache_has_the_pieces_of_each_epoch_as_curves(solved: tuple[SolveResult, Path]) -> None:
    result, cache = solved
    stage = pxr().Usd.Stage.Open(str(cache))
    whole, cut = (stage.GetPrimAtPath(f"/Procedure/Skin/Vessels/epoch_{k:02d}") for k in (0, 1))
    assert list(whole.GetAttribute("lappet:label").Get()) == ["angular artery", "line"]
    assert list(cut.GetAttribute("lappet:kind").Get()) == ["artery", "artery", "vein"]
    assert list(cut.GetAttribute("primvars:endDivided").Get()) == [1, 0, 0]
    assert np.allclose(cut.GetAttribute("widths").Get(), [1.6, 1.6, 0.8])
    points = np.array(cut.GetAttribute("points").Get(4.0))
    assert np.allclose(points, result.frames[-1].solved.vessel_points, atol=1e-5)
    shown = [[str(prim.GetAttribute("visibility").Get(time)) for time in (1.0, 2.0)] for prim in (whole, cut)]
    assert shown == [["inherited", "invisible"], ["invisible", "inherited"]]


def test_the_report_says_where_a_vessel_is_divided_and_how_far_it_is_stretched(
    solved: tuple[SolveResult, Path],
) -> None:
    result, _ = solved
    told = report(result)
    artery, line = told["vessels"]
    (crossing,) = artery["crossings"]
    assert crossing["incision"] == "slit"
    assert crossing["along_mm"] == pytest.approx(10.0, abs=1e-6)
    assert crossing["depth_mm"] == pytest.approx(3.0, abs=1e-6)
    assert (line["typical_course"], line["crossings"]) == (True, [])
    before, last = told["frames"][0]["vessels"], told["frames"][-1]["vessels"]
    assert before["artery"]["pieces"] == 1
    assert last["artery"]["pieces"] == 2
    assert before["artery"]["length_mm"] == pytest.approx(18.0, abs=0.02)
    pieces = result.program.vessels_at[1]
    now = pieces.split(result.frames[-1].solved.vessel_points)
    length = sum(np.linalg.norm(np.diff(each, axis=0), axis=1).sum() for each in now[:2])
    assert last["artery"]["length_mm"] == pytest.approx(length)
    assert last["artery"]["stretch"] == pytest.approx(length / (18.0 - 0.05))


def test_vessels_change_nothing_that_is_solved(solved: tuple[SolveResult, Path], tmp_path: Path) -> None:
    result, _ = solved
    bare = solve_procedure(replace(result.procedure, vessels=()), tmp_path / "bare.usdc", error_estimate=False)
    for frame, other in zip(result.frames, bare.frames, strict=True):
        assert np.array_equal(frame.solved.points, other.solved.points)
        assert np.array_equal(frame.solved.landmarks, other.solved.landmarks)
