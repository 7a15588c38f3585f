"""A disk that is full is noticed by every writer: exit status 1, a sentence with the file, and no file cut short."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import trimesh

from lappet.commands.cli import cli
from lappet.usd.stage import write_procedure
from small_procedure import small_procedure

SMALL = 'mount -t tmpfs -o size="$1" none "$0"; seen="$2"; shift 2; "$@"; status=$?; ls -A "$0" >"$seen"; exit $status'


def mountable(folder: Path) -> bool:
    """Whether this user may mount a small disk in a namespace of their own."""
    try:
        command = ["unshare", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "-o", "size=4k", "none", folder]
        return subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        return False


@pytest.fixture
def disk(tmp_path: Path) -> Path:
    """The mount point of a small disk."""
    folder = tmp_path / "small"
    folder.mkdir()
    if not mountable(folder):
        pytest.skip("this user may not mount anything")
    write_procedure(small_procedure(), tmp_path / "p.usda")
    trimesh.creation.box((30, 30, 30)).subdivide().subdivide().export(tmp_path / "box.stl")
    return folder


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A skin cache of three frames."""
    folder = tmp_path_factory.mktemp("solved")
    write_procedure(small_procedure(), folder / "p.usda")
    command = [sys.executable, "-m", "lappet", "solve", "p.usda", "-o", "s.usdc", "--spacing", "2", "--frames", "1:3"]
    environment = {**os.environ, "LAPPET_STORE": str(folder / "store")}
    subprocess.run(command, cwd=folder, capture_output=True, check=True, env=environment)
    return folder / "s.usdc"


CASES = {
    "a procedure as text": ("4k", "new {up}/box.stl -o {disk}/n.usda --units mm --spacing 3", "n.usda"),
    "the picture of a mesh": (
        "24k",
        "new {up}/box.stl -o {disk}/n.usdc --units mm --spacing 3 --picture {disk}/n.png",
        "n.png",
    ),
    "a plan as SVG": ("4k", "flap show limberg --picture {disk}/f.svg", "f.svg"),
    "a plan as PDF": ("4k", "flap show limberg --picture {disk}/f.pdf", "f.pdf"),
    "a model": ("4k", "models new patch -o {disk}/m.usda", "m.usda"),
    "a skin cache": ("4k", "solve {up}/p.usda -o {disk}/s.usdc --spacing 2 --frames 1:3", "s.usdc"),
    "a skin cache as text": ("8k", "solve {up}/p.usda -o {disk}/s.usda --spacing 2 --frames 1:3", "s.usda"),
    "a report": (
        "4k",
        "solve {up}/p.usda -o {up}/s.usdc --report {disk}/r.json --spacing 2 --frames 1:3",
        "r.json",
    ),
    "a lesson": ("64k", "export {cache} -o {disk}/l.html", "l.html"),
    "a lesson for a learning platform": ("64k", "export {cache} -o {disk}/l.zip", "l.zip"),
    "a scene": ("24k", "export {cache} -o {disk}/s.glb", "s.glb"),
    "the plan of a lesson": ("4k", "lesson {cache} {cache} {cache} {cache} --template {disk}/l.toml", "l.toml"),
    "a report of measurements": ("8k", "report tissues -o {disk}", "tissues.md"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_full_disk_is_a_sentence_and_leaves_no_file_that_is_cut_short(
    case: str, disk: Path, cache: Path, tmp_path: Path
) -> None:
    size, line, name = CASES[case]
    arguments = [each.format(up=tmp_path, disk=disk, cache=cache) for each in line.split()]
    assert arguments[0] in cli.commands
    seen = tmp_path / "seen"
    small = ["unshare", "--map-root-user", "--mount", "sh", "-c", SMALL, disk, size, seen]
    done = subprocess.run(
        [*small, sys.executable, "-m", "lappet", *arguments],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "LAPPET_STORE": str(tmp_path / "store")},
    )
    assert done.returncode == 1, done.stderr
    last = done.stderr.strip().splitlines()[-1]
    assert "No space left on device" in last
    assert f"{disk}/{name}" in last  # and not a draft of it, which nobody has heard of
    assert name not in seen.read_text().split()
    assert not [each for each in seen.read_text().split() if each.endswith(".part")]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is full")
@pytest.mark.parametrize("arguments", [["--help"], ["completion", "bash"], ["flap", "list"]])
def test_what_cannot_be_printed_is_a_sentence_without_a_traceback(arguments: list[str]) -> None:
    command = [sys.executable, "-c", "from lappet.commands.cli import main; main()", *arguments]
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == 1
    assert "No space left on device" in done.stderr
    assert "Traceback" not in done.stderr
