"""Find what Lappet's wheel carries besides Lappet: the origin of every library in it, and of headers in the daemon.

auditwheel names a copy after its original and the first digits of its hash (`libamd-9f58162f.so.2.4.6`), so a copy
tells which file it was made from, and dpkg which package that file is of. Linux.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from system_versions import DebianPackage, installed

# The packages whose headers are compiled into the daemon; tests/packaging/test_sbom.py compares them with what the
# compiler read. Those of the C and C++ library are left out, as the libraries themselves are.
COMPILED_IN = (
    "cppzmq-dev",
    "libcli11-dev",
    "libeigen3-dev",
    "libfmt-dev",
    "libmsgpack-cxx-dev",
    "libspdlog-dev",
    "libsuitesparse-dev",
    "libtbb-dev",
    "libxsimd-dev",
    "libzmq3-dev",
)
RUN_TIME = ("libc6-dev", "libgcc-12-dev", "libstdc++-12-dev", "linux-libc-dev")
_COPY = re.compile(r"(?P<base>.+)-(?P<digits>[0-9a-f]{8})\.(?P<rest>.+)")


@dataclass(frozen=True)
class Carried:
    """A library in the wheel, or the headers of one in the daemon."""

    name: str
    version: str
    file: str = ""  # its place in the wheel; "" for headers
    debian: DebianPackage | None = None
    wheel: str = ""  # of which it was taken, as "pyzmq==27.3.0", where it is not Debian's
    how: str = "Headers that are compiled into the daemon"  # it is in the wheel, where it has no file


def carried(folder: Path, daemon: Path, taken: Path, wheel: str) -> list[Carried]:
    """The libraries in `lappet.libs` of an unpacked wheel, sorted by name, and the headers in its daemon.

    daemon: before auditwheel changed it. taken: the folder of libraries that were taken from the wheel of another
    project. wheel: that project, as "pyzmq==27.3.0". Raises LookupError for a library of unknown origin.
    """
    packages = installed()
    originals = _loaded(daemon, taken)
    found: list[Carried] = []
    for copy in sorted((folder / "lappet.libs").iterdir()):
        original = _original(copy, originals)
        place = copy.relative_to(folder).as_posix()
        if original.is_relative_to(taken):
            name = original.name.partition("-")[0]
            found.append(Carried(name, _own_version(name, original), place, wheel=wheel))
        else:
            package = packages[_owner(original)]
            found.append(Carried(package.name, package.version, place, debian=package))
    headers = (packages[name] for name in COMPILED_IN)
    return found + [Carried(one.name, one.version, debian=one) for one in headers]


def _loaded(program: Path, libraries: Path) -> dict[str, Path]:
    """The files that the loader takes for a program, by name; `libraries` comes before the system's folders."""
    environment = {**os.environ, "LD_LIBRARY_PATH": str(libraries)}
    told = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=True, env=environment).stdout
    paths = (Path(path).resolve() for path in re.findall(r"=> (/\S+) \(0x", told))
    return {path.name: path for path in paths}


def _original(copy: Path, originals: dict[str, Path]) -> Path:
    match = _COPY.fullmatch(copy.name)
    original = originals.get(f"{match['base']}.{match['rest']}") if match else None
    if match is None or original is None:
        raise LookupError(f"{copy.name} is in the wheel, but the daemon loads no library that it is a copy of.")
    if not hashlib.sha256(original.read_bytes()).hexdigest().startswith(match["digits"]):
        raise LookupError(f"{copy.name} is no copy of {original}: their hashes differ.")
    return original


def _owner(path: Path) -> str:
    """The Debian package of a file, which may be named with or without /usr. Raises LookupError."""
    names = [str(path), str(path).removeprefix("/usr")]
    told = subprocess.run(["dpkg-query", "--search", *names], capture_output=True, text=True, check=False).stdout
    if (match := re.match(r"([a-z0-9][a-z0-9+.-]*)(?::\w+)?: ", told)) is None:
        raise LookupError(f"{path} is of no Debian package, so nobody knows its version and its license.")
    return match.group(1)


# Run in a process of its own, which ends with the library: printing the version that a library states itself.
_ASK = """
import ctypes, json, sys
name, path = sys.argv[1:]
library = ctypes.CDLL(path)
if name == "libzmq":
    numbers = [ctypes.c_int() for _ in range(3)]
    library.zmq_version(*map(ctypes.byref, numbers))
    version = ".".join(str(one.value) for one in numbers)
elif name == "libsodium":
    library.sodium_version_string.restype = ctypes.c_char_p
    version = library.sodium_version_string().decode()
print(json.dumps(version))
"""


def _own_version(name: str, library: Path) -> str:
    """What a library says of itself: libzmq or libsodium. Raises LookupError for others."""
    done = subprocess.run(
        [sys.executable, "-c", _ASK, name, str(library)], capture_output=True, text=True, check=False, timeout=60
    )
    if done.returncode:
        raise LookupError(f"{library.name} does not say its version: {done.stderr.strip()}")
    version: str = json.loads(done.stdout)
    return version
