"""The zip that Blender installs: what is in it, and its life in a Blender that has nothing else."""

from __future__ import annotations

import base64
import csv
import dataclasses
import hashlib
import json
import os
import re
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import extension
import lappet_wheel
import locked
import pypi_wheels
import system_versions
from box_scene import box, pull
from extension import assemble, with_wheels
from lappet.cutting.epoch import Epoch
from lappet.daemon.client import SolverClient
from lappet.daemon.process import SolverDaemon, find_daemon
from lappet.program.settings import SolverSettings

ROOT = Path(__file__).resolve().parents[2]
LIFE = Path(__file__).with_name("extension_life.py")
# Blender's module and what its wheel asks for; neither Lappet nor anything that Lappet asks for but numpy.
BLENDER_PACKAGES = (
    "bpy", "numpy", "numpy.libs", "requests", "urllib3", "idna", "certifi", "charset_normalizer", "zstandard",
)  # fmt: skip
OTHER_BLENDERS = ("4.5", "5.1", "5.2")  # each in build/bpy-<version>, where somebody has made that
# What a Linux with Blender has: the run time of C and C++.
RUN_TIME = re.compile(
    r"/(ld-linux-x86-64|libc|libdl|libgcc_s|libm|libpthread|libresolv|librt|libstdc\+\+)\.so\.[\d.]+$"
)


# --- the parts -----------------------------------------------------------------------------------------------------


def small_wheel(folder: Path, tag: str, rights: int = 0o644, time: float = 1e9, **more: str) -> Path:
    """A wheel of `lappet` with the add-on in it, as scikit-build-core would tag it; more: modules and their text.

    rights, time: of its files, the time in seconds since 1970.
    """
    version = extension.project_version()
    info = f"lappet-{version}.dist-info"
    files = {
        "lappet/__init__.py": "",
        "lappet/bin/lappet-solverd.exe": "the daemon",
        "lappet_blender/__init__.py": "",
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: lappet\nVersion: {version}\n",
        f"{info}/WHEEL": f"Wheel-Version: 1.0\nRoot-Is-Purelib: false\nTag: py3-none-{tag}\n",
        **{f"lappet/{module}.py": text for module, text in more.items()},
    }
    tree = folder / "tree"
    for name, text in files.items():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_text(text)
        (tree / name).chmod(rights)
        os.utime(tree / name, (time, time))
    pack = [sys.executable, "-m", "wheel", "pack", "--dest-dir", str(folder), str(tree)]
    subprocess.run(pack, check=True, capture_output=True)
    (made,) = folder.glob("lappet-*.whl")
    return made


