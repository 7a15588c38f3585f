"""A skin cache made without the solver, and the lesson of it."""

from __future__ import annotations

from pathlib import Path

import pytest

import synthetic_skin_cache as synthetic
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export


@pytest.fixture(scope="session")
def skin_cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A slit that hooks pull open and sutures close, with every quantity."""
    return synthetic.write_cache(tmp_path_factory.mktemp("cache"), step=4.0)


@pytest.fixture(scope="session")
def lesson_file(skin_cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The lesson of that cache."""
    target = tmp_path_factory.mktemp("lesson") / "lesson.html"
    assert export(ExportRequest((skin_cache,), target, {"title": "Slit <b> & suture"})) == [target]
    return target
