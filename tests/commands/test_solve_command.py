"""`lappet solve`: what it writes, says and refuses, and its exit status."""

from __future__ import annotations

import contextlib
import csv
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from command_runs import is_one_sentence, run
from lappet.commands.solve_progress import BarProgress, PlainProgress
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import FrameRefusedError
from lappet.procedure import Hook
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import SolveObserver
from lappet.usd.stage import read_procedure, write_procedure
from small_procedure import FakeSolver, small_procedure


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
@pytest.mark.parametrize("progress", [PlainProgress, BarProgress])
def test_a_solve_whose_progress_nobody_can_write_leaves_its_cache_and_report(
    procedure: Path, solver: FakeSolver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, progress: type[SolveObserver]
) -> None:
    from lappet.commands.run_solve import run_solve

    monkeypatch.setattr("lappet.commands.solve_progress.solve_progress", progress)

    cache, report = tmp_path / "c.usdc", tmp_path / "r.json"
    full = Path("/dev/full").open("w", buffering=1)  # noqa: SIM115
    monkeypatch.setattr(sys, "stdout", full)
    monkeypatch.setattr(sys, "stderr", full)
    options: dict[str, Any] = {"frames": (None, None), "daemon": None, "store": None, "error_estimate": False}
    result = run_solve(procedure, cache, report, SolverSettings(), **options)
    monkeypatch.undo()
    with contextlib.suppress(OSError):
        full.close()
    assert result.complete
    assert cache.is_file()
    assert report.is_file()


def test_solve_writes_the_cache_and_the_report_and_a_second_run_solves_nothing(
    procedure: Path, solver: FakeSolver, tmp_path: Path
) -> None:
    cache, report = tmp_path / "c.usdc", tmp_path / "r.json"
    first = run("solve", procedure, "-o", cache, "--report", report, "--no-error-estimate")
    assert first.exit_code == 0, first.output
    assert "8 frames done: 8 solved, 0 looked up" in first.stdout
    assert str(cache) in first.stdout
    assert "frame 8" in first.stderr
    assert cache.is_file()
    assert len(json.loads(report.read_text())["frames"]) == 8
    again = run("solve", procedure, "-o", cache, "--report", report, "--no-error-estimate")
    assert "8 frames done: 0 solved, 8 looked up" in again.stdout, again.output
    assert solver.opened == 1
    assert json.loads(report.read_text())["cache_hits"] == 8


