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


@pytest.mark.parametrize(
    ("command", "work"),
    [
        ("models new cheek -o TARGET.usda", "lappet.models.new_model.new_model"),
        ("new CACHE -o TARGET.usda", "lappet.tissue.tissue_from_mesh.new_tissue"),
        ("new CACHE -o x.usda --picture TARGET.png", "lappet.tissue.tissue_from_mesh.new_tissue"),
        ("flap add limberg -o TARGET.usda", "lappet.designs.library_operation.flap_on_patch"),
        ("flap edit limberg PROCEDURE -o TARGET.usda", "lappet.designs.laid_flaps.relay"),
        ("flap show limberg --picture TARGET.svg", "lappet.designs.flap_plan.flap_plan"),
        ("plate CACHE -o TARGET.svg", "lappet.plates.draw_plate.open_cache"),
        ("film CACHE -o TARGET.mp4", "lappet.plates.draw_film.open_cache"),
        ("export CACHE -o TARGET.glb", "lappet.export.glb_file.write_glb"),
        ("compare CACHE -o TARGET.svg", "lappet.usd.cache_end.read_cache_end"),
        ("compare CACHE --csv TARGET.csv", "lappet.usd.cache_end.read_cache_end"),
        ("solve PROCEDURE -o x.usdc --seams TARGET.csv", "lappet.commands.run_solve.run_solve"),
    ],
)
@pytest.mark.parametrize("place", ["none", "/proc"], ids=["missing", "unwritable"])
def test_a_folder_that_takes_no_file_is_refused_once_and_before_any_work(
    command: str, work: str, place: str, cache_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    worked: list[object] = []
    monkeypatch.setattr(work, lambda *given, **_: worked.append(given))
    names = {"CACHE": str(cache_file), "PROCEDURE": str(PROCEDURE)}
    words = [names.get(each, each.replace("TARGET", f"{place}/it")) for each in command.split()]
    result = CliRunner().invoke(cli, words)
    assert result.exit_code == 1, result.output
    assert worked == []
    assert result.stderr.count(f"{place}/it") == 1, result.stderr
    assert not list(tmp_path.iterdir())
