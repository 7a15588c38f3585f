"""Wheels for every platform: the program with its BLAS, the systems that they run on, the licenses of all of it."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from mach_o import MachO, page_hashes
from test_sbom import check_schema

import cross_wheel
import lappet_wheel
import sbom

pytestmark = pytest.mark.slow
MACHINES = {"arm64": {"elf": 183, "mach_o": 0x0100000C}, "x64": {"elf": 62, "mach_o": 0x01000007}}
# What every system of the kind has, by the beginning of the library's name.
LINUX = ("libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "ld-linux")


def needed_programs(target: str) -> tuple[Path, Path]:
    """The daemon and its BLAS; skips the test, loudly, where they are not built."""
    program, blas = cross_wheel.programs(target)
    if not program.is_file():
        pytest.skip(f"THE WHEEL FOR {target} IS NOT TESTED: run packaging/cross/build.sh {target}")
    return program, blas


@pytest.mark.parametrize("target", sorted(cross_wheel.TARGETS))
def test_a_wheel_has_the_program_with_its_library_and_the_licenses_of_all_of_it(target: str, tmp_path: Path) -> None:
    program, blas = needed_programs(target)
    wheel = cross_wheel.made(target, tmp_path)
    assert wheel.name.endswith(f"-{cross_wheel.TARGETS[target].tag}.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        (bill_name,) = (name for name in names if name.endswith(f"sboms/{sbom.NAME}"))
        bill = json.loads(archive.read(bill_name))
        (tags,) = (archive.read(name).decode() for name in names if name.endswith(".dist-info/WHEEL"))
        native = {name for name in names if sbom.is_native(archive.read(name)[:4])}
        modes = {archive.getinfo(name).external_attr >> 16 & 0o111 for name in native}
    assert native == {f"lappet/bin/{program.name}", f"lappet/bin/{blas.name}"}
    assert modes == {0o111}, "whoever installs it may run it"
    assert {"lappet/demo/z_plasty.usda", "lappet/viewer/lesson.js"} <= names
    assert "Root-Is-Purelib: false" in tags
    assert tags.count("Tag:") == 1
    check_schema(bill)
    texts = {Path(name).stem for name in names if "/licenses/libraries/" in name}
    assert {one.name for one in cross_wheel.linked(target)} <= texts


@pytest.mark.timeout(300)
def test_two_checkouts_make_the_same_wheel_and_source_distribution_from_one_daemon(tmp_path: Path) -> None:
    """Wherever they lie, whatever the times and rights of their files are, and with what Python left in them."""
    target = next(
        (each for each in sorted(cross_wheel.TARGETS) if cross_wheel.programs(each)[0].is_file()), "linux-x64"
    )
    needed_programs(target)
    made = []
    for place, mask, time in (("a", 0o002, 1.6e9), ("another/deeper", 0o077, 1.7e9)):
        root = tmp_path / place
        for name in lappet_wheel.FOLDERS:
            shutil.copytree(cross_wheel.ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in lappet_wheel.FILES:
            shutil.copy(cross_wheel.ROOT / name, root / name)
        for path in root.rglob("*"):
            if path.is_file():
                path.chmod((0o777 if path.stat().st_mode & 0o100 else 0o666) & ~mask)
                os.utime(path, (time, time))
        cached = root / "shared" / "lappet" / "__pycache__" / "of.cpython-311.pyc"
        cached.parent.mkdir()
        cached.write_text(place)
        before = os.umask(mask)
        try:
            wheel = cross_wheel.made(target, root / "wheel", root=root)
            call = "from scikit_build_core.build import build_sdist; build_sdist('sources')"
            subprocess.run([sys.executable, "-c", call], cwd=root, check=True, capture_output=True)
        finally:
            os.umask(before)
        (sources,) = (root / "sources").glob("lappet-*.tar.gz")
        made.append([hashlib.sha256(path.read_bytes()).hexdigest() for path in (wheel, sources)])
    assert made[0] == made[1]


@pytest.mark.parametrize("target", ["linux-arm64", "linux-x64"])
def test_a_program_for_linux_needs_a_c_library_of_2018_and_its_blas_beside_it(target: str) -> None:
    """The tag manylinux_2_28 promises glibc 2.28."""
    for path in needed_programs(target):
        (machine,) = struct.unpack_from("<H", path.read_bytes(), 18)
        assert machine == MACHINES[target.rpartition("-")[2]]["elf"], path
        told = subprocess.run(["readelf", "-dVW", str(path)], capture_output=True, text=True, check=True).stdout
        libraries = [line.rpartition("[")[2].rstrip("]") for line in told.splitlines() if "(NEEDED)" in line]
        assert [one for one in libraries if not one.startswith(LINUX)] in ([], ["libscipy_openblas.so"])
        versions = {
            tuple(map(int, word.removeprefix("GLIBC_").split(".")))
            for word in told.split()
            if word.startswith("GLIBC_") and word[6].isdigit()
        }
        assert versions, path
        assert max(versions) <= (2, 28), path
    program, _ = needed_programs(target)
    told = subprocess.run(["readelf", "-dW", str(program)], capture_output=True, text=True, check=True).stdout
    assert "[$ORIGIN]" in told


@pytest.mark.parametrize("target", ["macos-arm64", "macos-x64"])
def test_a_program_for_macos_is_signed_runs_on_12_and_finds_its_blas_beside_it(target: str) -> None:
    """ARM starts only what has a signature; without a developer's certificate that is one of hashes alone."""
    program, blas = (MachO(path.read_bytes()) for path in needed_programs(target))
    for one in (program, blas):
        assert one.machine == MACHINES[target.rpartition("-")[2]]["mach_o"]
        assert one.oldest_macos <= (12, 0)
    system = [name for name in program.libraries if name.startswith(("/usr/lib/", "/System/Library/"))]
    assert set(program.libraries) - set(system) == {"@rpath/libscipy_openblas.dylib"}
    assert blas.name == "@rpath/libscipy_openblas.dylib"
    assert program.run_paths == ["@loader_path"]
    assert set(blas.libraries) <= {"/usr/lib/libSystem.B.dylib"}
    if target == "macos-arm64":
        for one in (program, blas):
            signed, computed = page_hashes(one)
            assert signed
            assert signed == computed, "the signature is of other bytes"