def test_solve_writes_what_it_measures_as_tables_and_sums_up_the_seams(
    procedure: Path, solver: FakeSolver, tmp_path: Path
) -> None:
    paths = {name: tmp_path / f"{name}.csv" for name in ("suture-forces", "hook-forces", "seams")}
    report = tmp_path / "r.json"
    options = [part for name, path in paths.items() for part in (f"--{name}", path)]
    done = run("solve", procedure, "--report", report, *options)
    assert done.exit_code == 0, done.output
    assert "Scar: 12 mm" in done.stdout
    tables = {}
    for name, path in paths.items():
        with path.open(newline="") as file:
            tables[name] = list(csv.DictReader(file))
    sutures, hooks, seams = tables.values()
    assert [(row["suture"], float(row["force_y_mn"])) for row in sutures] == [("stitch", 5.0)] * 4
    assert [(float(row["time"]), row["hook"], float(row["force_z_mn"])) for row in hooks] == [
        (time, "hook", 2.0) for time in (4.0, 5.0, 6.0)
    ]
    assert [float(row["force_mn"]) for row in hooks] == pytest.approx([12.0**0.5] * 3, rel=1e-5)
    assert [float(row["time"]) for row in seams] == [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    values = json.loads(report.read_text())["seams"]
    assert [each["time_code"] for each in values] == [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    for row, each in zip(seams, values, strict=True):
        own = each["seams"]["stitch"]
        assert own.keys() == row.keys() - {"time", "seam"}
        assert own["scar_length_mm"] == pytest.approx(float(row["scar_length_mm"]), rel=1e-5)
        assert each["scar_length_mm"] == own["scar_length_mm"]
    assert [row["tension_n_per_mm"] == "" for row in seams] == [True, True, False, False, False, False]


def test_the_cache_lies_beside_the_procedure_unless_it_is_named(procedure: Path, solver: FakeSolver) -> None:
    assert run("solve", procedure).exit_code == 0
    assert procedure.with_suffix(".cache.usdc").is_file()


def test_options_reach_the_solver(procedure: Path, solver: FakeSolver, tmp_path: Path) -> None:
    seen: list[Any] = []
    connect = solver.connect
    solver.connect = lambda settings, bones: (seen.append(settings), connect(settings, bones))[1]  # type: ignore[method-assign]
    done = run(
        "solve", procedure, "--spacing", 2, "--tolerance", "1e-4", "--quadrature", 8, "--precision", "float",
        "--self-contact", "--friction", "0.3", "--store", tmp_path / "named",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert (seen[0].spacing, seen[0].tolerance, seen[0].quadrature) == (2.0, 1e-4, 8)
    assert (seen[0].self_contact, seen[0].friction) == (True, 0.3)
    assert list((tmp_path / "named").rglob("*.frame"))
    assert not (tmp_path / "store").exists()


def test_a_range_of_frames_solves_up_to_its_end_and_writes_from_its_beginning(
    procedure: Path, solver: FakeSolver, tmp_path: Path
) -> None:
    from pxr import Usd

    chosen = ("--frames", "3:5", "--no-error-estimate")
    assert run("solve", procedure, "-o", tmp_path / "c.usda", *chosen).exit_code == 0
    assert solver.times() == [1, 2, 3, 4, 5]
    stage = Usd.Stage.Open(str(tmp_path / "c.usda"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (3, 5)
    outside = run("solve", procedure, "--frames", "3:99")
    assert outside.exit_code == 1
    assert "3:99" in outside.stderr
    assert "1 to 8" in outside.stderr


def test_a_frame_that_does_not_converge_exits_with_1_and_keeps_the_cache(
    procedure: Path, solver: FakeSolver, tmp_path: Path
) -> None:
    solver.unconverged = frozenset({4.0})
    report = tmp_path / "r.json"
    done = run("solve", procedure, "-o", tmp_path / "c.usdc", "--report", report)
    assert done.exit_code == 1
    assert "Frame 4: " in done.stderr
    assert (tmp_path / "c.usdc").is_file()
    told = json.loads(report.read_text())
    assert told["failed"]["time_code"] == 4
    assert told["code"] == told["failed"]["code"] == "frame-not-converged"


def test_ctrl_c_writes_what_is_done(procedure: Path, solver: FakeSolver, tmp_path: Path) -> None:
    from pxr import Usd

    def stop(time_code: float) -> None:
        if time_code == 6.0:
            raise KeyboardInterrupt

    solver.before = stop
    done = run("solve", procedure, "-o", tmp_path / "c.usdc")
    assert done.exit_code == 1
    assert "Stopped: 5 of 8 frames are done." in done.stderr
    assert Usd.Stage.Open(str(tmp_path / "c.usdc")).GetEndTimeCode() == 5


def test_what_the_daemon_refuses_at_once_is_a_sentence_and_writes_nothing(
    procedure: Path, solver: FakeSolver, tmp_path: Path
) -> None:
    def refuse(_: float) -> None:
        raise FrameRefusedError.of(ProblemCode.SOLVER_MEMORY_BUDGET, "", "The lattice needs 9 GiB.")

    solver.before = refuse
    done = run("solve", procedure, "-o", tmp_path / "c.usdc")
    assert done.exit_code == 1
    assert is_one_sentence(done.stderr)
    assert "9 GiB" in done.stderr
    assert not (tmp_path / "c.usdc").exists()


@pytest.mark.parametrize(
    ("output", "said"),
    [
        ("c.png", "USD suffix"),
        ("folder.usdc", "is a folder"),
        ("file/c.usdc", "does not exist"),
        ("p.usda", "itself"),
    ],
)
def test_a_cache_that_cannot_be_written_is_refused_before_the_solver_is_asked(
    procedure: Path, solver: FakeSolver, tmp_path: Path, output: str, said: str
) -> None:
    (tmp_path / "folder.usdc").mkdir()
    (tmp_path / "file").write_text("in the way")
    done = run("solve", procedure, "-o", tmp_path / output)
    assert done.exit_code == 1
    assert is_one_sentence(done.stderr)
    assert said in done.stderr
    assert solver.opened == 0


def test_a_wrong_procedure_is_refused_before_the_solver_is_asked(solver: FakeSolver, tmp_path: Path) -> None:
    off = Hook("far", (0.0, 0.0, 50.0), ((1.0, (0.0, 0.0, 0.0)),), 1.0, 9.0)
    write_procedure(small_procedure().with_events(off), tmp_path / "p.usda")
    for command in ("solve", "check"):
        done = run(command, tmp_path / "p.usda")
        assert done.exit_code == 1
        assert "/Procedure/Timeline/far" in done.stderr + done.stdout
    assert solver.opened == 0


def test_friction_without_self_contact_is_refused_before_the_solver_is_asked(
    procedure: Path, solver: FakeSolver
) -> None:
    done = run("solve", procedure, "--friction", "0.3", "--no-self-contact")
    assert done.exit_code == 2
    assert "--no-self-contact" in done.stderr
    assert solver.opened == 0


@pytest.mark.parametrize(
    ("own", "options", "expected"),
    [
        (True, (), True),
        (False, (), False),
        (True, ("--no-self-contact",), False),
        (False, ("--self-contact",), True),
        (False, ("--friction", "0.3"), True),
    ],
)
def test_the_procedure_says_whether_tissue_is_kept_apart_unless_an_option_does(
    own: bool, options: tuple[str, ...], expected: bool, solver: FakeSolver, tmp_path: Path
) -> None:
    seen: list[Any] = []
    connect = solver.connect
    solver.connect = lambda settings, bones: (seen.append(settings), connect(settings, bones))[1]  # type: ignore[method-assign]
    plain = small_procedure()
    file = tmp_path / "p.usda"
    write_procedure(replace(plain, tissue=replace(plain.tissue, self_contact=own)), file)
    done = run("solve", file, *options)
    assert done.exit_code == 0, done.output
    assert {settings.self_contact for settings in seen} == {expected}


def test_solve_without_a_daemon_is_a_sentence(procedure: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(tmp_path / "nowhere"))
    done = run("solve", procedure)
    assert done.exit_code == 1
    assert is_one_sentence(done.stderr)
    assert "LAPPET_SOLVERD" in done.stderr


def test_the_python_call_takes_a_procedure_and_keeps_it_beside_the_cache(solver: FakeSolver, tmp_path: Path) -> None:
    import lappet

    result = lappet.solve_procedure(small_procedure(), tmp_path / "c.usdc")
    assert result.complete
    assert (result.solved, result.looked_up, result.output) == (8, 0, tmp_path / "c.usdc")
    assert read_procedure(tmp_path / "c.procedure.usda") == small_procedure()


def test_a_terminal_gets_a_bar_and_notes_above_it(
    solver: FakeSolver, procedure: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from lappet.daemon.frame_solver import SolverDiedError
    from lappet.output.solve_to_cache import solve_procedure

    deaths = [5.0]

    def die(time_code: float) -> None:
        if time_code in deaths:
            deaths.remove(time_code)
            raise SolverDiedError.of(ProblemCode.DAEMON_DIED, "", "it was ended by [SIGKILL].")

    solver.before = die
    with BarProgress() as observer:
        solve_procedure(procedure, tmp_path / "c.usdc", observer=observer)
    shown = capsys.readouterr().err
    assert "8/8" in shown
    assert "ended by [SIGKILL]. It was solving frame 5" in " ".join(shown.split())
