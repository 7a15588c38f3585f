"""Whatever writes files of several kinds refuses another kind, and names all that there are."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

import synthetic_skin_cache as synthetic
from lappet.commands.cli import cli
from lappet.export.formats import EXPORTERS, FILMS

PROCEDURE = Path(__file__).parents[2] / "examples" / "z_plasty" / "z_plasty.usda"
PLATES = (".svg", ".pdf", ".png", ".tif", ".tiff")
MOVIES = (*FILMS, ".png")
USD = (".usda", ".usdc", ".usd")


@pytest.fixture(scope="module")
def cache_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A skin cache made without the solver."""
    return synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=8.0)


@pytest.mark.parametrize(
    ("command", "known"),
    [
        ("export CACHE -o TARGET", (*(each.suffix for each in EXPORTERS), *FILMS)),
        ("film CACHE -o TARGET", MOVIES),
        ("film CACHE -o x.mp4 --sheet TARGET", (".png", ".tif", ".tiff")),
        ("plate CACHE -o TARGET", PLATES),
        ("plate CACHE -o TARGET --template steps", (*PLATES, *USD)),
        ("plate CACHE -o x.svg --movie TARGET", MOVIES),
        ("compare CACHE -o TARGET", (".png", ".svg", ".pdf")),
        ("flap show limberg --picture TARGET", (".svg", ".pdf", ".png")),
        ("flap add limberg -o TARGET", USD),
        ("new CACHE -o x.usda --picture TARGET", (".png",)),
        ("solve PROCEDURE -o TARGET", USD),
    ],
)
def test_a_kind_of_file_that_is_not_known_is_refused_with_those_that_are(
    command: str, known: tuple[str, ...], cache_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names = {"CACHE": str(cache_file), "PROCEDURE": str(PROCEDURE), "TARGET": "target.docx"}
    result = CliRunner().invoke(cli, [names.get(each, each) for each in command.split()])
    assert result.exit_code in (1, 2), result.output
    assert set(known) <= set(re.findall(r"\.\w+", result.stderr)), result.stderr
    assert "Lappet failed" not in result.stderr
    assert result.stderr.splitlines()[0].strip()  # no line of a bar that nobody sees
    assert not list(tmp_path.iterdir())
