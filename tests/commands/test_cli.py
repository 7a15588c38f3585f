"""The command line: thin, quick to start, one sentence for what it refuses, and the right exit status."""

from __future__ import annotations

import contextlib
import csv
import json
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import lappet.output.render
from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import FrameRefusedError
from lappet.procedure import Hook
from lappet.program.settings import SolverSettings
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import read_procedure, write_procedure
from small_procedure import EXCISED, TOP, FakeSolver, small_procedure

HEAVY = ("numpy", "pxr", "manifold3d", "trimesh", "zmq", "msgpack", "rich", "networkx", "scipy", "bpy", "platformdirs")


@pytest.fixture
def solver(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[FakeSolver]:
    """A solver that stands in for the daemon, and a store of its own."""
    fake = FakeSolver()
    for user in ("output.solve_to_cache", "output.inspect_procedure", "daemon.daemon_solver"):
        monkeypatch.setattr(f"lappet.{user}.connect_to", lambda address: fake.connect)
    monkeypatch.setattr("lappet.output.solve_to_cache.solver_identity", lambda address: "fake 1")
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "store"))
    return fake


@pytest.fixture
def procedure(tmp_path: Path) -> Path:
    path = tmp_path / "p.usda"
    write_procedure(small_procedure(), path)
    return path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(each) for each in arguments])


def is_one_sentence(text: str) -> bool:
    return len(text.strip().splitlines()) == 1 and "Traceback" not in text


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom lappet.commands.cli import cli\n"
        "try:\n    cli(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print('LOADED', [name for name in {HEAVY!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "LOADED []"


def test_help_is_there_in_a_third_of_a_second() -> None:
    spent = []
    for _ in range(5):
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-m", "lappet", "--help"], capture_output=True, check=True, timeout=60)
        spent.append(time.perf_counter() - begun)
    bare = []
    for _ in range(3):
        begun = time.perf_counter()
        subprocess.run([sys.executable, "-c", "import click"], capture_output=True, check=True, timeout=60)
        bare.append(time.perf_counter() - begun)
    assert min(spent) < max(0.3, 2.0 * min(bare))


def test_every_command_of_the_design_is_there_with_its_options() -> None:
    assert set(cli.commands) >= {"demo", "new", "solve", "check", "inspect", "render"}
    options = {option for parameter in cli.commands["solve"].params for option in parameter.opts}
    assert options >= {
        "-o",
        "--report",
        "--spacing",
        "--tolerance",
        "--quadrature",
        "--precision",
        "--frames",
        "--daemon",
        "--store",
    }
    for name in cli.commands:
        assert run(name, "--help").exit_code == 0


def test_the_version_is_that_of_the_package() -> None:
    from lappet import __version__

    assert run("--version").output == f"lappet {__version__}\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