def test_a_zip_carries_wheels_for_the_pythons_of_blender_on_its_platform(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blender 4.5 and 5.0 have 3.11, 5.1 and 5.2 have 3.13; Debian builds its own with 3.14."""
    asked: dict[str, set[str]] = {}

    def download(name: str, pythons: list[str], platform: str, cache: Path) -> list[Path]:
        asked.setdefault(platform, set()).update(pythons)
        return [cache / f"{name}-{platform}.whl"]

    monkeypatch.setattr(pypi_wheels, "download", download)
    for platform in pypi_wheels.PLATFORMS:
        assert len(pypi_wheels.bundled(platform, tmp_path)) == len(pypi_wheels.BUNDLED)
    blender = {"3.11", "3.13"}
    linux = blender | {"3.14"}
    assert asked == {
        "linux-x64": linux,
        "linux-arm64": linux,
        "macos-arm64": blender,
        "macos-x64": blender,
        "windows-x64": blender,
    }


def test_a_wheel_built_elsewhere_becomes_the_zip_of_its_platform(tmp_path: Path) -> None:
    other = tmp_path / "pyzmq-27.3.0-cp312-abi3-win_amd64.whl"
    with zipfile.ZipFile(other, "w") as archive:
        headers = "Metadata-Version: 2.4\nName: pyzmq\nVersion: 27.3.0\nLicense-Expression: BSD-3-Clause\n"
        archive.writestr("pyzmq-27.3.0.dist-info/METADATA", headers)
    made = assemble(
        "windows-x64",
        small_wheel(tmp_path, "win_amd64"),
        tmp_path / "dist",
        others=[other],
        website="https://a.example/b",
    )
    assert made.name == f"lappet_blender-{extension.project_version()}-windows-x64.zip"
    with zipfile.ZipFile(made) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
        (ours,) = (name for name in names if name.startswith("wheels/lappet-"))
        with zipfile.ZipFile(archive.open(ours)) as wheel:
            held = wheel.namelist()
            metadata = wheel.read(next(name for name in held if name.endswith("METADATA"))).decode()
    assert manifest["platforms"] == ["windows-x64"]
    assert manifest["website"] == "https://a.example/b"
    assert sorted(manifest["wheels"]) == sorted(f"./{name}" for name in names if name.startswith("wheels/"))
    assert {"__init__.py", "LICENSE", "sbom.cdx.json", "wheels/" + other.name} <= set(names)
    assert not [name for name in names if "__pycache__" in name or name.startswith("tests/")]
    assert "lappet/bin/lappet-solverd.exe" in held
    assert not [name for name in held if name.startswith("lappet_blender")]
    version = re.search(r"^Version: (.*)$", metadata, re.MULTILINE)
    assert version is not None
    assert re.fullmatch(re.escape(extension.project_version()) + r"\+[0-9a-f]{8}", version.group(1))


def test_two_builds_of_the_same_files_give_the_same_bytes(tmp_path: Path) -> None:
    """Whenever they are built, by whomever, and in whatever order a folder lists its files."""
    made = []
    for name, order, mask in (("a", 1, 0o022), ("b", -1, 0o077)):
        wheel = small_wheel(tmp_path / name, "win_amd64", rights=0o666 & ~mask, time=1e9 + order * 1e6)
        addon = tmp_path / name / "addon"
        for folder in (extension.ADDON, extension.ADDON / "start"):
            (addon / folder.relative_to(extension.ADDON)).mkdir(parents=True, exist_ok=True)
            for file in sorted(folder.glob("*.*"))[::order]:
                if file.is_file():
                    (addon / file.relative_to(extension.ADDON)).write_bytes(file.read_bytes())
                    os.utime(addon / file.relative_to(extension.ADDON), (1e9 + order, 1e9 + order))
        before = os.umask(mask)
        try:
            made.append(assemble("windows-x64", wheel, tmp_path / name / "dist", others=[], addon=addon))
        finally:
            os.umask(before)
    assert made[0].read_bytes() == made[1].read_bytes()


def test_two_builds_of_one_version_differ_in_the_wheels_version(tmp_path: Path) -> None:
    """Else Blender would keep the files of the build that was installed first."""
    first = small_wheel(tmp_path / "a", "win_amd64")
    changed = small_wheel(tmp_path / "b", "win_amd64", new="more = 1")
    again = extension.for_extension(first, tmp_path / "again")
    assert extension.for_extension(first, tmp_path / "first").read_bytes() == again.read_bytes()
    assert extension.for_extension(changed, tmp_path / "other").name != again.name


def test_the_programs_in_the_zips_wheel_take_less_room_and_unpack_to_the_same_files(tmp_path: Path) -> None:
    plain = small_wheel(tmp_path, "win_amd64")
    program = b"\x7fELF" + b"".join(index.to_bytes(4, "little") for index in range(50_000))
    with_program = lappet_wheel.edited(
        plain, tmp_path / "more", lambda folder: (folder / "lappet/bin/lappet-solverd").write_bytes(program) and None
    )
    with zipfile.ZipFile(with_program) as before:
        room = before.getinfo("lappet/bin/lappet-solverd").compress_size
    with zipfile.ZipFile(extension.for_extension(with_program, tmp_path / "made")) as after:
        assert after.testzip() is None
        assert after.read("lappet/bin/lappet-solverd") == program
        assert after.getinfo("lappet/bin/lappet-solverd").compress_size < 0.8 * room
        (record,) = (name for name in after.namelist() if name.endswith("/RECORD"))
        for name, digest, _ in csv.reader(after.read(record).decode().splitlines()):
            if digest:
                found = base64.urlsafe_b64encode(hashlib.sha256(after.read(name)).digest()).rstrip(b"=").decode()
                assert digest == f"sha256={found}", name
        assert {row[0] for row in csv.reader(after.read(record).decode().splitlines())} == set(after.namelist())


@pytest.mark.parametrize(("platform", "tag"), [("macos-arm64", "macosx_11_0_x86_64"), ("linux-x64", "linux_x86_64")])
def test_a_wheel_of_another_platform_is_refused(tmp_path: Path, platform: str, tag: str) -> None:
    with pytest.raises(ValueError, match=f"is a wheel for {tag}, not for {platform}"):
        assemble(platform, small_wheel(tmp_path, tag), tmp_path, others=[])


def test_a_platform_whose_daemon_is_compiled_elsewhere_asks_for_the_wheel(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert extension.main(["--platform", "windows-x64"]) == 1
    said = capsys.readouterr().err
    assert "windows-x64 is not compiled by this command" in said
    assert "packaging/cross/build.sh" in said


def test_a_library_that_debian_has_replaced_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the packages that the wheel carries, not of others."""
    asked: list[str] = []

    def updates(names: list[str]) -> dict[str, str]:
        asked.extend(names)
        return {"libcholmod3": "99"}

    monkeypatch.setattr(system_versions, "updates", updates)
    (line,) = extension.outdated()
    assert re.search(r"carries libcholmod3 1:5\.\d+\S*, and Debian has 99: upgrade that package", line)
    assert {"libtbb12", "libeigen3-dev"} <= set(asked)
    assert "cmake" not in asked


def test_the_manifest_states_what_the_project_does_and_every_key_stays() -> None:
    text = (extension.ADDON / extension.MANIFEST).read_text(encoding="utf-8")
    manifest = tomllib.loads(text)
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert manifest["blender_version_min"] == "4.5.0"
    assert all(len(reason) <= 64 and reason[-1].isalnum() for reason in manifest["permissions"].values())
    filled = tomllib.loads(with_wheels(text, ["a.whl"], "linux-x64"))
    assert filled == {**manifest, "platforms": ["linux-x64"], "wheels": ["./wheels/a.whl"]}
    known = tomllib.loads(with_wheels(text, ["a.whl"], "linux-x64", "https://a.example"))
    assert known == {**filled, "website": "https://a.example"}


def validated(folder: Path) -> subprocess.CompletedProcess[str]:
    """What Blender's own tool says of an extension, with the tags of Get Extensions."""
    tool = extension.blender_extension_tool()
    command = [sys.executable, str(tool), "validate", str(folder), f"--valid-tags={extension.valid_tags(tool)}"]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_blenders_tool_takes_the_manifest_as_get_extensions_does(tmp_path: Path) -> None:
    text = (extension.ADDON / extension.MANIFEST).read_text(encoding="utf-8")
    (tmp_path / "__init__.py").touch()
    (tmp_path / extension.MANIFEST).write_text(with_wheels(text, [], "linux-x64", "https://a.example"))
    done = validated(tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert set(tomllib.loads(text)["permissions"]) == {"files", "network"}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"Physics"', '"Surgery"'),
        ("on this computer only", "on this computer only."),
        ("network =", "telephone ="),
        ('tagline = "Plan', 'tagline = "' + "Carefully plan, " * 4 + "Plan"),
    ],
)  # fmt: skip
def test_what_get_extensions_would_send_back_is_found(tmp_path: Path, old: str, new: str) -> None:
    text = (extension.ADDON / extension.MANIFEST).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "__init__.py").touch()
    (tmp_path / extension.MANIFEST).write_text(text.replace(old, new))
    assert validated(tmp_path).returncode != 0


