"""From a procedure's file to its skin cache through the command line and the real daemon."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.daemon.key_writing import SECRET, pair_text, write_new
from lappet.daemon.process import SolverDaemon
from lappet.procedure import (
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Procedure,
    Retractor,
    Suture,
    Tissue,
    Undermine,
)
from lappet.procedure.edits import replace_event
from lappet.procedure.history import History
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import write_procedure
from lappet_runs import Run, solve
from report_shape import REPORT, misfits

pytestmark = pytest.mark.slow

TOP = 2.0
LESION = (9.0, 4.0)
GRIPPED = (11.0, -7.0, TOP)  # the middle of a face of the patch
TURN = np.deg2rad(5.0)


def ring(x: float, y: float, a: float, b: float) -> tuple[tuple[float, float, float], ...]:
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    return tuple((x + a * float(np.cos(t)), y + b * float(np.sin(t)), TOP) for t in turn)


def turned(closure: float) -> NDArray[np.float64]:
    """The retractor's motion as a column-vector matrix: half a millimetre up and a turn about its own middle."""
    c, s = np.cos(closure * TURN), np.sin(closure * TURN)
    motion = np.eye(4)
    motion[:2, :2] = [[c, -s], [s, c]]
    middle = np.array(GRIPPED)
    motion[:3, 3] = middle - motion[:3, :3] @ middle + closure * np.array([0.3, 0.0, 0.5])
    return motion


def gripped_faces(tissue: Tissue) -> NDArray[np.int32]:
    middles = tissue.points[tissue.face_vertex_indices.reshape(-1, 4)].mean(axis=1)
    (found,) = np.nonzero(np.abs(middles - GRIPPED).max(axis=1) < 1e-6)
    assert len(found) == 1
    return found.astype(np.int32)


def operation(model: str = "neoHookean") -> Procedure:
    """Frames 1 to 10 on 32 x 20 x 2 mm with every kind of event: whole; cut at 3; freed at 4; a lesion out at 5."""
    patch = flat_patch((32.0, 20.0, TOP), resolution=2.0, spacing=1.0, gravity=0.0)
    tissue = replace(patch, subsets={**patch.subsets, "grip": gripped_faces(patch)})
    return Procedure(
        tissue,
        (Material(model=model),),
        (
            Incision("slit", 3.0, ((-10.0, 0.0, TOP), (2.0, 0.0, TOP)), kerf=0.1),
            Incision("outline", 3.0, ring(*LESION, 3.0, 3.0), kerf=0.1, closed=True),
            Undermine("freed", 4.0, ring(-4.0, 0.0, 8.0, 5.0)),
            Excision("lesion", 5.0, ((*LESION, TOP),)),
            Hook("lift", (-4.0, 2.0, TOP), ((5.0, (-4.0, 2.0, TOP)), (7.0, (-4.0, 4.0, TOP + 2.0))), 5.0, 8.0, 100.0),
            Retractor(
                "spread",
                "grip",
                tuple((time, tuple(turned(part).T.ravel())) for time, part in ((5.0, 0.0), (7.0, 1.0))),
                5.0,
                9.0,
            ),
            Suture("stitch", ((-4.0, -1.0, TOP), (-4.0, 1.0, TOP)), 7.0, 2.0),
            Landmark("held", (GRIPPED,), "held"),
            Landmark("lost", ((*LESION, TOP),), "lost"),
            Landmark("far", ((-14.0, 8.0, TOP),), "far"),
        ),
        start_time=1.0,
        end_time=10.0,
    )


@dataclass(frozen=True, eq=False)
class Solved:
    """The operation, solved once."""

    procedure: Procedure
    folder: Path
    run: Run


