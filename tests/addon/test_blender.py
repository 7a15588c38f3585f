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


# The files that say what is found wrong and what is refused.
_OF_PROBLEMS = [
    file
    for file in _FILES
    if file.stem
    in (
        "test_interface_refusals",
        "test_tissue_problems",
        "test_tissue_check",
        "test_tissue_operators",
        "test_tissue_panels",
        "test_events_operators",
        "test_solving_panel",
        "test_solving_states",
    )
]


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("file", _FILES, ids=lambda file: file.stem)
def test_what_must_hold_inside_blender(file: Path, tmp_path: Path) -> None:
    run_inside_blender(file, tmp_path, {})


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("file", _OF_PROBLEMS, ids=lambda file: file.stem)
def test_it_holds_whatever_the_wording_of_the_problems(file: Path, tmp_path: Path) -> None:
    run_inside_blender(file, tmp_path, {"LAPPET_SCRAMBLED_TEXTS": "1"})


def run_inside_blender(file: Path, tmp_path: Path, variables: dict[str, str]) -> None:
    """Runs a file of tests in a process of its own and shows what it printed where it fails."""
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
    environment |= variables
    environment.setdefault("LAPPET_STORE", str(tmp_path / "store"))
    done = subprocess.run(command, cwd=_ROOT, env=environment, capture_output=True, text=True, check=False, timeout=850)
    assert done.returncode == 0, f"{file.name} failed:\n{done.stdout[-20_000:]}\n{done.stderr[-5_000:]}"