@pytest.mark.parametrize("text", ["", "lappet", "http://a.example", "https://", "https://a.example/b c"])
def test_what_is_no_address_is_no_website(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        extension.main(["--website", text])
    assert f"{text!r} is no website" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('type = "add-on"', 'type = "add-on"\nwheels = []', "names wheels"),
        (f'"{extension.project_version()}"', '"99.0.0"', "says version 99.0.0"),
    ],
)
def test_a_manifest_that_disagrees_with_the_project_is_refused(old: str, new: str, says: str) -> None:
    text = (extension.ADDON / extension.MANIFEST).read_text(encoding="utf-8")
    assert old in text
    with pytest.raises(ValueError, match=says):
        with_wheels(text.replace(old, new), [], "linux-x64")


def test_every_bundled_package_is_locked_and_none_is_blenders_own() -> None:
    assert set(pypi_wheels.BUNDLED) <= locked.read().keys()
    assert not {"numpy", "usd-core", "usd_core", "scipy", "bpy"} & set(pypi_wheels.BUNDLED)


def test_the_add_on_never_names_itself_for_an_extension_has_another_name() -> None:
    """Blender imports it as `bl_ext.<repository>.lappet_blender`."""
    named = re.compile(r"^\s*(?:from|import)\s+lappet_blender\b", re.MULTILINE)
    sources = sorted(extension.ADDON.rglob("*.py"))
    assert sources
    assert [path.name for path in sources if named.search(path.read_text(encoding="utf-8"))] == []


