"""The wheels of other projects that go into the extension: which, for which platforms and Pythons, and their download.

Versions are those of packaging/constraints.txt. What was downloaded once stays in `build/extension/pypi`.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CACHE = ROOT / "build" / "extension"
CONSTRAINTS = ROOT / "packaging" / "constraints.txt"

# What `lappet` imports when the add-on drives it. numpy is Blender's own; a wheel of usd-core would stand before
# Blender's pxr for every add-on. trimesh reads mesh files for the command line; Blender reads them itself.
BUNDLED = ("manifold3d", "msgpack", "platformdirs", "pyzmq")
# Blender 4.5 to 5.1, Blender 5.2, and the Python that Debian builds its Blender 5.2 with.
PYTHONS = ("3.11", "3.13", "3.14")
# Blender's name of a platform -> what pip calls those whose wheels run there.
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "linux-arm64": ("manylinux_2_28_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64"),
    "macos-arm64": ("macosx_14_0_arm64",),
    "macos-x64": ("macosx_14_0_x86_64",),
    "windows-x64": ("win_amd64",),
}


def pinned(name: str, constraints: Path = CONSTRAINTS) -> str:
    """The version of a package in the file of constraints. Raises LookupError, naming the file, where it has none."""
    match = re.search(rf"^{re.escape(name)}==(\S+)$", constraints.read_text(encoding="utf-8"), re.MULTILINE | re.I)
    if match is None:
        raise LookupError(f"{constraints} pins no version of {name}; add a line '{name}==VERSION'.")
    return match.group(1)


def download(name: str, pythons: list[str], platform: str, cache: Path = CACHE) -> list[Path]:
    """The wheels of one pinned package for these Pythons on a platform, each once; from the cache where they are there.

    name: on PyPI. pythons: as "3.11". platform: a key of PLATFORMS. Raises LookupError where PyPI has no such wheel.
    """
    version = pinned(name)
    wheels: list[Path] = []
    for python in pythons:
        if any(wheel.name.endswith("-py3-none-any.whl") for wheel in wheels):
            break
        folder = cache / "pypi" / platform / python / f"{name}-{version}"
        if not (found := sorted(folder.glob("*.whl"))):
            found = [_fetch(name, version, python, platform, folder)]
        if found[0].name not in [wheel.name for wheel in wheels]:  # a wheel may serve several Pythons
            wheels.append(found[0])
    return wheels


def bundled(platform: str, cache: Path = CACHE) -> list[Path]:
    """Every wheel of others that the extension for a platform carries, sorted by name."""
    return sorted((w for name in BUNDLED for w in download(name, list(PYTHONS), platform, cache)), key=lambda w: w.name)


def _fetch(name: str, version: str, python: str, platform: str, folder: Path) -> Path:
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
    command += ["--implementation=cp", f"--python-version={python}"]
    command += [f"--platform={tag}" for tag in PLATFORMS[platform]]
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent) as arrived:
        done = subprocess.run(
            [*command, f"--dest={arrived}", f"{name}=={version}"], capture_output=True, text=True, check=False
        )
        found = list(Path(arrived).glob("*.whl"))
        if done.returncode or not found:
            last = (done.stderr.strip().splitlines() or ["pip says nothing"])[-1]
            raise LookupError(f"PyPI gives no wheel of {name} {version} for Python {python} on {platform}: {last}")
        folder.mkdir(exist_ok=True)
        return found[0].replace(folder / found[0].name)
