"""Read packaging/lock.txt: the version of every Python package that is installed here, and the hashes of its files.

`locked.py NAME ...` prints the entries of these packages as pip reads them, for packaging/setup.sh. Needs nothing but
Python 3.11. `lock.py` writes the file.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

LOCK = Path(__file__).resolve().parent / "lock.txt"

_ENTRY = re.compile(r"^(?P<name>[A-Za-z0-9._-]+)==(?P<version>[^\s\\]+)(?P<hashes>(?:\s*\\\n\s+--hash=\S+)+)$", re.M)


@dataclass(frozen=True)
class Locked:
    """One package of the lock."""

    name: str  # as `canonical` writes it
    version: str
    hashes: tuple[str, ...]  # of the files that may be installed, "sha256:…", sorted
    from_source: bool = False  # there is no wheel: pip builds one from the sources, with the locked setuptools

    @property
    def entry(self) -> str:
        """The lines that pip reads."""
        return " \\\n    ".join([f"{self.name}=={self.version}", *(f"--hash={one}" for one in self.hashes)])

    def allows(self, path: Path) -> bool:
        """Whether a file is one of the package's, by its hash."""
        return f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}" in self.hashes


def canonical(name: str) -> str:
    """The one spelling of a package's name: lower case, words joined by `-`."""
    return re.sub(r"[-_.]+", "-", name).lower()


def read(lock: Path = LOCK) -> dict[str, Locked]:
    """Every package of the lock by canonical name. Raises ValueError for a line that is neither entry nor option."""
    text = lock.read_text(encoding="utf-8")
    sources = set(re.findall(r"^--no-binary (\S+)$", text, re.MULTILINE))
    found: dict[str, Locked] = {}
    for match in _ENTRY.finditer(text):
        name = canonical(match["name"])
        hashes = tuple(sorted(re.findall(r"--hash=(\S+)", match["hashes"])))
        if name in found:
            raise ValueError(f"{lock} has {name} twice; make it anew with packaging/lock.py.")
        found[name] = Locked(name, match["version"], hashes, name in sources)
    for line in _ENTRY.sub("", text).splitlines():
        if line and not line.startswith(("#", "--require-hashes", "--only-binary ", "--no-binary ")):
            raise ValueError(f"{lock} has a line without a version or a hash: {line}")
    return found


def entries(packages: Iterable[Locked]) -> str:
    """A file of requirements for pip with these packages, hashes and all."""
    listed = list(packages)
    head = options(one.name for one in listed if one.from_source)
    return "\n".join([*head, "", *(one.entry for one in listed), ""])


def options(from_source: Iterable[str]) -> list[str]:
    """The lines that forbid pip what has no hash, and sources but of the packages that have no wheel."""
    return ["--require-hashes", "--only-binary :all:", *(f"--no-binary {name}" for name in sorted(from_source))]


def locked(name: str, lock: Path = LOCK) -> Locked:
    """A package of the lock. Raises LookupError, naming the file, where it has none of that name."""
    packages = read(lock)
    if canonical(name) not in packages:
        raise LookupError(f"{lock} has no {name}; add it to pyproject.toml and run packaging/lock.py.")
    return packages[canonical(name)]


if __name__ == "__main__":
    try:
        print(entries(locked(name) for name in sys.argv[1:]), end="")
    except (LookupError, ValueError) as error:
        sys.exit(str(error))
