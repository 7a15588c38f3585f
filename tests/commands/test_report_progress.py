"""A report says what it solves while it does: bars on a terminal, elsewhere a line as each solve begins and ends."""

from __future__ import annotations

import contextlib
from pathlib import Path

import pytest
from rich.console import Console

from command_runs import run
from lappet.commands.report_progress import BarReportProgress
from lappet.commands.solve_progress import solve_bar
from lappet.core.problem import problem
from lappet.core.problem_code import ProblemCode
from lappet.daemon.frame_solver import Iteration
from lappet.tissue.presets import SKIN
from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure


def test_elsewhere_than_on_a_terminal_each_solve_has_a_line_as_it_begins_and_as_it_ends(
    solver: FakeSolver, tmp_path: Path
) -> None:
    for name in ("one", "other"):
        write_procedure(small_procedure(materials=(SKIN.unstretched,)), tmp_path / f"{name}.usda")
    done = run("report", "surroundings", tmp_path / "one.usda", tmp_path / "other.usda", "-o", tmp_path / "report")
    assert done.exit_code == 0, done.output
    lines = done.stderr.splitlines()
    assert lines[::2] == ["one_held (1 of 4)", "one_free (2 of 4)", "other_held (3 of 4)", "other_free (4 of 4)"]
    assert [line.partition(" frames")[0] for line in lines[1::2]] == [
        "one_held: 8", "one_free: 8", "other_held: 8", "other_free: 8",
    ]  # fmt: skip


def test_a_terminal_gets_a_bar_of_the_solves_and_one_of_the_frames_of_the_present_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bars = solve_bar()
    monkeypatch.setattr("lappet.commands.report_progress.solve_bar", lambda: bars)

    def shown() -> list[str]:
        console = Console(width=120)
        with console.capture() as capture:
            console.print(bars.get_renderable())
        return capture.get().splitlines()

    with BarReportProgress() as progress:
        progress.begin(2)
        first = progress.solve("limberg [left]")
        assert "0/2" in shown()[0]
        assert shown()[1].startswith("limberg [left]")  # before its number of frames is known
        first.begin(24)
        first.iteration(Iteration(3.0, 5, 1e-3, 0.0))
        assert "0/24" in shown()[1]
        assert "frame 3: iteration 5, residual 1.0e-03" in shown()[1]
        first.note(problem(ProblemCode.ESTIMATE_SKIPPED, "", "-"))
        progress.say("limberg [left]: 24 of 24 frames converged.")
        progress.solve("v-y").begin(9)
        assert "1/2" in shown()[0]
        assert [line.split()[0] for line in shown()] == ["solves", "v-y"]
        assert "0/9" in shown()[1]
    printed = capsys.readouterr().err
    assert printed.splitlines()[0] == "limberg [left]: 24 of 24 frames converged."
    assert "2/2" in printed
    assert "24/24" not in printed


def test_a_report_that_is_stopped_does_not_count_the_solve_that_it_was_in(capsys: pytest.CaptureFixture[str]) -> None:
    progress = BarReportProgress()
    with contextlib.suppress(KeyboardInterrupt), progress:
        progress.begin(2)
        progress.solve("limberg")
        progress.solve("v-y")
        raise KeyboardInterrupt
    assert "1/2" in capsys.readouterr().err
