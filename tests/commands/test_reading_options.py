"""What the commands may read: outside a file's folder, and how much, only as their options say."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lappet.commands.cli import cli
from lappet.core.problem import problem
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits
from lappet.usd.stage import write_procedure
from small_procedure import small_procedure

COMMANDS = {
    "check": ["check", "in/p.usda"],
    "inspect": ["inspect", "in/p.usda", "--no-lattice"],
    "solve": ["solve", "in/p.usda", "-o", "p.usdc"],
    "new": ["new", "in/p.usda", "-o", "new.usda"],
    "render": ["render", "in/p.usda", "-o", "pictures"],
}


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments)


@pytest.fixture
def outside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`in/p.usda` is a layer over a procedure that lies outside of its folder."""
    monkeypatch.chdir(tmp_path)
    Path("in").mkdir()
    write_procedure(small_procedure(), "sound.usda")
    times = 'startTimeCode = 1\n    endTimeCode = 5\n    metersPerUnit = 0.001\n    upAxis = "Z"'
    Path("in/p.usda").write_text(f"#usda 1.0\n(\n    {times}\n    subLayers = [@../sound.usda@]\n)\n")


@pytest.mark.usefixtures("outside")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_leaves_the_folder_of_a_file_only_where_it_is_allowed(command: str) -> None:
    refused = run(*COMMANDS[command])
    folder, file = Path("in").resolve(), str(Path("in/p.usda").resolve())
    assert refused.exit_code == 1
    assert str(problem(ProblemCode.READ_OUTSIDE, file, "../sound.usda", folder=folder)) in refused.output
    if command in ("check", "inspect", "new"):  # the others need a daemon or Blender
        done = run(*COMMANDS[command], "--allow-external")
        assert done.exit_code == 0, done.output


@pytest.mark.usefixtures("outside")
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_reads_as_much_as_its_options_say(command: str) -> None:
    shutil.copyfile("sound.usda", "in/p.usda")
    with Path("in/p.usda").open("a") as file:
        file.write("\n" * (3 << 20))
    refused = run(*COMMANDS[command], "--read-size", "2")
    assert refused.exit_code == 1
    assert "the limit is 2 MiB" in refused.output
    assert "--read-size" in refused.output


def test_options_reach_the_limits_by_their_units(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[ReadLimits] = []
    monkeypatch.setattr("lappet.program.full_check.full_check", lambda path, notes, limits: given.append(limits) or [])
    assert run("check", "p.usda").exit_code == 0
    assert run("check", "p.usda", "--read-memory", "1.5", "--read-seconds", "7", "--read-size", "3").exit_code == 0
    assert given == [ReadLimits(), ReadLimits(memory=3 << 29, seconds=7, size=3 << 20)]
