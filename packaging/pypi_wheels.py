"""The wheels of other projects that go into the extension: which, for which platforms and Pythons, and their download.

Versions and hashes are those of packaging/lock.txt. What was downloaded once stays in `build/extension/pypi`.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

from locked import Locked, entries, locked

ROOT = Path(__file__).resolve().parent.parent
CACHE = ROOT / "build" / "extension"

# What `lappet` imports when the add-on drives it. numpy is Blender's own; a wheel of usd-core would stand before
# Blender's pxr for every add-on. trimesh reads mesh files for the command line; Blender reads them itself.
BUNDLED = ("manifold3d", "msgpack", "platformdirs", "pyzmq")
# Blender 4.5 and 5.0, Blender 5.1 and 5.2, and the Python that Debian builds its Blender 5.2 with: on Linux only.
PYTHONS = ("3.11", "3.13", "3.14")
OF_DEBIAN = ("3.14",)
# Blender's name of a platform -> what pip calls those whose wheels run there.
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "linux-arm64": ("manylinux_2_28_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64"),
    "macos-arm64": ("macosx_12_0_arm64",),
    "macos-x64": ("macosx_12_0_x86_64",),
    "windows-x64": ("win_amd64",),
}


def download(name: str, pythons: list[str], platform: str, cache: Path = CACHE) -> list[Path]:
    """The wheels of one locked package for these Pythons on a platform, each once; from the cache where they are there.

    name: on PyPI. pythons: as "3.11". platform: a key of PLATFORMS. Raises LookupError where the lock has no such
    package or PyPI no such wheel with a hash of the lock.
    """
    package = locked(name)
    wheels: list[Path] = []
    for python in pythons:
        if any(wheel.name.endswith("-py3-none-any.whl") for wheel in wheels):
            break
        folder = cache / "pypi" / platform / python / f"{name}-{package.version}"
        if not (found := [wheel for wheel in sorted(folder.glob("*.whl")) if package.allows(wheel)]):
            found = [_fetch(package, python, platform, folder)]
        if found[0].name not in [wheel.name for wheel in wheels]:  # a wheel may serve several Pythons
            wheels.append(found[0])
    return wheels


def bundled(platform: str, cache: Path = CACHE) -> list[Path]:
    """Every wheel of others that the extension for a platform carries, sorted by name."""
    pythons = [each for each in PYTHONS if platform.startswith("linux-") or each not in OF_DEBIAN]
    return sorted((w for name in BUNDLED for w in download(name, pythons, platform, cache)), key=lambda w: w.name)


def _fetch(package: Locked, python: str, platform: str, folder: Path) -> Path:
    command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
    command += ["--implementation=cp", f"--python-version={python}"]
    command += [f"--platform={tag}" for tag in PLATFORMS[platform]]
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent) as work:
        wanted, arrived = Path(work) / "requirements.txt", Path(work) / "arrived"
        wanted.write_text(entries([package]), encoding="utf-8")
        done = subprocess.run(
            [*command, f"--dest={arrived}", f"--requirement={wanted}"], capture_output=True, text=True, check=False
        )
        found = list(arrived.glob("*.whl"))
        if done.returncode or not found:
            said = done.stderr.strip() or "pip says nothing"
            raise LookupError(
                f"PyPI gives no wheel of {package.name} {package.version} with a hash of packaging/lock.txt for Python "
                f"{python} on {platform}: {said}"
            )
        folder.mkdir(exist_ok=True)
        return found[0].replace(folder / found[0].name)