@pytest.fixture(scope="module", params=["neoHookean", "corotated"])
def solved(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Solved:
    procedure = operation(request.param)
    folder = tmp_path_factory.mktemp(request.param)
    write_procedure(procedure, folder / "p.usda")
    run = solve(folder)
    assert run.status == 0, run.stderr
    return Solved(procedure, folder, run)


def vector(values: Any) -> NDArray[np.float64]:
    return np.array(values, np.float64)


# --- one solve with every kind of event ----------------------------------------------------------------------------


def test_every_frame_is_in_the_report_and_in_equilibrium(solved: Solved) -> None:
    report = solved.run.report
    assert misfits(report, REPORT) == []
    assert [frame["time_code"] for frame in report["frames"]] == list(range(1, 11))
    assert (report["complete"], report["frames_solved"], report["cache_hits"]) == (True, 10, 0)
    assert report["settings"]["materials"][0]["model"] == solved.procedure.materials[0].model
    assert [(epoch["start_time"], epoch["fragments"]) for epoch in report["epochs"]] == [(1, 1), (3, 2), (4, 2), (5, 1)]
    needed = {name for name, present in report["scene_profile"].items() if present}
    assert needed >= {"incisions", "undermining", "excisions", "hooks", "retractors", "sutures", "landmarks", "bed"}
    for frame in report["frames"]:
        assert frame["converged"]
        assert frame["residual"] <= report["settings"]["tolerance"]
        assert frame["largest_gap_mm"] <= report["settings"]["gap_tolerance"] * report["settings"]["spacing"] * 1.001
        assert frame["inverted_cells"] == 0
        assert frame["minimum_j"] > 0.0


def test_whole_tissue_at_rest_does_not_move(solved: Solved) -> None:
    landmarks = solved.run.frame(1)["landmarks"]
    np.testing.assert_allclose(landmarks["far"], (-14.0, 8.0, TOP), atol=1e-6)
    np.testing.assert_allclose(landmarks["lost"], (*LESION, TOP), atol=1e-6)


def test_a_hook_pulls_towards_its_target_with_its_stiffness_while_it_holds(solved: Solved) -> None:
    pulled = {frame["time_code"]: frame["hook_forces_mn"] for frame in solved.run.report["frames"]}
    assert [time for time, forces in pulled.items() if "lift" in forces] == [5, 6, 7]
    force = vector(pulled[7]["lift"])
    assert force[1] > 0.0
    assert force[2] > 0.0
    hooked, _ = markers(solved, "Hooks", 7)["lift"]
    np.testing.assert_allclose(force, 100.0 * (np.array([-4.0, 4.0, TOP + 2.0]) - hooked), rtol=1e-3, atol=0.05)


def test_what_a_retractor_grips_moves_rigidly_with_it_until_it_lets_go(solved: Solved) -> None:
    half = turned(0.5)
    half[:3, 3] = 0.5 * turned(1.0)[:3, 3]  # between samples the translation is linear and the turn at constant speed
    for time, motion in ((5, turned(0.0)), (6, half), (7, turned(1.0)), (8, turned(1.0))):
        moved = motion[:3, :3] @ np.array(GRIPPED) + motion[:3, 3]
        np.testing.assert_allclose(solved.run.frame(time)["landmarks"]["held"], moved, atol=2e-3)
    back = vector(solved.run.frame(9)["landmarks"]["held"]) - GRIPPED
    assert np.linalg.norm(back) < 0.1


def test_a_suture_draws_the_wound_together_and_holds_it(solved: Solved) -> None:
    def gap(time: int) -> float:
        ends = markers(solved, "Sutures", time)["stitch"]
        return float(np.linalg.norm(ends[1] - ends[0]))

    assert gap(7) > 1.5  # its closure begins at 0
    assert gap(8) == pytest.approx(0.5 * gap(7), abs=2e-3)
    assert gap(9) < 2e-3
    assert gap(10) < 2e-3
    assert solved.run.frame(10)["suture_forces_mn"]["stitch"] > 0.0
    assert solved.run.frame(6)["suture_forces_mn"] == {}


def test_excised_tissue_takes_its_landmarks_along(solved: Solved) -> None:
    assert "lost" in solved.run.frame(4)["landmarks"]
    assert solved.run.frame(5)["landmarks"].keys() == {"held", "far"}
    points = skin(solved, 5)
    assert np.linalg.norm(points[:, :2] - LESION, axis=1).min() > 2.5


def test_the_skin_cache_holds_every_epoch_over_the_procedure(solved: Solved) -> None:
    for time, epoch in ((1, 0), (2, 0), (3, 1), (4, 2), (5, 3), (10, 3)):
        assert visible_epochs(solved, time) == [f"epoch_{epoch:02d}"]
    assert skin(solved, 7)[:, 2].max() > TOP + 0.5


# --- the same again, edited, undone, in part -----------------------------------------------------------------------


def test_solving_again_looks_every_frame_up_and_writes_the_same_bytes(solved: Solved) -> None:
    again = solve(solved.folder)
    assert again.status == 0
    assert (again.report["frames_solved"], again.report["cache_hits"]) == (0, 10)
    assert again.cache == solved.run.cache


def test_an_edit_solves_from_its_frame_on_and_undoing_it_solves_nothing(solved: Solved) -> None:
    history = History(solved.procedure)
    hook = solved.procedure.event("lift")
    assert isinstance(hook, Hook)
    higher = (*hook.targets[:-1], (7.0, (-4.0, 4.0, TOP + 3.0)))
    try:
        history.do(replace_event("lift", replace(hook, targets=higher)))
        write_procedure(history.procedure, solved.folder / "p.usda")
        edited = solve(solved.folder)
        assert edited.status == 0
        hits = [frame["cache_hit"] for frame in edited.report["frames"]]
        assert hits == [True] * 5 + [False] * 5  # at frame 5 the target is the same
        assert edited.cache != solved.run.cache
        history.undo()
    finally:
        write_procedure(solved.procedure, solved.folder / "p.usda")
    assert history.procedure == solved.procedure
    undone = solve(solved.folder)
    assert undone.report["frames_solved"] == 0
    assert undone.cache == solved.run.cache


def test_a_range_of_frames_gives_those_frames_of_the_whole_solve(solved: Solved, tmp_path: Path) -> None:
    write_procedure(solved.procedure, tmp_path / "p.usda")
    part = solve(tmp_path, "--frames", "3:4")
    assert part.status == 0
    assert "4 frames done: 4 solved" in part.stdout
    assert [frame["key"] for frame in part.report["frames"]] == [solved.run.frame(time)["key"] for time in (1, 2, 3, 4)]
    there = Solved(solved.procedure, tmp_path, part)
    assert visible_epochs(there, 4) == ["epoch_02"]
    np.testing.assert_array_equal(skin(there, 4), skin(solved, 4))


def test_a_daemon_that_runs_elsewhere_gives_the_same_frames(
    solved: Solved, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_procedure(solved.procedure, tmp_path / "p.usda")
    with SolverDaemon() as daemon:
        monkeypatch.setenv("LAPPET_TOKEN", daemon.token)
        part = solve(tmp_path, "--daemon", daemon.address, "--frames", ":3")
        assert daemon.alive()
        monkeypatch.setenv("LAPPET_TOKEN", "guess")
        refused = solve(tmp_path, "--daemon", daemon.address)
    assert part.status == 0
    there = Solved(solved.procedure, tmp_path, part)
    np.testing.assert_array_equal(skin(there, 3), skin(solved, 3))
    assert refused.status == 1
    assert "token" in refused.stderr


def test_a_daemon_with_keys_gives_the_same_frames_to_whom_it_knows(solved: Solved, tmp_path: Path) -> None:
    write_procedure(solved.procedure, tmp_path / "p.usda")
    with SolverDaemon(listen="tcp://127.0.0.1:0") as daemon:
        assert daemon.keys is not None
        own = tmp_path / "own.key"
        write_new(own, pair_text(daemon.keys.own, "The key of this test."), SECRET)
        keys = ("--daemon", daemon.address, "--server-key", daemon.keys.server, "--key", own)
        part = solve(tmp_path, *keys, "--frames", ":3")
        assert daemon.alive()
    assert part.status == 0
    np.testing.assert_array_equal(skin(Solved(solved.procedure, tmp_path, part), 3), skin(solved, 3))


def test_check_and_inspect_know_what_the_solve_will_find(solved: Solved) -> None:
    def lappet(command: str) -> str:
        done = subprocess.run(
            [sys.executable, "-m", "lappet", command, str(solved.folder / "p.usda")],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "no problem found" in lappet("check")
    inspected = lappet("inspect")
    for epoch in solved.run.report["epochs"]:
        counts = epoch["lattice"]
        assert f"{counts['cells']} cells ({counts['grid_cells']} grid, {counts['mesh_cells']} mesh)" in inspected
        assert counts["cells"] == counts["grid_cells"] + counts["mesh_cells"]
        assert counts["fragments"] == epoch["fragments"]


# --- materials by region and depth ---------------------------------------------------------------------------------


# --- what cannot be done -------------------------------------------------------------------------------------------


# --- cutting is combinatorial --------------------------------------------------------------------------------------


# --- reading the skin cache ----------------------------------------------------------------------------------------


def stage_of(solved: Solved) -> Any:
    from pxr import Usd

    # A copy of the first solve's bytes: later tests write the cache anew.
    path = solved.folder / "first.usdc"
    if not path.is_file():
        path.write_bytes(solved.run.cache)
    return Usd.Stage.Open(str(path))


def visible_epochs(solved: Solved, time: int) -> list[str]:
    from pxr import UsdGeom

    stage = stage_of(solved)
    meshes = [prim for prim in stage.GetPrimAtPath("/Procedure/Skin").GetChildren() if prim.IsA(UsdGeom.Mesh)]
    return [mesh.GetName() for mesh in meshes if UsdGeom.Imageable(mesh).ComputeVisibility(time) != "invisible"]


def skin(solved: Solved, time: int) -> NDArray[np.float64]:
    """The points of the skin at a time code, mm."""
    (name,) = visible_epochs(solved, time)
    stage = stage_of(solved)
    return vector(stage.GetPrimAtPath(f"/Procedure/Skin/{name}").GetAttribute("points").Get(time))


def markers(solved: Solved, kind: str, time: int) -> dict[str, NDArray[np.float64]]:
    """The two ends (2, 3) of every suture or hook at a time code, mm, by name."""
    stage = stage_of(solved)
    prim = stage.GetPrimAtPath(f"/Procedure/Skin/{kind}")
    ends = vector(prim.GetAttribute("points").Get(time)).reshape(-1, 2, 3)
    return dict(zip(prim.GetAttribute("primvars:label").Get(), ends, strict=True))
