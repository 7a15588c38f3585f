"""The Python of child processes: this one's own, or the one beside the program that embeds it, with clean variables."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

import lappet
from lappet.core.interpreter import child_environment, find_python
from lappet.core.problem import RefusedError

VERSION = f"python{sys.version_info.major}.{sys.version_info.minor}"


def program(path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("#!/bin/sh\n")
    path.chmod(0o755)
    return path


def test_a_python_process_uses_its_own_interpreter() -> None:
    assert find_python() == Path(sys.executable)


@pytest.mark.parametrize("executable", ["", "/opt/blender/blender", "C:/Blender/blender.exe"])
@pytest.mark.parametrize("place", [f"bin/{VERSION}", "bin/python.exe", "python.exe"])
def test_an_embedded_python_is_found_under_its_prefix(
    executable: str, place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    expected = program(tmp_path / place)
    monkeypatch.setattr(sys, "executable", executable)
    for name in ("prefix", "exec_prefix", "base_prefix"):
        monkeypatch.setattr(sys, name, str(tmp_path))
    assert find_python() == expected


def test_where_there_is_no_interpreter_the_refusal_says_where_it_looked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "")
    for name in ("prefix", "exec_prefix", "base_prefix"):
        monkeypatch.setattr(sys, name, str(tmp_path))
    with pytest.raises(RefusedError, match=str(tmp_path)):
        find_python()


def test_no_variable_of_the_owner_changes_the_workers_python() -> None:
    mine = {"PYTHONHOME": "/elsewhere", "PYTHONPATH": "/elsewhere", "PYTHONSTARTUP": "x.py", "HOME": "/home/me"}
    got = child_environment(mine, ["/wheels", "/wheels"], Path("/opt/solverd"))
    assert got == {
        "HOME": "/home/me",
        "PYTHONPATH": os.pathsep.join(["/wheels", str(Path(lappet.__file__).parent.parent)]),
        "LAPPET_SOLVERD": str(Path("/opt/solverd")),
    }
