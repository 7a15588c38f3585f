"""Make packaging/lock.txt: `lock.py [--raise NAME[==VERSION] ...]`, with the Python of .venv.

Resolves the requirements of pyproject.toml with pip. Versions that are locked stay where the requirements allow them;
those that `--raise` names become the newest allowed, or the one that is named. Writes one entry for each package, with
the hashes of the files that pip may install: the wheels for Debian 12 and the other platforms of the extension, and for
the packages of the extension the wheels of every Python that Blender has. Nothing is installed.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from packaging.requirements import Requirement

from locked import LOCK, Locked, canonical, entries, read
from pypi_wheels import BUNDLED, PLATFORMS, PYTHONS
from requirements import everything

PYTHON = "3.11"  # that of .venv
# Debian 12's C library, 2.36, runs every wheel for an older one.
MANYLINUX = [f"manylinux_2_{minor}" for minor in range(36, 4, -1)]
HEAD = """\
# Every Python package that packaging/setup.sh installs and that the extension carries, with the hashes of its files.
# Written by packaging/lock.py; CONTRIBUTING.md says how to add or raise a package.
"""


def resolve(raised: list[str], lock: Path = LOCK) -> dict[str, str]:
    """The version of each package that the project needs, by canonical name.

    raised: "NAME" or "NAME==VERSION". Raises CalledProcessError where there is no solution; pip has printed why.
    """
    free = {canonical(Requirement(one).name) for one in raised}
    kept = [f"{one.name}=={one.version}" for one in read(lock).values() if one.name not in free]
    with tempfile.TemporaryDirectory() as work:
        constraints, report = Path(work) / "constraints.txt", Path(work) / "report.json"
        constraints.write_text("\n".join(kept), encoding="utf-8")
        command = [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--upgrade", "--no-build-isolation"]
        command += ["--upgrade-strategy=only-if-needed", f"--report={report}", f"--constraint={constraints}"]
        subprocess.run([*command, *everything(), *raised], check=True)
        new = {canonical(one["metadata"]["name"]): one["metadata"] for one in json.loads(report.read_text())["install"]}
    return closure([*everything(), *raised], new)


def closure(roots: list[str], new: dict[str, dict[str, Any]]) -> dict[str, str]:
    """Versions of the roots and of all that they require, by canonical name.

    new: the metadata of the packages that are not installed in the version that they must have.
    """
    versions: dict[str, str] = {}
    waiting = [(Requirement(root), "") for root in roots]
    seen: set[tuple[str, str]] = set()
    while waiting:
        wanted, extra = waiting.pop()
        if wanted.marker is not None and not wanted.marker.evaluate({"extra": extra}):
            continue
        name = canonical(wanted.name)
        if name in new:
            versions[name], requires = new[name]["version"], new[name].get("requires_dist", [])
        else:
            distribution = importlib.metadata.distribution(name)
            versions[name], requires = distribution.version, distribution.requires or []
        for asked in {"", *wanted.extras}:
            if (name, asked) not in seen:
                seen.add((name, asked))
                waiting += [(Requirement(one), asked) for one in requires]
    return versions


class Index:
    """The package index as pip is set up to use it, asked for one platform and Python."""

    def __init__(self, platforms: list[str], python: str) -> None:
        # pip has no command that prints the hashes of files it does not download; its own version is locked.
        from pip._internal.commands import create_command
        from pip._internal.models.target_python import TargetPython

        command: Any = create_command("download")
        given, _ = command.parse_args(["--quiet"])
        major, minor = python.split(".")
        target = TargetPython(platforms=platforms, py_version_info=(int(major), int(minor)), implementation="cp")
        self._finder = command._build_package_finder(given, command._build_session(given), target)

    def file(self, name: str, version: str) -> tuple[str, str] | None:
        """Name and hash ("sha256:…") of the file that pip would install; None where there is none.

        Raises ValueError where the index withdrew it or states no such hash.
        """
        from pip._vendor.packaging.specifiers import SpecifierSet

        best = self._finder.find_best_candidate(name, SpecifierSet(f"=={version}")).best_candidate
        if best is None:
            return None
        if best.link.is_yanked:
            raise ValueError(f"{best.link.filename} was withdrawn ({best.link.yanked_reason}); raise {name}.")
        if best.link.hash_name != "sha256":
            raise ValueError(f"The package index states no SHA-256 of {best.link.filename}.")
        return best.link.filename, f"sha256:{best.link.hash}"


def tags(platform: str) -> list[str]:
    """What pip calls the platform of a development machine, best first; platform: a key of PLATFORMS."""
    if not platform.startswith("linux"):
        return list(PLATFORMS[platform])
    machine = PLATFORMS[platform][0].partition("_2_28_")[2]
    return [f"{tag}_{machine}" for tag in [*MANYLINUX, "manylinux2014"]]


def with_hashes(versions: dict[str, str]) -> list[Locked]:
    """The entries of these packages, sorted by name.

    Raises ValueError where a package has no file for Debian 12 on x86_64, or one of the extension's no wheel.
    """
    indexes = {(platform, PYTHON): Index(tags(platform), PYTHON) for platform in PLATFORMS}
    carried = {
        (platform, python): Index(list(PLATFORMS[platform]), python) for platform in PLATFORMS for python in PYTHONS
    }
    found: list[Locked] = []
    for name, version in sorted(versions.items()):
        files = {where: index.file(name, version) for where, index in indexes.items()}
        own = files["linux-x64", PYTHON]
        if own is None:
            raise ValueError(f"{name} {version} has no file for Debian 12 on x86_64.")
        chosen = {file for file in files.values() if file is not None}
        if name in BUNDLED:
            for where, index in carried.items():
                if (file := index.file(name, version)) is None or not file[0].endswith(".whl"):
                    raise ValueError(f"{name} {version} has no wheel for Python {where[1]} on {where[0]}.")
                chosen.add(file)
        wanted = ".whl" if own[0].endswith(".whl") else ""  # sources only where there is no wheel
        hashes = tuple(sorted({digest for file, digest in chosen if file.endswith(wanted)}))
        found.append(Locked(name, version, hashes, from_source=not wanted))
    return found


def described(package: Locked | None) -> str:
    """What a person is told of an entry."""
    return "nothing" if package is None else f"{package.version} ({len(package.hashes)} files)"


def main(arguments: list[str] | None = None) -> int:
    """The command. Returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--raise", dest="raised", nargs="+", default=[], metavar="NAME", help="NAME or NAME==VERSION")
    given = parser.parse_args(arguments)
    before = read()
    try:
        packages = with_hashes(resolve(given.raised))
    except subprocess.CalledProcessError:
        print("lock: pip found no solution; its message is above.", file=sys.stderr)
        return 1
    except ValueError as error:
        print(f"lock: {error}", file=sys.stderr)
        return 1
    LOCK.write_text(HEAD + entries(packages), encoding="utf-8")
    after = {one.name: one for one in packages}
    for name in sorted(before.keys() | after.keys()):
        old, new = before.get(name), after.get(name)
        if old != new:
            print(f"{name}: {described(old)} -> {described(new)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
