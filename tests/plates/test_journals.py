"""A plate keeps the rules of a publisher, or is refused before it is drawn."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from PIL import Image

from lappet.core.problem_code import ProblemCode
from lappet.plates.draw_plate import PlateOptions, draw_plate
from lappet.plates.journals import journal_of
from lappet.plates.plate_style import POINT
from lappet.procedure.plate import JOURNALS
from refusals import refuses

WIDEST = {"springer": 174.0, "elsevier": 190.0, "plos": 190.5}


@pytest.mark.parametrize("name", JOURNALS)
def test_width_letters_and_text_are_those_of_the_publisher(cache_file: Path, tmp_path: Path, name: str) -> None:
    picture = tmp_path / "plate.svg"
    draw_plate([cache_file], [picture], PlateOptions(style="ink", journal=name))
    svg = picture.read_text()
    assert float(re.search(r'width="([\d.]+)mm"', svg).group(1)) == WIDEST[name]  # type: ignore[union-attr]
    letter = "a" if name == "springer" else "A"
    assert f'id="caption-{letter}"' in svg
    least, most = journal_of(name).text
    sizes = {float(each) for each in re.findall(r'font-size="([\d.]+)"', svg)}
    assert min(sizes) == pytest.approx(least * POINT, abs=1e-3)
    assert max(sizes) <= (most + 0.5) * POINT


def test_a_bitmap_has_the_pixels_that_the_publisher_asks(cache_file: Path, tmp_path: Path) -> None:
    picture = tmp_path / "plate.tif"
    drawn = draw_plate(
        [cache_file], [picture], PlateOptions(journal="plos", frames=(1.0,), shown={"width": 85.0, "columns": 1})
    )
    with Image.open(picture) as image:
        assert image.size[0] == pytest.approx(85.0 / 25.4 * 300.0, abs=2.0)
        assert image.mode == "RGB"
        assert image.info["compression"] == "tiff_lzw"
    assert [note.code for note in drawn.notes] == [ProblemCode.PLATE_JOURNAL_FONT]


@pytest.mark.parametrize(
    ("options", "code"),
    [
        (PlateOptions(journal="nature"), ProblemCode.PLATE_JOURNAL),
        (PlateOptions(journal="springer", shown={"width": 100.0}), ProblemCode.PLATE_JOURNAL_WIDTH),
        (PlateOptions(journal="plos", text=7.0), ProblemCode.PLATE_JOURNAL_TEXT),
        (PlateOptions(journal="plos", text=12.0), ProblemCode.PLATE_JOURNAL_TEXT),
        (PlateOptions(journal="elsevier", dpi=300), ProblemCode.PLATE_JOURNAL_DPI),
        (PlateOptions(journal="plos", dpi=1200), ProblemCode.PLATE_JOURNAL_DPI),
        (PlateOptions(journal="plos", shown={"width": 150.0, "columns": 1}), ProblemCode.PLATE_JOURNAL_HEIGHT),
        (PlateOptions(text=6.0), ProblemCode.PLATE_TEXT),
    ],
)
def test_what_the_publisher_would_send_back_is_refused(
    cache_file: Path, tmp_path: Path, options: PlateOptions, code: ProblemCode
) -> None:
    with refuses(code):
        draw_plate([cache_file], [tmp_path / "plate.tif"], options)
    assert not (tmp_path / "plate.tif").exists()


def test_a_format_that_is_not_taken_is_said(cache_file: Path, tmp_path: Path) -> None:
    drawn = draw_plate([cache_file], [tmp_path / "plate.svg"], PlateOptions(journal="springer"))
    assert ProblemCode.PLATE_JOURNAL_FORMAT in [note.code for note in drawn.notes]
    assert all(note.severity == "note" for note in drawn.notes)


def test_text_is_as_large_as_it_is_wanted(cache_file: Path, tmp_path: Path) -> None:
    draw_plate([cache_file], [tmp_path / "plate.svg"], PlateOptions(text=10.0, shown={"columns": 2}))
    svg = (tmp_path / "plate.svg").read_text()
    sizes = {float(each) for each in re.findall(r'font-size="([\d.]+)"', svg)}
    assert sorted(sizes) == pytest.approx([10.0 * POINT, 11.0 * POINT, 11.5 * POINT], abs=1e-3)
