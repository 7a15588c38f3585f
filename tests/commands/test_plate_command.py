"""`lappet plate` writes the plate it was asked for, or one sentence and nothing."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner

import synthetic_skin_cache as synthetic
from lappet.commands.cli import cli
from lappet.procedure import Hook, Incision, Procedure, Suture
from lappet.tissue import flat_patch
from lappet.usd.stage import write_procedure


@pytest.fixture(scope="module")
def cache_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A skin cache made without the solver."""
    return synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=2.0)


def test_a_plate_is_written_with_the_captions_of_the_user(cache_file: Path, tmp_path: Path) -> None:
    target = tmp_path / "plate.svg"
    given = ["plate", str(cache_file), "-o", str(target), "--style", "ink", "--language", "de", "--no-labels"]
    result = CliRunner().invoke(cli, [*given, "--caption", "B=Nach dem Schnitt"])
    assert result.exit_code == 0, result.output
    texts = {"".join(each.itertext()) for each in ET.parse(target).iter("{http://www.w3.org/2000/svg}text")}
    assert {"Geplante Schnitte", "Nach dem Schnitt"} <= texts
    assert "wound bed" not in texts


def test_a_cache_that_is_not_there_is_one_sentence_and_no_file(tmp_path: Path) -> None:
    result = CliRunner().invoke(cli, ["plate", str(tmp_path / "none.usdc"), "-o", str(tmp_path / "plate.pdf")])
    assert result.exit_code == 1
    assert "none.usdc" in result.output
    assert not (tmp_path / "plate.pdf").exists()


def test_a_template_becomes_a_plate_of_the_procedure_and_is_drawn_from_its_cache(
    cache_file: Path, tmp_path: Path
) -> None:
    cache, procedure = tmp_path / "cache.usdc", tmp_path / "procedure.usda"
    shutil.copyfile(cache_file, cache)
    cut = Incision("cut", float(synthetic.INCISED), [(-20, 0, 0), (20, 0, 0)])
    lift = Hook("lift", (0, 3, 0), ((3.0, (0, 3, 0)), (7.0, (0, 9, 5))), 3.0, 8.0)
    stitch = Suture("stitch", ((0, -3, 0), (0, 3, 0)), 8.0)
    patch = flat_patch((100.0, 80.0, 4.0), spacing=4.0)
    patch = replace(patch, points=patch.points - np.array([0.0, 0.0, 4.0]))
    write_procedure(Procedure(patch, events=(cut, lift, stitch), end_time=12.0), procedure)
    target, at_once = tmp_path / "own.svg", tmp_path / "once.svg"
    run = CliRunner()
    missing = run.invoke(cli, ["plate", str(cache), "--plate", "steps", "-o", str(target)])
    assert (missing.exit_code, target.exists()) == (1, False)
    assert "no plate 'steps'" in missing.output
    added = run.invoke(cli, ["plate", str(procedure), "--template", "steps", "-o", str(procedure)])
    assert added.exit_code == 0, added.output
    assert "'steps' (plan, cut, raised, placed, sutured, result)" in added.output
    drawn = run.invoke(cli, ["plate", str(cache), "--plate", "steps", "--language", "fr", "-o", str(target)])
    assert drawn.exit_code == 0, drawn.output
    given = ["plate", str(cache), "--template", "steps", "--language", "fr", "-o", str(at_once)]
    assert run.invoke(cli, given).exit_code == 0
    assert at_once.read_bytes() == target.read_bytes()
    assert run.invoke(cli, [*given, "--plate", "steps"]).exit_code == 2


@pytest.mark.parametrize(
    ("command", "target", "package"), [("plate", "x.svg", "shapely"), ("film", "x.mp4", "drawsvg")]
)
def test_without_its_extra_a_command_says_how_to_get_it(
    cache_file: Path, tmp_path: Path, command: str, target: str, package: str
) -> None:
    program = (
        f"import sys; sys.modules[{package!r}] = None\n"
        "from lappet.commands.cli import cli\n"
        f"cli([{command!r}, {str(cache_file)!r}, '-o', {str(tmp_path / target)!r}])\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1
    assert package in done.stderr
    assert "pip install 'lappet[" in done.stderr
    assert not (tmp_path / target).exists()
