"""Runs the tests inside Blender, some files of tests/blender to a process: bpy and usd-core clash in one.

Every process loads Blender, which takes as long as a small file of tests: so those files that are to be run go into as
many processes as there are groups. Each file has its own test here, which fails where one of its tests does.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import pytest

_ROOT = Path(__file__).parents[2]
_FILES = sorted((_ROOT / "tests" / "blender").glob("test_*.py"))
_GROUP = 9  # files to a process: where one ends Blender, the others are not run either


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
def test_what_must_hold_inside_blender(file: Path, request: pytest.FixtureRequest, processes: Processes) -> None:
    assert_held(file, request, processes)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("file", _OF_PROBLEMS, ids=lambda file: file.stem)
def test_it_holds_whatever_the_wording_of_the_problems(
    file: Path, request: pytest.FixtureRequest, processes: Processes
) -> None:
    assert_held(file, request, processes, ("LAPPET_SCRAMBLED_TEXTS", "1"))


@dataclass(frozen=True)
class Ran:
    """What a process did: how many tests of each file (its stem) were run, its status and what it printed."""

    tests: Counter[str]
    failed: frozenset[str]
    status: int
    said: str


Processes = Callable[..., Ran]


@pytest.fixture(scope="module")
def processes(tmp_path_factory: pytest.TempPathFactory) -> Processes:
    """The processes, each run once."""
    return cache(partial(run_inside_blender, tmp_path_factory))


def assert_held(file: Path, request: pytest.FixtureRequest, processes: Processes, *variables: tuple[str, str]) -> None:
    """Runs a file's group, unless another file of it did that, and shows what it printed where this file fails."""
    if importlib.util.find_spec("bpy") is None:
        pytest.skip("bpy is not installed: pip install 'lappet[render]'")
    asked = request.function.__name__
    chosen = [item.callspec.params["file"] for item in request.session.items if item.name.startswith(f"{asked}[")]
    start = chosen.index(file) // _GROUP * _GROUP
    ran = processes(tuple(chosen[start : start + _GROUP]), variables)
    held = ran.tests[file.stem] > 0 and file.stem not in ran.failed and ran.status in (0, 1)
    assert held, f"{file.name} failed:\n{ran.said}"


def run_inside_blender(
    folders: pytest.TempPathFactory, files: tuple[Path, ...], variables: tuple[tuple[str, str], ...]
) -> Ran:
    """Runs files of tests in a process of their own."""
    folder = folders.mktemp("blender")
    results = folder / "results.xml"
    command = [sys.executable, "-m", "pytest", "-q", *map(str, files), f"--confcutdir={files[0].parent}"]
    command += [f"--basetemp={folder}/t", f"--junitxml={results}", "-p", "no:cacheprovider", "-p", "no:xdist"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    environment |= dict(variables)
    environment.setdefault("LAPPET_STORE", str(folder / "store"))
    done = subprocess.run(command, cwd=_ROOT, env=environment, capture_output=True, text=True, check=False, timeout=850)
    cases = list(ET.parse(results).iter("testcase")) if results.is_file() else []  # none where Blender was ended

    def stem(case: ET.Element) -> str:
        return (case.get("classname") or case.get("name") or "").rpartition(".")[2]

    wrong = frozenset(stem(case) for case in cases for found in case if found.tag in ("failure", "error"))
    said = f"{done.stdout[-20_000:]}\n{done.stderr[-5_000:]}"
    return Ran(Counter(stem(case) for case in cases), wrong, done.returncode, said)
