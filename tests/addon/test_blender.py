"""Runs the tests inside Blender, each file of tests/blender in a process of its own: bpy and usd-core clash in one."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

_ROOT = Path(__file__).parents[2]
_FILES = sorted((_ROOT / "tests" / "blender").glob("test_*.py"))


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("file", _FILES, ids=lambda file: file.stem)
def test_what_must_hold_inside_blender(file: Path, tmp_path: Path) -> None:
    if importlib.util.find_spec("bpy") is None:
        pytest.skip("bpy is not installed: pip install 'lappet[render]'")
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        str(file),
        f"--confcutdir={file.parent}",
        f"--basetemp={tmp_path}/t",
    ]
    command += ["-p", "no:cacheprovider", "-p", "no:xdist"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    environment.setdefault("LAPPET_STORE", str(tmp_path / "store"))
    done = subprocess.run(command, cwd=_ROOT, env=environment, capture_output=True, text=True, check=False, timeout=850)
    assert done.returncode == 0, f"{file.name} failed:\n{done.stdout[-20_000:]}\n{done.stderr[-5_000:]}"
