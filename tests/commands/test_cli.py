"""The command line: thin, quick to start, one sentence for what it refuses, and the right exit status."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lappet.output.render
from command_runs import is_one_sentence, run
from lappet.commands.cli import cli
from lappet.procedure import Hook
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import read_procedure, write_procedure
from small_procedure import EXCISED, TOP, FakeSolver, small_procedure

HEAVY = ("numpy", "pxr", "manifold3d", "trimesh", "zmq", "msgpack", "rich", "networkx", "scipy", "bpy", "platformdirs")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom lappet.commands.cli import cli\n"
        "try:\n    cli(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print('LOADED', [name for name in {HEAVY!r} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "LOADED []"


def test_help_is_there_in_a_third_of_a_second() -> None:
    spent, bare = [], []
    for _ in range(5):  # by turns, since other work on the machine slows both
        for arguments, seconds in (["-m", "lappet", "--help"], spent), (["-c", "import click"], bare):
            begun = time.perf_counter()
            subprocess.run([sys.executable, *arguments], capture_output=True, check=True, timeout=60)
            seconds.append(time.perf_counter() - begun)
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


def test_public_names_are_there_and_importing_the_package_is_light() -> None:
    import lappet

    for name in lappet.__all__:
        assert getattr(lappet, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = lappet.nothing
    code = f"import sys, lappet; print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.strip() == "[]"


def test_new_takes_the_skin_around_a_point_and_says_what_it_found_repaired_and_took(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.icosphere(subdivisions=4, radius=80.0).export(tmp_path / "head.stl")
    done = run(
        *("new", tmp_path / "head.stl", "-o", tmp_path / "p.usda", "--units", "mm"),
        *("--at", "0", "0", "80", "--radius", "20", "--thickness", "4"),
    )
    assert done.exit_code == 0, done.output
    for words in ("found", "watertight", "repaired", "merged vertices", "taken", "20 mm of (0, 0, 80)", "thickness"):
        assert words in done.stdout
    tissue = read_procedure(tmp_path / "p.usda").tissue
    assert np.linalg.norm(tissue.points - (0.0, 0.0, 80.0), axis=1).max() < 21.0


@pytest.mark.parametrize("half", [("--at", "0", "0", "80"), ("--radius", "20")])
def test_a_point_without_a_radius_and_a_radius_without_a_point_are_refused(
    tmp_path: Path, half: tuple[str, ...]
) -> None:
    done = run("new", tmp_path / "head.stl", "-o", tmp_path / "p.usda", "--thickness", "4", *half)
    assert done.exit_code == 1
    assert is_one_sentence(done.stderr), done.stderr
    assert "--at X Y Z --radius MM" in done.stderr


def test_new_takes_the_skin_inside_an_outline_and_draws_it(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.icosphere(subdivisions=3, radius=80.0).export(tmp_path / "head.stl")
    turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    drawn = np.stack([25.0 * np.cos(turn), 15.0 * np.sin(turn), np.full(12, 77.0)], axis=1)
    (tmp_path / "outline.json").write_text(json.dumps(drawn.tolist()))
    done = run(
        *("new", tmp_path / "head.stl", "-o", tmp_path / "p.usda", "--units", "mm", "--thickness", "4"),
        *("--outline", tmp_path / "outline.json", "--picture", tmp_path / "picture.png"),
    )
    assert done.exit_code == 0, done.output
    assert "inside an outline of 12 points" in done.stdout
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    reach = np.ptp(read_procedure(tmp_path / "p.usda").tissue.points, axis=0)
    assert reach[:2] == pytest.approx([49.4, 30.0], abs=2.5)  # corners of the outline are rounded by triangles of 4 mm


@pytest.mark.skipif(os.name == "nt", reason="Windows has no signal of a reader that has left")
def test_a_reader_that_leaves_early_is_no_error_to_speak_of() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    said = subprocess.run(
        [sys.executable, "-m", "lappet", "flap", "list"], stdout=writing, stderr=subprocess.PIPE, check=False
    )
    os.close(writing)
    assert said.returncode == 1
    assert said.stderr == b""
