"""Write bills of materials (CycloneDX 1.6): what is in Lappet's wheel, and what is in the extension's zip.

Each is the file `sbom.cdx.json`: in the wheel's metadata and at the top of the zip. It lists every wheel and native
file with its hash, and every library with its version, its license and the source package of Debian it is built from.
The same files give the same bill: there is no time in it.
"""

from __future__ import annotations

import hashlib
import io
import json
import re
import zipfile
from email.parser import Parser
from pathlib import Path
from typing import Any
from urllib.parse import quote

from packaging.licenses import canonicalize_license_expression

from carried_libraries import Carried
from locked import canonical

NAME = "sbom.cdx.json"
LICENSE = "GPL-3.0-or-later"  # Lappet's own
# By Debian's package or by the library's name. packaging/licenses.md says more of each.
LICENSES = {
    "cppzmq-dev": "MIT",
    "libamd2": "BSD-3-Clause",
    "libcamd2": "BSD-3-Clause",
    "libccolamd2": "BSD-3-Clause",
    "libcholmod3": "LGPL-2.1-or-later AND GPL-2.0-or-later",
    "libcli11-dev": "BSD-3-Clause",
    "libcolamd2": "BSD-3-Clause",
    "libeigen3-dev": "MPL-2.0 AND BSD-3-Clause",
    "libfmt-dev": "MIT WITH fmt-exception",
    "libfmt9": "MIT WITH fmt-exception",
    "libgfortran5": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libgomp1": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libmetis5": "Apache-2.0",
    "libmsgpack-cxx-dev": "BSL-1.0",
    "libopenblas0-pthread": "BSD-3-Clause",
    "libquadmath0": "LGPL-2.1-or-later",
    "libsodium": "ISC",
    "libspdlog-dev": "MIT",
    "libspdlog1.10": "MIT",
    "libsuitesparse-dev": "LGPL-2.1-or-later AND GPL-2.0-or-later AND BSD-3-Clause",
    "libsuitesparseconfig5": "BSD-3-Clause",
    "libtbb-dev": "Apache-2.0",
    "libtbb12": "Apache-2.0",
    "libxsimd-dev": "BSD-3-Clause",
    "libzmq": "MPL-2.0",
    "libzmq3-dev": "LGPL-3.0-or-later",
    # Of the daemons that packaging/cross compiles:
    "gcc-mingw-w64-x86-64-posix": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "mingw-w64-x86-64-dev": "ZPL-2.1 AND MIT",
    "onetbb": "Apache-2.0",
    "scipy-openblas32": "BSD-3-Clause AND GPL-3.0-or-later WITH GCC-exception-3.1",
    "suitesparse": "LGPL-2.1-or-later AND GPL-2.0-or-later AND BSD-3-Clause",
    "zeromq3": "LGPL-3.0-or-later",
    "ziglang": "MIT AND Apache-2.0 WITH LLVM-exception AND LGPL-2.1-or-later",
    # Of npm, in the program of lessons:
    "three": "MIT",
    # A wheel whose metadata has no expression:
    "manifold3d": "Apache-2.0",
}
NPM_LOCK = Path(__file__).resolve().parent.parent / "viewer" / "package-lock.json"
# How native files begin: ELF; Windows; macOS for one machine and for several.
NATIVE = (b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe", b"\xca\xfe\xba\xbe")


def license_of(name: str) -> str:
    """The SPDX expression of a package. Raises LookupError, with the remedy, where nobody wrote it down."""
    if name not in LICENSES:
        raise LookupError(f"packaging/sbom.py has no license of {name}; add it there and to packaging/licenses.md.")
    return LICENSES[name]


def of_wheel(folder: Path, libraries: list[Carried]) -> dict[str, Any]:
    """The bill of Lappet's unpacked wheel with the libraries that it carries."""
    metadata = _metadata((next(folder.glob("*.dist-info")) / "METADATA").read_text(encoding="utf-8"))
    own = _component("application", "lappet", metadata["Version"], _lappet_purl(metadata["Version"]), LICENSE)
    return _bill(own, [_library(one, folder) for one in libraries] + _other_files(folder, libraries) + _viewer(folder))


def of_version(bill: dict[str, Any], version: str) -> dict[str, Any]:
    """The bill of a wheel of Lappet that gets another version."""
    old, new = bill["metadata"]["component"]["bom-ref"], _lappet_purl(version)
    own = {**bill["metadata"]["component"], "bom-ref": new, "version": version, "purl": new}
    relations = [{**one, "ref": new if one["ref"] == old else one["ref"]} for one in bill["dependencies"]]
    return {**bill, "metadata": {"component": own}, "dependencies": relations}


def without(bill: dict[str, Any], folder: str) -> dict[str, Any]:
    """The bill of a wheel from which a folder was taken."""
    kept = [one for one in bill["components"] if not one["bom-ref"].startswith(f"{folder}/")]
    (relation,) = bill["dependencies"]
    return {
        **bill,
        "components": kept,
        "dependencies": [{**relation, "dependsOn": [one["bom-ref"] for one in kept]}],
    }


def of_extension(folder: Path, version: str) -> dict[str, Any]:
    """The bill of the extension's files before they are zipped: its wheels, with what the bills in them say."""
    own = _component("application", "lappet_blender", version, f"pkg:generic/lappet_blender@{version}", LICENSE)
    wheels = [_wheel(path, f"wheels/{path.name}") for path in sorted((folder / "wheels").glob("*.whl"))]
    _describe_twins(wheels)
    return _bill(own, wheels)


def text(bill: dict[str, Any]) -> str:
    """The bill as its file."""
    return json.dumps(bill, indent=1, ensure_ascii=False) + "\n"


def is_native(head: bytes) -> bool:
    """Whether a file that begins so is a program or a library of a machine."""
    return head.startswith(NATIVE)


def _bill(own: dict[str, Any], components: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": own},
        "components": components,
        "dependencies": [{"ref": own["bom-ref"], "dependsOn": [one["bom-ref"] for one in components]}],
    }


def _component(
    kind: str, name: str, version: str, purl: str, license: str, *, place: str = "", data: bytes | None = None
) -> dict[str, Any]:
    """place: in the wheel or zip. data: the file's bytes."""
    made: dict[str, Any] = {"type": kind, "bom-ref": place or purl, "name": name, "version": version}
    if data is not None:
        made["hashes"] = [{"alg": "SHA-256", "content": hashlib.sha256(data).hexdigest()}]
    made["licenses"] = [{"expression": canonicalize_license_expression(license)}]
    made["purl"] = purl
    if place:
        made["evidence"] = {"occurrences": [{"location": place}]}
    return made


def _library(carried: Carried, folder: Path) -> dict[str, Any]:
    data = (folder / carried.file).read_bytes() if carried.file else None
    if carried.debian is None:
        purl = f"pkg:generic/{carried.name}@{quote(carried.version, safe='')}"
    else:
        purl = _debian_purl(carried.name, carried.version, carried.debian.architecture)
    license = license_of(carried.name)
    made = _component("library", carried.name, carried.version, purl, license, place=carried.file, data=data)
    if carried.debian is not None:
        source, version = carried.debian.source, carried.debian.source_version
        origin = _debian_purl(source, version, "source")
    else:
        source, _, version = carried.wheel.partition("==")
        origin = f"pkg:pypi/{source}@{version}"
    made["pedigree"] = {"ancestors": [{"type": "library", "name": source, "version": version, "purl": origin}]}
    if not carried.file:
        made["description"] = carried.how
    return made


def _lappet_purl(version: str) -> str:
    return f"pkg:pypi/lappet@{quote(version, safe='')}"


def _debian_purl(name: str, version: str, architecture: str) -> str:
    return f"pkg:deb/debian/{quote(name, safe='')}@{quote(version, safe='')}?arch={architecture}"


def _other_files(folder: Path, libraries: list[Carried]) -> list[dict[str, Any]]:
    """The native files that are no libraries of others: the daemon."""
    known = {one.file for one in libraries}
    made: list[dict[str, Any]] = []
    for path in sorted(folder.rglob("*")):
        place = path.relative_to(folder).as_posix()
        if path.is_file() and place not in known and is_native(path.read_bytes()[:4]):
            made.append(_file(place, path.read_bytes()))
    return made


def _viewer(folder: Path) -> list[dict[str, Any]]:
    """What the program of lessons is bundled with, where the wheel has it."""
    place = "lappet/viewer/lesson.js"
    if not (folder / place).is_file():
        return []
    locked = json.loads(NPM_LOCK.read_text(encoding="utf-8"))["packages"]
    own = json.loads((NPM_LOCK.parent / "package.json").read_text(encoding="utf-8"))["dependencies"]
    data = (folder / place).read_bytes()
    made = []
    for name in sorted(set(own) - {"esbuild"}):  # it bundles, and is not in the bundle
        version = locked[f"node_modules/{name}"]["version"]
        one = _component(
            "library", name, version, f"pkg:npm/{name}@{version}", license_of(name), place=place, data=data
        )
        made.append({**one, "bom-ref": f"{place}#{name}", "description": "Bundled into the program of lessons"})
    return made


def _file(place: str, data: bytes) -> dict[str, Any]:
    return {
        "type": "file",
        "bom-ref": place,
        "name": place.rpartition("/")[2],
        "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(data).hexdigest()}],
        "evidence": {"occurrences": [{"location": place}]},
    }


def _wheel(path: Path, place: str) -> dict[str, Any]:
    """A wheel of the extension, with its own bill's components or, where it brings none, its native files in it."""
    data = path.read_bytes()
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = sorted(archive.namelist())
        (described,) = (name for name in names if re.fullmatch(r"[^/]+\.dist-info/METADATA", name))
        metadata = _metadata(archive.read(described).decode())
        own = next((name for name in names if re.fullmatch(rf"[^/]+\.dist-info/sboms/{re.escape(NAME)}", name)), None)
        if own is not None:
            inner = json.loads(archive.read(own))["components"]
        else:
            inner = [_file(name, archive.read(name)) for name in names if is_native(archive.read(name)[:4])]
    name, version = canonical(metadata["Name"]), metadata["Version"]
    license = LICENSE if name == "lappet" else metadata["License-Expression"] or license_of(name)
    purl = f"pkg:pypi/{name}@{quote(version)}?file_name={quote(path.name)}"
    made = _component("library", name, version, purl, license, place=place, data=data)
    if inner:
        made["components"] = [_inside(place, one) for one in inner]
    return made


def _describe_twins(wheels: list[dict[str, Any]]) -> None:
    """Say of libraries in other wheels what Lappet's bill says of its copies of them."""
    parts = [(wheel, part) for wheel in wheels for part in wheel.get("components", ())]
    for wheel, part in parts:
        name = part["name"].partition("-")[0].partition(".")[0]
        for _, twin in parts:
            (ancestor, *_) = twin.get("pedigree", {}).get("ancestors", [{}])
            if twin["name"] == name and ancestor.get("purl") == wheel["purl"].partition("?")[0]:
                part.update({key: twin[key] for key in ("type", "name", "version", "licenses", "purl")})


def _inside(wheel: str, component: dict[str, Any]) -> dict[str, Any]:
    """A component of a wheel's bill as one of the zip's: its place is in the wheel."""
    moved = {**component, "bom-ref": f"{wheel}!/{component['bom-ref']}"}
    if "evidence" in component:
        (occurrence,) = component["evidence"]["occurrences"]
        moved["evidence"] = {"occurrences": [{"location": f"{wheel}!/{occurrence['location']}"}]}
    return moved


def _metadata(text: str) -> Any:
    """The headers of a METADATA file; one that it does not have is None."""
    return Parser().parsestr(text, headersonly=True)