def test_a_daemon_that_was_unpacked_without_its_modes_is_made_executable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    daemon = tmp_path / "lappet" / "bin" / "lappet-solverd"
    daemon.parent.mkdir(parents=True)
    daemon.write_text("#!/bin/sh\n")
    daemon.chmod(0o640)
    monkeypatch.delenv("LAPPET_SOLVERD", raising=False)
    monkeypatch.setattr("lappet.daemon.process.__file__", str(tmp_path / "lappet" / "daemon" / "process.py"))
    assert find_daemon() == daemon
    assert daemon.stat().st_mode & 0o777 == 0o750


# --- the whole -----------------------------------------------------------------------------------------------------


def lonely_blender(folder: Path) -> Path:
    """A Python whose only packages are Blender's module and what that needs."""
    venv.create(folder, with_pip=False)
    (site,) = (folder / "lib").glob("python3.*/site-packages")
    home = Path(np.__file__).parent.parent
    for name in BLENDER_PACKAGES:
        if (home / name).exists():
            (site / name).symlink_to(home / name)
    return folder / "bin" / "python"


def life(python: Path, zip_file: Path, folder: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Runs extension_life.py; returns what it saw and the arrays of its frame."""
    surface = [getattr(box(), field.name) for field in dataclasses.fields(box()) if field.name != "grips"]
    hook = {name: value for name, value in vars(pull()).items() if name.startswith("hook_")}
    np.savez(folder / "given.npz", **{f"surface{i}": array for i, array in enumerate(surface)}, **hook)
    environment = {name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ}
    done = subprocess.run(
        [python, "-I", str(LIFE), str(zip_file), str(folder / "given.npz"), str(folder / "result.npz")],
        env={**environment, "HOME": str(folder), "BLENDER_USER_RESOURCES": str(folder / "blender")},
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    printed = done.stdout + done.stderr
    assert done.returncode == 0, printed
    assert "Traceback" not in printed
    assert not re.search(r"^(Error|Warning|RuntimeError)\b", printed, re.MULTILINE), printed
    with np.load(folder / "result.npz") as result:
        return json.loads(done.stdout.strip().splitlines()[-1]), dict(result)


def check_life(seen: dict[str, Any], arrays: dict[str, np.ndarray]) -> None:
    """Everything of the zip was used, nothing else, and nothing is left."""
    assert seen["strangers"] == []
    assert seen["installed"] == ["FINISHED"]
    assert seen["enabled"] == [True, True]
    assert seen["scene has lappet"]
    site = re.fullmatch(r"(\.local/lib/python3\.\d+/site-packages/)lappet/__init__\.py", seen["lappet"])
    assert site is not None
    assert re.fullmatch(r"[0-9.]+\+[0-9a-f]{8}", seen["version"])
    assert [folder.endswith(site.group(1).removesuffix("site-packages/")) for folder in seen["imported"]] == [True]
    assert seen["cannot be imported"] == []
    assert site.group(1) + "lappet/bin/lappet-solverd" in seen["daemon"]
    foreign = [name for name in seen["libraries"] if "/lappet.libs/" not in name and not RUN_TIME.search(name)]
    assert foreign == []
    assert any("/lappet.libs/libzmq" in name for name in seen["libraries"])
    assert seen["converged"]
    assert not seen["alive after"]
    assert seen["disabled"] == [False, False]
    assert not seen["scene has lappet when disabled"]
    assert seen["uninstalled"] == ["FINISHED"]
    assert seen["left"] == []

    with SolverDaemon() as daemon, SolverClient(daemon=daemon) as client:
        client.open(SolverSettings(spacing=1.0, threads=1))
        client.set_epoch(Epoch(0, 1.0, box(), 1))
        expected = client.solve(pull()).arrays()
    assert sorted(arrays) == sorted(expected)
    for name, array in expected.items():
        assert arrays[name].tobytes() == array.tobytes(), f"{name} differs from what this checkout's daemon solves"


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_zip_lives_and_dies_in_a_blender_that_has_nothing_else(zip_file: Path, tmp_path: Path) -> None:
    """Installed, enabled, its own daemon solves the very frame of this checkout's, disabled, uninstalled."""
    check_life(*life(lonely_blender(tmp_path / "environment"), zip_file, tmp_path))


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("version", OTHER_BLENDERS)
def test_the_zip_lives_and_dies_in_every_blender_that_it_is_for(zip_file: Path, tmp_path: Path, version: str) -> None:
    python = ROOT / "build" / f"bpy-{version}" / "bin" / "python"
    if not python.exists():
        pytest.skip(f"build/bpy-{version} has no Blender {version}; packaging/README.md says how to make it.")
    seen, arrays = life(python, zip_file, tmp_path)
    assert seen["blender"].startswith(version)
    check_life(seen, arrays)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_zip_names_the_licence_of_every_library_in_it(zip_file: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(zip_file) as archive:
        (ours,) = (name for name in archive.namelist() if name.startswith("wheels/lappet-"))
        archive.extract(ours, tmp_path)
    with zipfile.ZipFile(tmp_path / ours) as wheel:
        names = wheel.namelist()
    assert re.search(r"-py3-none-manylinux_2_\d+_(x86_64|aarch64)\.whl$", ours)
    licensed = {Path(name).stem for name in names if "/licenses/libraries/" in name}
    said = (ROOT / "packaging/licenses.md").read_text(encoding="utf-8")
    # A package of Debian is named after its library and the library's version; libblas, liblapack and libopenblasp (the
    # build with threads) are all OpenBLAS's.
    projects = dict.fromkeys(("libblas", "liblapack", "libopenblasp"), "libopenblas") | {"libzmq": "zeromq"}
    held = {Path(name).name for name in names if name.startswith("lappet.libs/") and ".so" in name}
    assert len(held) > 10
    for library in held:
        plain = re.sub(r"-.*|\.so.*", "", library)
        project = projects.get(plain, plain)
        assert any(name.startswith(project) or f"lib{name}" == project for name in licensed), library
        assert project.removeprefix("lib") in said.lower(), f"packaging/licenses.md does not name {library}"
    assert "GPL-2" in licensed, "CHOLMOD's licence refers to it"


def test_the_tool_of_blender_is_asked_for_where_there_is_no_blender(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="is it Blender's bpy"):
        extension.blender_extension_tool(tmp_path)


@pytest.mark.slow
def test_blender_refuses_a_manifest_that_is_wrong(tmp_path: Path) -> None:
    addon = tmp_path / "addon"
    addon.mkdir()
    (addon / "__init__.py").write_text("")
    text = (extension.ADDON / extension.MANIFEST).read_text(encoding="utf-8")
    (addon / extension.MANIFEST).write_text(text.replace('type = "add-on"', 'type = "toy"'))
    with pytest.raises(subprocess.CalledProcessError):
        assemble("windows-x64", small_wheel(tmp_path, "win_amd64"), tmp_path, others=[], addon=addon)
