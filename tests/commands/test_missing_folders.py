"""No command makes the folder of a file that it is to write; each says which is missing, and leaves nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import synthetic_skin_cache as synthetic
from lappet.commands.cli import cli
from small_procedure import FakeSolver

# {p}: a procedure; {c}: a skin cache; {no}: a folder that is not there.
SOLVES = (
    *(("solve", "{p}", option, "{no}/s.csv") for option in ("--suture-forces", "--hook-forces", "--seams")),
    *(("solve", "{p}", option, "{no}/s.csv") for option in ("--reactions", "--sections")),
    ("solve", "{p}", "-o", "{no}/c.usdc"),
    ("solve", "{p}", "--report", "{no}/r.json"),
)
OTHERS = (
    ("new", "{p}", "-o", "{no}/new.usda"),
    ("models", "new", "patch", "-o", "{no}/patch.usda"),
    ("flap", "add", "rhomboid", "{p}", "--at", "0", "0", "4", "--direction", "1", "0", "0", "-o", "{no}/flap.usda"),
    ("plate", "{c}", "-o", "{no}/plate.svg"),
    ("film", "{c}", "-o", "{no}/film.gif"),
    ("film", "{c}", "-o", "{here}/film.gif", "--sheet", "{no}/sheet.png"),
    ("export", "{c}", "-o", "{no}/skin.stl"),
    ("compare", "{c}", "{c}", "--csv", "{no}/table.csv"),
    ("lesson", "{c}", "-o", "{no}/lesson.html"),
)


def refused(arguments: tuple[str, ...], tmp_path: Path, **places: Path) -> Result:
    """Run the command; nothing may be there that was not before."""
    missing = tmp_path / "none" / "deeper"
    before = sorted(tmp_path.rglob("*"))
    done = CliRunner().invoke(cli, [each.format(no=missing, here=tmp_path, **places) for each in arguments])
    assert done.exit_code == 1, done.output
    assert str(missing) in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert sorted(tmp_path.rglob("*")) == before
    return done


@pytest.mark.parametrize("arguments", SOLVES, ids=" ".join)
def test_solve_makes_no_folder_and_does_not_ask_the_solver(
    arguments: tuple[str, ...], procedure: Path, solver: FakeSolver, tmp_path: Path
) -> None:
    refused(arguments, tmp_path, p=procedure)
    assert solver.opened == 0


@pytest.mark.parametrize("arguments", OTHERS, ids=" ".join)
def test_no_other_command_makes_one_either(arguments: tuple[str, ...], procedure: Path, tmp_path: Path) -> None:
    cache = synthetic.write_cache(tmp_path / "cache", step=8.0) if "{c}" in arguments else tmp_path
    refused(arguments, tmp_path, p=procedure, c=cache)


def test_of_a_procedure_in_a_missing_folder_the_procedure_is_named(solver: FakeSolver, tmp_path: Path) -> None:
    done = refused(("solve", "{no}/p.usda"), tmp_path)
    assert "p.usda: " in done.stderr
    assert "cache" not in done.stderr
