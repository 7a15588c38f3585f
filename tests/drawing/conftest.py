"""What tests of the drawing share."""

from __future__ import annotations

import pytest

import synthetic_skin_cache as synthetic
from lappet.drawing.skin_read import SkinCache


@pytest.fixture(scope="session")
def cache(tmp_path_factory: pytest.TempPathFactory) -> SkinCache:
    """A skin cache made without the solver."""
    pytest.importorskip("pxr")
    return SkinCache(synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=2.0))