def test_a_solve_whose_progress_nobody_can_write_leaves_its_cache_and_report(
    procedure: Path, solver: FakeSolver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from lappet.commands.run_solve import run_solve

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
    cache, report = tmp_path / "out" / "c.usdc", tmp_path / "out" / "r.json"
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
        "--store", tmp_path / "named",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert (seen[0].spacing, seen[0].tolerance, seen[0].quadrature) == (2.0, 1e-4, 8)
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
        ("file/c.usdc", "cannot be written"),
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


@pytest.mark.parametrize("command", ["solve", "check", "inspect"])
@pytest.mark.parametrize("text", [None, "this is not USD", "#usda 1.0\n"])
def test_a_file_that_is_no_procedure_is_a_sentence(command: str, text: str | None, tmp_path: Path) -> None:
    path = tmp_path / "broken.usda"
    if text is not None:
        path.write_text(text)
    done = run(command, path)
    assert done.exit_code == 1
    said = done.stderr + done.stdout
    # An empty stage lacks several things: a line each.
    assert "Traceback" not in said
    assert "failed" not in said
    assert text == "#usda 1.0\n" or is_one_sentence(said), said
    assert "broken.usda" in said or "/Procedure" in said


def test_a_wrong_procedure_is_refused_before_the_solver_is_asked(solver: FakeSolver, tmp_path: Path) -> None:
    off = Hook("far", (0.0, 0.0, 50.0), ((1.0, (0.0, 0.0, 0.0)),), 1.0, 9.0)
    write_procedure(small_procedure().with_events(off), tmp_path / "p.usda")
    for command in ("solve", "check"):
        done = run(command, tmp_path / "p.usda")
        assert done.exit_code == 1
        assert "/Procedure/Timeline/far" in done.stderr + done.stdout
    assert solver.opened == 0


def test_check_finds_what_only_shows_in_the_cut_tissue(tmp_path: Path) -> None:
    hook = Hook("late", (1.0, 0.5, TOP), ((1.0, (1.0, 0.5, TOP)),), 1.0, 8.0)
    write_procedure(small_procedure(events=(*EXCISED, hook)), tmp_path / "p.usda")
    done = run("check", tmp_path / "p.usda")
    assert done.exit_code == 1
    assert done.stdout.startswith("error: /Procedure/Timeline/late: Its anchor")
    assert "excised" in done.stdout


def test_check_of_a_good_procedure_says_so(procedure: Path) -> None:
    done = run("check", procedure)
    assert (done.exit_code, done.stdout) == (0, f"{procedure}: no problem found.\n")


def test_inspect_prints_the_storyboard_epochs_profile_and_lattice(procedure: Path, solver: FakeSolver) -> None:
    done = run("inspect", procedure)
    assert done.exit_code == 0, done.output
    for said in ("slit", "stitch", "epoch 1: frames 3 to 8", "wound wall", "20 cells (19 grid, 1 mesh)", "needs"):
        assert said in done.stdout
    assert solver.closed == 1
    assert "20 cells" not in run("inspect", procedure, "--no-lattice").stdout


def test_inspect_without_a_daemon_says_why_there_are_no_counts(
    procedure: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(tmp_path / "nowhere"))
    done = run("inspect", procedure)
    assert done.exit_code == 0
    assert "No lattice counts" in done.stdout
    assert "nowhere" in done.stdout


def test_solve_without_a_daemon_is_a_sentence(procedure: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(tmp_path / "nowhere"))
    done = run("solve", procedure)
    assert done.exit_code == 1
    assert is_one_sentence(done.stderr)
    assert "LAPPET_SOLVERD" in done.stderr


@pytest.mark.parametrize(
    "arguments",
    [
        ["solve"],
        ["solve", "p.usda", "--quadrature", "5"],
        ["solve", "p.usda", "--spacing", "-1"],
        ["solve", "p.usda", "--spacing", "0"],
        ["solve", "p.usda", "--tolerance", "2"],
        ["solve", "p.usda", "--precision", "half"],
        ["solve", "p.usda", "--frames", "a:b"],
        ["solve", "p.usda", "--frames", "9:2"],
        ["solve", "p.usda", "--frames", ":"],
        ["render", "c.usdc"],
        ["render", "c.usdc", "-o", "d", "--size", "big"],
        ["render", "c.usdc", "-o", "d", "--frames", "one"],
        ["new", "mesh.obj"],
        ["new", "mesh.obj", "-o", "p.usda", "--position", "sideways"],
        ["new", "mesh.obj", "-o", "p.usda", "--position", "0,0,0"],
        ["nothing"],
    ],
)
def test_wrong_usage_exits_with_2(arguments: list[str]) -> None:
    done = run(*arguments)
    assert done.exit_code == 2
    assert "Usage:" in done.stderr


def test_an_error_of_our_own_shows_its_traceback_only_when_asked(
    procedure: Path, solver: FakeSolver, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object, **__: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("lappet.output.solve_to_cache.compile_program", broken)
    done = run("solve", procedure)
    assert done.exit_code == 1
    assert is_one_sentence(done.stderr)
    assert "ZeroDivisionError" in done.stderr
    assert "--debug" in done.stderr
    shown = run("--debug", "solve", procedure)
    assert isinstance(shown.exception, ZeroDivisionError)


def test_new_makes_a_procedure_of_a_mesh(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.box((40.0, 30.0, 4.0)).export(tmp_path / "box.stl")
    done = run("new", tmp_path / "box.stl", "-o", tmp_path / "p.usda", "--units", "mm", "--spacing", "2")
    assert done.exit_code == 0, done.output
    assert "watertight" in done.stdout
    tissue = read_procedure(tmp_path / "p.usda").tissue
    assert tissue.spacing == 2.0
    assert np.allclose(np.ptp(tissue.points, axis=0), (40.0, 30.0, 4.0))


def test_new_of_something_else_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "mesh.obj").write_text("no mesh at all")
    for name in ("mesh.obj", "missing.obj"):
        done = run("new", tmp_path / name, "-o", tmp_path / "p.usda")
        assert done.exit_code == 1
        assert is_one_sentence(done.stderr), done.stderr
        assert name in done.stderr


def test_render_passes_on_what_it_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: dict[str, Any] = {}

    def render(cache: Path, folder: Path, **options: Any) -> list[Path]:
        seen.update(options, cache=cache, folder=folder)
        return [folder / "still_0001.png"]

    monkeypatch.setattr(lappet.output.render, "render_cache", render)
    done = run(
        "render", "c.usdc", "-o", tmp_path, "--frames", "1,20", "--size", "640x480", "--no-filmstrip", "--animation",
        "mp4",
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    assert done.stdout == f"{tmp_path / 'still_0001.png'}\n"
    assert (seen["frames"], seen["size"], seen["filmstrip"], seen["animation"]) == ([1, 20], (640, 480), False, "mp4")
    assert "view" not in seen


def test_demo_solves_and_renders_into_one_folder(
    solver: FakeSolver, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    write_procedure(small_procedure(tissue=flat_patch((24.0, 16.0, TOP))), tmp_path / "bundled.usda")
    monkeypatch.setattr("lappet.demo.z_plasty", lambda: tmp_path / "bundled.usda")
    drawn: list[Path] = []

    def render(cache: Path, folder: Path, **_: Any) -> list[Path]:
        drawn.append(folder.resolve() / "filmstrip.png")  # absolute, as the real one says
        drawn[-1].write_bytes(b"picture")
        return drawn[-1:]

    monkeypatch.setattr(lappet.output.render, "render_cache", render)
    monkeypatch.chdir(tmp_path)
    done = run("demo", "-o", "demo")
    assert done.exit_code == 0, done.output
    assert str(tmp_path / "demo" / "figures" / "filmstrip.png") in done.stdout
    assert str(tmp_path / "demo" / "z_plasty.cache.usdc") in done.stdout
    assert (tmp_path / "demo" / "z_plasty.cache.usdc").is_file()
    assert (tmp_path / "demo" / "z_plasty.report.json").is_file()

    again = run("demo", "-o", "demo")
    assert again.exit_code == 0, again.output
    assert str(drawn[0]) in again.stdout
    assert len(drawn) == 1, "what did not change was drawn again"
    drawn[0].unlink()
    run("demo", "-o", "demo")
    assert len(drawn) == 2, "a picture that is gone was not drawn again"


def test_the_python_call_takes_a_procedure_and_keeps_it_beside_the_cache(solver: FakeSolver, tmp_path: Path) -> None:
    import lappet

    result = lappet.solve_procedure(small_procedure(), tmp_path / "new" / "c.usdc")
    assert result.complete
    assert (result.solved, result.looked_up, result.output) == (8, 0, tmp_path / "new" / "c.usdc")
    assert read_procedure(tmp_path / "new" / "c.procedure.usda") == small_procedure()


def test_a_terminal_gets_a_bar_and_notes_above_it(
    solver: FakeSolver, procedure: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from lappet.commands.solve_progress import BarProgress
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


def test_public_names_are_there_and_importing_the_package_is_light() -> None:
    import lappet

    for name in lappet.__all__:
        assert getattr(lappet, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = lappet.nothing
    code = f"import sys, lappet; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"
