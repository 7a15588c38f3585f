"""`lappet plate` writes the plate it was asked for, or one sentence and nothing."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from click.testing import CliRunner

import synthetic_skin_cache as synthetic
from lappet.commands.cli import cli


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
