"""A fresh Blender scene for every test; the add-on is registered once per process.

Blender and usd-core cannot live in one process, so nothing here may import usd-core's pxr: tests/addon/test_blender.py
runs these files in processes of their own, without the conftest above. By hand:
`python -m pytest --confcutdir=tests/blender tests/blender/test_X.py`.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import bpy
import pytest

import lappet_blender
from lappet.core import problem_text
from lappet.core.problem_code import ProblemCode

_plain = problem_text.text_of


def _scrambled(code: ProblemCode) -> problem_text.ProblemText:
    """The text of a code without a word of the catalogue."""
    return replace(_plain(code), message="Xq zvw.", remedy="Kj.")


if os.environ.get("LAPPET_SCRAMBLED_TEXTS"):  # for tests/addon/test_blender.py: no behavior depends on the wording
    problem_text.text_of = _scrambled


@pytest.fixture(scope="session", autouse=True)
def _own_store(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Frames solved by tests go to a folder of their own, unless the caller names one."""
    os.environ.setdefault("LAPPET_STORE", str(tmp_path_factory.mktemp("store")))


@pytest.fixture(scope="session")
def addon(_own_store: None) -> Iterator[None]:
    """The add-on, registered."""
    lappet_blender.register()
    yield
    lappet_blender.unregister()


@pytest.fixture
def scene(addon: None) -> bpy.types.Scene:
    """The scene of a new, empty file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return bpy.context.scene


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    """Where a test may save its file."""
    return tmp_path / "operation.blend"
