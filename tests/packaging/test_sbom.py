"""The bills of materials name everything native that the extension's zip has, and follow the published schema."""

from __future__ import annotations

import hashlib
import io
import json
import re
import subprocess
import zipfile
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import jsonschema
import pytest

import carried_libraries
import sbom
from carried_libraries import COMPILED_IN, RUN_TIME, Carried
from locked import canonical
from system_versions import DebianPackage, installed

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
DEBIAN = DebianPackage("libfmt9", "9.1.0+ds1-2", "fmtlib", "9.1.0+ds1-2", "amd64")


def check_schema(bill: dict[str, Any]) -> None:
    """Against the schema that the makers of CycloneDX publish, as their library ships it."""
    schemas = files("cyclonedx.schema") / "_res"
    read = {
        name: json.loads((schemas / f"{name}.SNAPSHOT.schema.json").read_text(encoding="utf-8"))
        for name in ("bom-1.6", "spdx", "jsf-0.82", "cryptography-defs")
        if (schemas / f"{name}.SNAPSHOT.schema.json").is_file()
    }
    by_id = {schema["$id"]: schema for schema in read.values() if "$id" in schema}
    resolver = jsonschema.RefResolver(read["bom-1.6"]["$id"], read["bom-1.6"], store=by_id)
    jsonschema.Draft7Validator(read["bom-1.6"], resolver=resolver).validate(bill)


