"""The extension's zip, made once for the tests that look into it."""

from __future__ import annotations

from pathlib import Path

import pytest

import lappet_wheel
import pypi_wheels
from extension import assemble


@pytest.fixture(scope="session")
def zip_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The zip for this machine."""
    wheel = lappet_wheel.portable(lappet_wheel.built())
    platform = lappet_wheel.this_platform()
    return assemble(platform, wheel, tmp_path_factory.mktemp("dist"), others=pypi_wheels.bundled(platform))
