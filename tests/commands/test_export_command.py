"""`lappet export` writes the file it was asked for, or one sentence and nothing."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import synthetic_skin_cache as synthetic
from lappet.commands.cli import cli
from lappet.export.formats import FILMS


@pytest.fixture(scope="module")
def cache_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A skin cache made without the solver."""
    return synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=8.0)


def export(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["export", *map(str, arguments)])


def test_a_lesson_is_written_and_named(cache_file: Path, tmp_path: Path) -> None:
    target = tmp_path / "lesson.html"
    result = export(cache_file, "-o", target, "--title", "Ein Schnitt", "--language", "de", "--frames", "1,7,12")
    assert result.exit_code == 0, result.output
    assert result.output == f"{target}\n"
    page = target.read_text(encoding="utf-8")
    assert '<html lang="de">' in page
    assert "<title>Ein Schnitt</title>" in page
    assert [path.name for path in tmp_path.iterdir()] == ["lesson.html"]


@pytest.mark.parametrize("suffix", FILMS)
def test_a_film_is_drawn_as_the_command_for_films_does(
    suffix: str, cache_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[tuple[Path, Path, dict[str, str]]] = []
    monkeypatch.setattr(
        "lappet.commands.export_command.draw_with_progress",
        lambda cache, film, options, limits: drawn.append((cache, film, options)),
    )
    target = tmp_path / f"film{suffix}"
    result = export(cache_file, "-o", target, "--title", "Ein Schnitt", "--language", "de")
    assert result.exit_code == 0, result.output
    assert drawn == [(cache_file, target, {"title": "Ein Schnitt", "language": "de"})]
    for refused in (("--simplify", "2000"), ("--max-size", "5MB"), (cache_file,)):
        result = export(cache_file, "-o", target, *refused)
        assert result.exit_code == 2, result.output
    assert len(drawn) == 1


def test_an_unknown_suffix_is_one_sentence_that_lists_the_known_ones(cache_file: Path, tmp_path: Path) -> None:
    result = export(cache_file, "-o", tmp_path / "lesson.docx")
    assert result.exit_code == 1
    assert len(result.output.splitlines()) == 1
    assert "'.docx'" in result.output
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["none.usdc", "broken.usdc"])
def test_what_is_no_cache_is_one_sentence_and_no_file(name: str, tmp_path: Path) -> None:
    (tmp_path / "broken.usdc").write_bytes(b"PXR-USDC" + bytes(80))
    result = export(tmp_path / name, "-o", tmp_path / "lesson.html")
    assert result.exit_code == 1
    assert name in result.output
    assert not (tmp_path / "lesson.html").exists()


def test_a_package_for_augmented_reality_is_written_and_its_error_said_in_mm(cache_file: Path, tmp_path: Path) -> None:
    target = tmp_path / "skin.usdz"
    result = export(cache_file, "-o", target, "--frames", "1,7,12", "--tolerance-mm", "0.4", "--no-instruments")
    assert result.exit_code == 0, result.output
    assert "note: " in result.output
    assert " mm away from the cache at most" in result.output
    assert [path.name for path in tmp_path.iterdir()] == ["skin.usdz"]


def test_a_quantized_file_is_written_and_its_error_said_in_mm(cache_file: Path, tmp_path: Path) -> None:
    target = tmp_path / "skin.glb"
    result = export(cache_file, "-o", target, "--quantized")
    assert result.exit_code == 0, result.output
    assert " mm away from the cache at most" in result.output
    assert target.exists()
