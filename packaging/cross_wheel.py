"""Make Lappet's wheel for a platform, around the daemon that packaging/cross/build.sh has compiled for it.

    python packaging/cross_wheel.py TARGET FOLDER    puts the wheel there, for pip and for packaging/extension.py

What is not compiled comes from the build of the sources without CMake; to it are added the daemon with the BLAS that it
loads, what the wheel of Linux has besides, the licenses of all that is linked, and a bill of materials. On Debian.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

import sbom
import viewer
from carried_libraries import Carried
from lappet_wheel import COMMON_LICENSES, DEBIAN_DOCS, edited, metadata_folder
from pypi_wheels import ROOT
from system_versions import DebianPackage, installed

WORK = ROOT / "build" / "cross"


@dataclass(frozen=True)
class Target:
    """What packaging/cross/build.sh makes for a platform."""

    tag: str  # of the wheel
    blas: str  # the library beside the program
    program: str = "lappet-solverd"
    compiler: str = "ziglang"


# By Blender's names of the platforms. macOS 12 and the C library of 2018, as packaging/cross/toolchain.cmake says.
TARGETS = {
    "linux-arm64": Target("py3-none-manylinux_2_28_aarch64", "libscipy_openblas.so"),
    "linux-x64": Target("py3-none-manylinux_2_28_x86_64", "libscipy_openblas.so"),
    "macos-arm64": Target("py3-none-macosx_12_0_arm64", "libscipy_openblas.dylib"),
    "macos-x64": Target("py3-none-macosx_12_0_x86_64", "libscipy_openblas.dylib"),
    "windows-x64": Target("py3-none-win_amd64", "libscipy_openblas.dll", "lappet-solverd.exe", "mingw-w64"),
}
SOURCES = ("onetbb", "suitesparse", "zeromq3")  # Debian's source packages that are linked into the program
# Whose headers are compiled in, and the run time of C and C++ that is linked into the program for Windows.
HEADERS = ("cppzmq-dev", "libcli11-dev", "libeigen3-dev", "libfmt-dev", "libmsgpack-cxx-dev", "libspdlog-dev")
HEADERS += ("libxsimd-dev",)
MINGW = ("gcc-mingw-w64-x86-64-posix", "mingw-w64-x86-64-dev")
# In the wheel ziglang: the licenses of what its compiler links into a program.
ZIG_LICENSES = ("LICENSE", "lib/libcxx/LICENSE.TXT", "lib/libc/glibc/LICENSES")


def made(target: str, into: Path, work: Path = WORK, root: Path = ROOT) -> Path:
    """Make the wheel for a target in the folder `into`.

    target: a key of TARGETS. work: the folder of packaging/cross/build.sh. root: the sources' folder. Raises
    FileNotFoundError where build.sh has not run, and CalledProcessError where the sources do not make a wheel; pip has
    printed why.
    """
    for path in programs(target, work):
        if not path.is_file():
            raise FileNotFoundError(f"{path} is missing; run packaging/cross/build.sh {target} first.")
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
        command += ["--config-settings=wheel.cmake=false", "--wheel-dir", folder, str(root)]
        subprocess.run(command, check=True)
        (plain,) = Path(folder).glob("lappet-*.whl")
        return edited(plain, into, lambda unpacked: _add_daemon(unpacked, target, work))


def programs(target: str, work: Path = WORK) -> tuple[Path, Path]:
    """The daemon and its BLAS, as packaging/cross/build.sh leaves them."""
    return work / target / "bin" / TARGETS[target].program, work / target / "bin" / TARGETS[target].blas


def _add_daemon(folder: Path, target: str, work: Path) -> None:
    binaries, demo, lessons = (folder / "lappet" / name for name in ("bin", "demo", "viewer"))
    for each in (binaries, demo, lessons):
        each.mkdir(exist_ok=True)
    for path in programs(target, work):
        shutil.copyfile(path, binaries / path.name)
        (binaries / path.name).chmod(0o755)
    shutil.copyfile(ROOT / "examples" / "z_plasty" / "z_plasty.usda", demo / "z_plasty.usda")
    shutil.copyfile(viewer.bundle(), lessons / "lesson.js")
    wheel = metadata_folder(folder) / "WHEEL"
    text = re.sub(r"^Tag: .*\n", "", wheel.read_text(encoding="utf-8"), flags=re.MULTILINE).rstrip()
    text = text.replace("Root-Is-Purelib: true", "Root-Is-Purelib: false")
    wheel.write_text(f"{text}\nTag: {TARGETS[target].tag}\n", encoding="utf-8")
    libraries = linked(target, work)
    _add_licenses(metadata_folder(folder) / "licenses" / "libraries", libraries, target, work)
    bills = metadata_folder(folder) / "sboms"
    bills.mkdir(exist_ok=True)
    (bills / sbom.NAME).write_text(sbom.text(sbom.of_wheel(folder, libraries)), encoding="utf-8")


def linked(target: str, work: Path = WORK) -> list[Carried]:
    """What the daemon for a target is made of besides Lappet: its BLAS, static libraries, run time and headers."""
    blas = _wheel_version(work / target / "openblas", "scipy_openblas32")
    place = f"lappet/bin/{TARGETS[target].blas}"
    found = [Carried("scipy-openblas32", blas, place, wheel=f"scipy-openblas32=={blas}")]
    for name in SOURCES:
        (described,) = (work / "sources").glob(f"{name}_*.dsc")
        match = re.search(r"^Version: (\S+)$", described.read_text(encoding="utf-8"), flags=re.MULTILINE)
        assert match is not None, described
        package = DebianPackage(name, match[1], name, match[1], "source")
        found.append(Carried(name, match[1], debian=package, how=f"Compiled for {target}, linked into the daemon"))
    there, how = installed(), "Run time that is linked into the daemon"
    if TARGETS[target].compiler == "ziglang":
        zig = _wheel_version(work / "ziglang", "ziglang")
        found.append(Carried("ziglang", zig, wheel=f"ziglang=={zig}", how=how))
    else:
        found += [Carried(name, there[name].version, debian=there[name], how=how) for name in MINGW]
    return found + [Carried(name, there[name].version, debian=there[name]) for name in HEADERS]


def _wheel_version(unpacked: Path, name: str) -> str:
    (metadata,) = unpacked.glob(f"{name}-*.dist-info")
    return metadata.name.removesuffix(".dist-info").rpartition("-")[2]


def _add_licenses(folder: Path, libraries: list[Carried], target: str, work: Path) -> None:
    """Write the license of everything that is linked: Debian's copyright file, or what the wheel of it ships."""
    folder.mkdir(parents=True, exist_ok=True)
    whole: set[str] = set()
    for one in libraries:
        if one.name == "ziglang":
            sources = [work / "ziglang" / "ziglang" / place for place in ZIG_LICENSES]
        elif one.debian is None:
            sources = list((work / target / "openblas").glob("scipy_openblas32-*.dist-info/licenses/LICENSE.txt"))
        elif one.debian.architecture == "source":
            sources = list((work / "sources").glob(f"{one.name}-*/debian/copyright"))
        else:
            sources = [DEBIAN_DOCS / one.name / "copyright"]
        assert sources, f"no license of {one.name}"
        text = "\n\n".join(source.read_text(encoding="utf-8") for source in sources)
        (folder / f"{unquote(one.name)}.txt").write_text(text, encoding="utf-8")
        whole |= set(re.findall(r"/usr/share/common-licenses/([\w.+-]*\w)", text))
    for name in sorted(whole):
        if (COMMON_LICENSES / name).is_file():
            shutil.copyfile(COMMON_LICENSES / name, folder / f"{name}.txt")


def main(arguments: list[str]) -> int:
    """The command. Returns the exit status."""
    if len(arguments) != 2 or arguments[0] not in TARGETS:
        print(f"usage: cross_wheel.py TARGET FOLDER, where TARGET is one of {', '.join(TARGETS)}", file=sys.stderr)
        return 2
    target, folder = arguments[0], Path(arguments[1])
    try:
        with tempfile.TemporaryDirectory() as work:
            wheel = made(target, Path(work))
            folder.mkdir(parents=True, exist_ok=True)
            for old in folder.glob(f"lappet-*-{TARGETS[target].tag}.whl"):
                old.unlink()
            print(shutil.copy2(wheel, folder))
    except FileNotFoundError as error:
        print(f"cross_wheel: {error}", file=sys.stderr)
        return 1
    except subprocess.CalledProcessError as error:
        print(f"cross_wheel: {Path(error.cmd[0]).name} failed; its message is above.", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
