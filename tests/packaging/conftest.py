"""The extension's zip, made once a run for the tests that look into it."""

from __future__ import annotations

from pathlib import Path

import pytest

import lappet_wheel
import pypi_wheels
from extension import assemble
from folder_of_run import alone, folder_of_run


@pytest.fixture(scope="session")
def zip_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The zip for this machine."""
    folder = folder_of_run(tmp_path_factory, "dist")
    with alone(folder / "lock"):
        if made := list(folder.glob("*.zip")):
            return made[0]
        wheel = lappet_wheel.portable(lappet_wheel.built())
        platform = lappet_wheel.this_platform()
        return assemble(platform, wheel, folder, others=pypi_wheels.bundled(platform))
