"""The drawn plan of a flap: to scale, with letters as text, the same bytes each time."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from lappet.designs.flap_plan import flap_plan
from lappet.designs.library import DESIGNS
from lappet.output.plan_figure import write_plan_figure


def drawn(name: str, path: Path) -> Path:
    write_plan_figure(flap_plan(DESIGNS[name]), DESIGNS[name].lines, path)
    return path


def test_letters_and_scale_are_text_in_svg(tmp_path: Path) -> None:
    text = drawn("limberg", tmp_path / "plan.svg").read_text(encoding="utf-8")
    words = re.findall(r"<text[^>]*>([^<]*)</text>", text)
    assert {letter.text for letter in flap_plan(DESIGNS["limberg"]).letters} <= set(words)
    assert "10 mm" in words
    assert "<image" not in text


@pytest.mark.parametrize("suffix", [".svg", ".pdf"])
def test_the_same_plan_gives_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    first, second = (drawn("bilobed", tmp_path / f"{k}{suffix}").read_bytes() for k in range(2))
    assert first == second


def test_a_picture_is_as_wide_as_a_column_and_shows_what_is_excised(tmp_path: Path) -> None:
    picture = Image.open(drawn("fusiform", tmp_path / "plan.png")).convert("RGB")
    assert picture.width == pytest.approx(70.0 / 25.4 * 300.0, abs=2)
    pixels = np.asarray(picture).astype(int)
    skin = np.abs(pixels - np.array([0xE8, 0xC9, 0xBD])).max(axis=2) < 4
    plan = flap_plan(DESIGNS["fusiform"])
    (outline,) = plan.outlines
    x, y = outline.T
    area = 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))
    low, high = plan.bounds
    scale = picture.width / ((high - low)[0] * 1.32)  # a margin of 16 % on each side
    assert skin.sum() / scale**2 == pytest.approx(area, rel=0.08)  # the outline covers some