def components(bill: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Every component of a bill, those inside others too."""
    waiting = list(bill["components"])
    while waiting:
        one = waiting.pop()
        yield one
        waiting += one.get("components", [])


def places(bill: dict[str, Any]) -> dict[str, str]:
    """The SHA-256 of each file that the bill lists, by its place."""
    return {
        one["evidence"]["occurrences"][0]["location"]: one["hashes"][0]["content"]
        for one in components(bill)
        if "evidence" in one
    }


def what_is_in(archive: zipfile.ZipFile, prefix: str = "") -> dict[str, str]:
    """The SHA-256 of each wheel and each native file of a zip, by its place, looking into the wheels."""
    found: dict[str, str] = {}
    for name in archive.namelist():
        data = archive.read(name)
        if name.endswith(".whl") or sbom.is_native(data[:4]):
            found[prefix + name] = hashlib.sha256(data).hexdigest()
        if name.endswith(".whl"):
            found |= what_is_in(zipfile.ZipFile(io.BytesIO(data)), f"{prefix}{name}!/")
    return found


def small_wheel(path: Path, headers: str, **more: bytes) -> None:
    path.parent.mkdir(exist_ok=True)
    name, version = path.name.split("-")[:2]
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(f"{name}-{version}.dist-info/METADATA", f"Name: {name}\nVersion: {version}\n{headers}")
        for file, data in more.items():
            archive.writestr(file, data)


def unpacked(folder: Path) -> Path:
    """A wheel of Lappet with one library of Debian and one of pyzmq, unpacked."""
    (folder / "lappet.libs").mkdir(parents=True)
    (folder / "lappet.libs" / "libfmt-0a0a0a0a.so.9").write_bytes(b"\x7fELF fmt")
    (folder / "lappet.libs" / "libzmq-0b0b0b0b.so.5").write_bytes(b"\x7fELF zmq")
    (folder / "lappet-1.0.dist-info").mkdir()
    (folder / "lappet-1.0.dist-info" / "METADATA").write_text("Name: lappet\nVersion: 1.0\n")
    return folder


LIBRARIES = [
    Carried("libfmt9", "9.1.0+ds1-2", "lappet.libs/libfmt-0a0a0a0a.so.9", debian=DEBIAN),
    Carried("libzmq", "4.3.5", "lappet.libs/libzmq-0b0b0b0b.so.5", wheel="pyzmq==27.3.0"),
]


# --- the parts -----------------------------------------------------------------------------------------------------


def test_a_library_of_debian_has_its_version_its_source_and_its_license(tmp_path: Path) -> None:
    bill = sbom.of_wheel(unpacked(tmp_path / "wheel"), LIBRARIES)
    check_schema(bill)
    fmt, zmq = bill["components"]
    assert (fmt["name"], fmt["version"]) == ("libfmt9", "9.1.0+ds1-2")
    assert fmt["purl"] == "pkg:deb/debian/libfmt9@9.1.0%2Bds1-2?arch=amd64"
    assert fmt["licenses"] == [{"expression": "MIT WITH fmt-exception"}]
    assert fmt["pedigree"]["ancestors"][0]["purl"] == "pkg:deb/debian/fmtlib@9.1.0%2Bds1-2?arch=source"
    assert fmt["hashes"][0]["content"] == hashlib.sha256(b"\x7fELF fmt").hexdigest()
    assert zmq["pedigree"]["ancestors"][0]["purl"] == "pkg:pypi/pyzmq@27.3.0"


@pytest.mark.parametrize(("key", "value"), [("specVersion", 1.6), ("components", [{"type": "liver", "name": "x"}])])
def test_the_schema_refuses_what_is_no_bill(tmp_path: Path, key: str, value: object) -> None:
    bill = sbom.of_wheel(unpacked(tmp_path / "wheel"), LIBRARIES)
    with pytest.raises(jsonschema.ValidationError):
        check_schema({**bill, key: value})


def test_a_native_file_that_nobody_described_is_listed_all_the_same(tmp_path: Path) -> None:
    folder = unpacked(tmp_path / "wheel")
    (folder / "daemon").write_bytes(b"\x7fELF daemon")
    (folder / "text").write_bytes(b"no program")
    bill = sbom.of_wheel(folder, LIBRARIES)
    assert sorted(places(bill)) == ["daemon", *sorted(one.file for one in LIBRARIES)]


def test_the_extension_lists_its_wheels_and_what_their_own_bills_say(tmp_path: Path) -> None:
    bill = sbom.of_wheel(unpacked(tmp_path / "wheel"), LIBRARIES)
    files_of = {f"lappet-1.0.dist-info/sboms/{sbom.NAME}": sbom.text(bill).encode()}
    small_wheel(tmp_path / "wheels" / "lappet-1.0-py3-none-any.whl", "", **files_of)
    native = {"pyzmq.libs/libzmq-0b0b0b0b.so.5": b"\x7fELF zmq", "zmq/_zmq.so": b"\x7fELF"}
    small_wheel(tmp_path / "wheels" / "pyzmq-27.3.0-py3-none-any.whl", "License-Expression: BSD-3-Clause\n", **native)
    whole = sbom.of_extension(tmp_path, "1.0")
    check_schema(whole)
    by_place = {one["bom-ref"]: one for one in components(whole)}
    wheel = "wheels/pyzmq-27.3.0-py3-none-any.whl"
    assert by_place[wheel]["purl"] == "pkg:pypi/pyzmq@27.3.0?file_name=pyzmq-27.3.0-py3-none-any.whl"
    assert by_place[wheel]["licenses"] == [{"expression": "BSD-3-Clause"}]
    twin = by_place[f"{wheel}!/pyzmq.libs/libzmq-0b0b0b0b.so.5"]
    assert (twin["type"], twin["version"], twin["licenses"]) == ("library", "4.3.5", [{"expression": "MPL-2.0"}])
    assert by_place[f"{wheel}!/zmq/_zmq.so"]["type"] == "file"
    assert "wheels/lappet-1.0-py3-none-any.whl!/lappet.libs/libfmt-0a0a0a0a.so.9" in by_place


def test_a_package_of_unknown_license_is_refused_with_the_remedy(tmp_path: Path) -> None:
    small_wheel(tmp_path / "wheels" / "leftpad-1.0-py3-none-any.whl", "License: do what you like\n")
    with pytest.raises(LookupError, match=r"no license of leftpad; add it there and to packaging/licenses\.md"):
        sbom.of_extension(tmp_path, "1.0")


def test_a_copy_that_is_not_of_the_library_that_the_daemon_loads_is_refused(tmp_path: Path) -> None:
    daemon = Path("/bin/true")
    folder = tmp_path / "wheel"
    (folder / "lappet.libs").mkdir(parents=True)
    loaded = carried_libraries._loaded(daemon, tmp_path)
    (name,) = (name for name in loaded if name.startswith(("libc.so", "libc-")))
    original = loaded[name].read_bytes()
    base, _, rest = name.partition(".")
    copy = folder / "lappet.libs" / f"{base}-{hashlib.sha256(original).hexdigest()[:8]}.{rest}"
    copy.write_bytes(original)
    headers = len(COMPILED_IN)
    (found,) = carried_libraries.carried(folder, daemon, tmp_path / "taken", "pyzmq==1")[:-headers]
    assert found.debian is not None
    assert (found.name, found.debian.source) == ("libc6", "glibc")

    copy.rename(copy.with_name(f"{base}-00000000.{rest}"))
    with pytest.raises(LookupError, match="their hashes differ"):
        carried_libraries.carried(folder, daemon, tmp_path / "taken", "pyzmq==1")
    (folder / "lappet.libs" / f"{base}-00000000.{rest}").rename(folder / "lappet.libs" / "libstranger-00000000.so.1")
    with pytest.raises(LookupError, match="loads no library that it is a copy of"):
        carried_libraries.carried(folder, daemon, tmp_path / "taken", "pyzmq==1")


def test_the_bill_of_a_wheel_with_another_version_says_that_version(tmp_path: Path) -> None:
    bill = sbom.of_wheel(unpacked(tmp_path / "wheel"), LIBRARIES)
    told = sbom.of_version(bill, "1.0+1a2b3c4d")
    check_schema(told)
    assert told["metadata"]["component"]["version"] == "1.0+1a2b3c4d"
    assert told["dependencies"][0]["ref"] == told["metadata"]["component"]["bom-ref"] != bill["dependencies"][0]["ref"]
    assert told["components"] == bill["components"]


def test_the_program_of_lessons_brings_its_library_into_the_bill_and_takes_it_out_again(tmp_path: Path) -> None:
    folder = unpacked(tmp_path / "wheel")
    before = sbom.of_wheel(folder, LIBRARIES)
    (folder / "lappet/viewer").mkdir(parents=True)
    (folder / "lappet/viewer/lesson.js").write_text("three")
    bill = sbom.of_wheel(folder, LIBRARIES)
    check_schema(bill)
    (three,) = (one for one in bill["components"] if one["name"] == "three")
    assert three["purl"] == f"pkg:npm/three@{three['version']}"
    assert three["licenses"] == [{"expression": "MIT"}]
    assert sbom.without(bill, "lappet/viewer") == before


def test_every_license_of_a_bill_is_explained_in_the_document_of_licenses() -> None:
    said = (ROOT / "packaging/licenses.md").read_text(encoding="utf-8").lower()
    plain = {re.sub(r"(-dev|[\d.]+(-\w+)?)$", "", name).removeprefix("lib") for name in sbom.LICENSES}
    assert sorted(name for name in plain if name not in said) == []


# --- the whole -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bill(zip_file: Path) -> dict[str, Any]:
    with zipfile.ZipFile(zip_file) as archive:
        made: dict[str, Any] = json.loads(archive.read(sbom.NAME))
    return made


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_the_bill_of_the_zip_lists_every_wheel_and_every_native_file_in_it_and_no_other(
    zip_file: Path, bill: dict[str, Any]
) -> None:
    with zipfile.ZipFile(zip_file) as archive:
        held = what_is_in(archive)
    assert len(held) > 25
    assert places(bill) == held
    assert any(place.endswith("lappet/bin/lappet-solverd") for place in held)


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_both_bills_follow_the_published_schema(zip_file: Path, bill: dict[str, Any]) -> None:
    check_schema(bill)
    with zipfile.ZipFile(zip_file) as archive:
        (ours,) = (name for name in archive.namelist() if name.startswith("wheels/lappet-"))
        with zipfile.ZipFile(archive.open(ours)) as wheel:
            (own,) = (name for name in wheel.namelist() if name.endswith(f".dist-info/sboms/{sbom.NAME}"))
            inner = json.loads(wheel.read(own))
    check_schema(inner)
    assert inner["metadata"]["component"]["version"] == ours.split("-")[1]


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_every_library_in_the_bill_has_its_version_its_license_and_its_origin(bill: dict[str, Any]) -> None:
    there = installed()
    (lappet,) = (one for one in bill["components"] if one["name"] == "lappet")
    libraries = [one for one in lappet["components"] if one["type"] == "library"]
    assert {one["name"] for one in libraries} >= {"libcholmod3", "libzmq", "libsodium", *COMPILED_IN}
    for one in libraries:
        (origin,) = one["pedigree"]["ancestors"]
        if one["name"] in there:
            package = there[one["name"]]
            assert (one["version"], origin["name"]) == (package.version, package.source)
            assert origin["version"] == package.source_version
        else:
            assert origin["name"] == "pyzmq"
    assert [one["name"] for one in components(bill) if one["type"] == "library" and not one.get("version")] == []
    assert [one["name"] for one in components(bill) if one["type"] == "library" and not one.get("licenses")] == []


@pytest.mark.slow
def test_the_headers_in_the_bill_are_those_that_the_compiler_read() -> None:
    """Ninja keeps what each source of the daemon included; the C and C++ library are not Lappet's to list."""
    read = subprocess.run(["ninja", "-C", str(BUILD), "-t", "deps"], capture_output=True, text=True, check=True).stdout
    headers: set[Path] = set()
    for block in read.split("\n\n"):
        target, *lines = block.strip().splitlines() or [""]
        if re.match(r"solverd/CMakeFiles/lappet[-_]\w+\.dir/", target):
            headers |= {Path(line.strip()).resolve() for line in lines if line.strip().startswith("/usr/")}
    assert len(headers) > 500
    told = subprocess.run(
        ["dpkg-query", "--search", *map(str, sorted(headers))], capture_output=True, text=True, check=True
    ).stdout
    owners = {canonical(line.partition(":")[0]) for line in told.splitlines()}
    assert owners - set(RUN_TIME) == set(COMPILED_IN)
