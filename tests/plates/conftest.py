"""What the tests of plates share: a solved incision without the solver, and a plate of it."""

from __future__ import annotations

from pathlib import Path

import pytest

import synthetic_skin_cache as synthetic
from lappet.drawing.skin_read import SkinCache
from lappet.plates.plate_cache import chosen_steps, open_cache
from lappet.plates.plate_font import PlateFont
from lappet.plates.plate_page import PlatePage, plate_page
from lappet.plates.plate_request import PlateRequest, PlateRow
from lappet.plates.plate_style import plate_style
from lappet.plates.plate_words import plate_words


@pytest.fixture(scope="session")
def cache_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A skin cache made without the solver."""
    return synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=2.0)


@pytest.fixture(scope="session")
def cache(cache_file: Path) -> SkinCache:
    """The same, open."""
    return open_cache(cache_file)


@pytest.fixture(scope="session")
def font() -> PlateFont:
    """The font of plates."""
    return PlateFont()


@pytest.fixture(scope="session")
def page(cache: SkinCache, font: PlateFont) -> PlatePage:
    """A plate of all steps in ink."""
    request = PlateRequest((PlateRow(cache, chosen_steps(cache)),), {})
    return plate_page(request, plate_style("ink"), plate_words("en"), font)
