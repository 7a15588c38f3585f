"""What is compiled does not say where or when: a file of the daemon, compiled in two folders, gives the same object."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

COMMANDS = Path(__file__).resolve().parents[2] / "build" / "compile_commands.json"
FILE = "src/server/private_folder.cpp"


@pytest.mark.skipif(not COMMANDS.is_file(), reason="the daemon was not configured here")
def test_a_file_compiled_in_two_folders_gives_the_same_object(tmp_path: Path) -> None:
    entries = json.loads(COMMANDS.read_text(encoding="utf-8"))
    entry = next(each for each in entries if each["file"].endswith(f"solverd/{FILE}"))
    source = Path(entry["file"]).parents[2]
    objects = []
    for name in ("a", "a_longer_name"):
        copy = tmp_path / name
        shutil.copytree(source / "src", copy / "src")
        words = shlex.split(entry["command"].replace(f"{source}/src", f"{copy}/src"))
        made = copy / "made.o"
        words[words.index("-o") + 1] = str(made)
        subprocess.run(words, cwd=copy, check=True, timeout=300, env={**os.environ, "CCACHE_DISABLE": "1"})
        objects.append(made.read_bytes())
    assert objects[0] == objects[1]
