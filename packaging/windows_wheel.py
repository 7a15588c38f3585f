"""Make Lappet's wheel for Windows on x86-64, around the daemon that packaging/windows/cross_build.sh has compiled.

    python packaging/windows_wheel.py FOLDER    puts the wheel there, for pip and for packaging/extension.py

What is not compiled comes from the build of the sources without CMake; to it are added the daemon with the library that
it loads, what the wheel of Linux has besides, the licenses of all that is linked, and a bill of materials. On Debian.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from urllib.parse import unquote

import sbom
import viewer
from carried_libraries import Carried
from lappet_wheel import COMMON_LICENSES, DEBIAN_DOCS, edited, metadata_folder
from pypi_wheels import ROOT
from system_versions import DebianPackage, installed

TAG = "py3-none-win_amd64"
WORK = ROOT / "build" / "windows"
PROGRAM, BLAS = "lappet-solverd.exe", "libscipy_openblas.dll"
SOURCES = ("onetbb", "suitesparse", "zeromq3")  # Debian's source packages that are linked into the program
# Whose headers are compiled in, and the run time of C and C++ that is linked into it.
HEADERS = ("cppzmq-dev", "libcli11-dev", "libeigen3-dev", "libfmt-dev", "libmsgpack-cxx-dev", "libspdlog-dev")
HEADERS += ("libxsimd-dev",)
RUN_TIME = ("gcc-mingw-w64-x86-64-posix", "mingw-w64-x86-64-dev")


def made(into: Path, work: Path = WORK) -> Path:
    """Make the wheel in the folder `into`.

    work: the folder of packaging/windows/cross_build.sh. Raises FileNotFoundError where that has not run, and
    CalledProcessError where the sources do not make a wheel; pip has printed why.
    """
    for name in (PROGRAM, BLAS):
        if not (work / "bin" / name).is_file():
            raise FileNotFoundError(f"{work / 'bin' / name} is missing; run packaging/windows/cross_build.sh first.")
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
        command += ["--config-settings=wheel.cmake=false", "--wheel-dir", folder, str(ROOT)]
        subprocess.run(command, check=True)
        (plain,) = Path(folder).glob("lappet-*.whl")
        return edited(plain, into, lambda unpacked: _add_daemon(unpacked, work))


def _add_daemon(folder: Path, work: Path) -> None:
    programs, demo, lessons = (folder / "lappet" / name for name in ("bin", "demo", "viewer"))
    for each in (programs, demo, lessons):
        each.mkdir(exist_ok=True)
    for name in (PROGRAM, BLAS):
        shutil.copyfile(work / "bin" / name, programs / name)
    shutil.copyfile(ROOT / "examples" / "z_plasty" / "z_plasty.usda", demo / "z_plasty.usda")
    shutil.copyfile(viewer.bundle(), lessons / "lesson.js")
    wheel = metadata_folder(folder) / "WHEEL"
    text = re.sub(r"^Tag: .*\n", "", wheel.read_text(encoding="utf-8"), flags=re.MULTILINE).rstrip()
    text = text.replace("Root-Is-Purelib: true", "Root-Is-Purelib: false")
    wheel.write_text(f"{text}\nTag: {TAG}\n", encoding="utf-8")
    libraries = linked(work)
    _add_licenses(metadata_folder(folder) / "licenses" / "libraries", libraries, work)
    bills = metadata_folder(folder) / "sboms"
    bills.mkdir(exist_ok=True)
    (bills / sbom.NAME).write_text(sbom.text(sbom.of_wheel(folder, libraries)), encoding="utf-8")


def linked(work: Path = WORK) -> list[Carried]:
    """What the daemon for Windows is made of besides Lappet: its BLAS, static libraries, run time and headers."""
    (blas,) = (work / "openblas").glob("scipy_openblas32-*.dist-info")
    version = blas.name.removesuffix(".dist-info").rpartition("-")[2]
    found = [Carried("scipy-openblas32", version, f"lappet/bin/{BLAS}", wheel=f"scipy-openblas32=={version}")]
    for name in SOURCES:
        (described,) = (work / "sources").glob(f"{name}_*.dsc")
        match = re.search(r"^Version: (\S+)$", described.read_text(encoding="utf-8"), flags=re.MULTILINE)
        assert match is not None, described
        package = DebianPackage(name, match[1], name, match[1], "source")
        found.append(Carried(name, match[1], debian=package, how="Compiled for Windows and linked into the daemon"))
    there = installed()
    for name in RUN_TIME:
        package = there[name]
        found.append(Carried(name, package.version, debian=package, how="Run time that is linked into the daemon"))
    return found + [Carried(name, there[name].version, debian=there[name]) for name in HEADERS]


def _add_licenses(folder: Path, libraries: list[Carried], work: Path) -> None:
    """Write the license of everything that is linked: Debian's copyright file, or what the wheel of BLAS ships."""
    folder.mkdir(parents=True, exist_ok=True)
    whole: set[str] = set()
    for one in libraries:
        if one.debian is None:
            (source,) = (work / "openblas").glob("scipy_openblas32-*.dist-info/licenses/LICENSE.txt")
        elif one.debian.architecture == "source":
            (source,) = (work / "sources").glob(f"{one.name}-*/debian/copyright")
        else:
            source = DEBIAN_DOCS / one.name / "copyright"
        text = source.read_text(encoding="utf-8")
        (folder / f"{unquote(one.name)}.txt").write_text(text, encoding="utf-8")
        whole |= set(re.findall(r"/usr/share/common-licenses/([\w.+-]*\w)", text))
    for name in sorted(whole):
        if (COMMON_LICENSES / name).is_file():
            shutil.copyfile(COMMON_LICENSES / name, folder / f"{name}.txt")


def main(arguments: list[str]) -> int:
    """The command. Returns the exit status."""
    if len(arguments) != 1:
        print("usage: windows_wheel.py FOLDER", file=sys.stderr)
        return 2
    folder = Path(arguments[0])
    try:
        with tempfile.TemporaryDirectory() as work:
            wheel = made(Path(work))
            folder.mkdir(parents=True, exist_ok=True)
            for old in folder.glob("lappet-*-win_amd64.whl"):
                old.unlink()
            print(shutil.copy2(wheel, folder))
    except FileNotFoundError as error:
        print(f"windows_wheel: {error}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"windows_wheel: {Path(error.cmd[0]).name} failed; its message is above.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
