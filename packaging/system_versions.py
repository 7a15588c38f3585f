"""Compare the installed Debian packages with those that CI last ran with: `system_versions.py [--write]`.

packaging/system_versions.txt has the version of every package of system_packages.txt and of all that they depend on.
Prints what differs, and for which packages apt knows an update; `--write` records what is installed. Differences are no
error: Debian's mirrors keep only the newest version of a package, so every point release makes some.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
NAMED = FOLDER / "system_packages.txt"
RECORDED = FOLDER / "system_versions.txt"
HEAD = """\
# The Debian packages that CI last ran with: those of system_packages.txt and all that they depend on. Each line has
# the package, its version, its source package and the version of that.
# Written by packaging/system_versions.py --write, on Debian {release}, {architecture}.
"""
_FIELDS = (
    "${db:Status-Status}\t${Package}\t${Version}\t${source:Package}\t${source:Version}\t${Architecture}"
    "\t${Provides}\t${Pre-Depends}, ${Depends}\n"
)


@dataclass(frozen=True)
class DebianPackage:
    """An installed package as dpkg knows it."""

    name: str
    version: str
    source: str  # the source package it is built from, with its version
    source_version: str
    architecture: str
    provides: tuple[str, ...] = ()
    depends: tuple[tuple[str, ...], ...] = ()  # for each dependency the names that satisfy it


def named(path: Path = NAMED) -> list[str]:
    """The packages of system_packages.txt, in its order."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return [name for line in lines if (name := line.partition("#")[0].strip())]


def installed() -> dict[str, DebianPackage]:
    """Every installed package by its name. Raises FileNotFoundError where there is no dpkg-query."""
    done = subprocess.run(["dpkg-query", "--show", "--showformat", _FIELDS], capture_output=True, text=True, check=True)
    return packages(done.stdout)


def packages(listing: str) -> dict[str, DebianPackage]:
    """What dpkg-query lists, by name; of several architectures of one package the first."""
    found: dict[str, DebianPackage] = {}
    for line in listing.splitlines():
        status, name, version, source, source_version, architecture, provides, depends = line.split("\t")
        if status != "installed" or name in found:
            continue
        provided = tuple(filter(None, (_name(one) for one in provides.split(","))))
        groups = (tuple(filter(None, map(_name, group.split("|")))) for group in depends.split(","))
        found[name] = DebianPackage(
            name, version, source, source_version, architecture, provided, tuple(filter(None, groups))
        )
    return found


def _name(relation: str) -> str:
    """The package of a relation such as `libc6:any (>= 2.34)`."""
    return re.sub(r"[:(\[<].*", "", relation.strip(), flags=re.DOTALL).strip()


def with_dependencies(names: list[str], there: dict[str, DebianPackage]) -> dict[str, DebianPackage]:
    """Those of the packages that are installed, and all installed ones that they depend on, sorted by name."""
    providers: dict[str, list[str]] = {}
    for package in there.values():
        for one in package.provides:
            providers.setdefault(one, []).append(package.name)
    found: dict[str, DebianPackage] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name not in there:
            waiting += [one for one in providers.get(name, ()) if one not in found]
        elif name not in found:
            found[name] = there[name]
            waiting += [one for group in there[name].depends for one in group]
    return dict(sorted(found.items()))


def recorded() -> dict[str, DebianPackage]:
    """The packages of the file by name: versions and sources, without what they provide and depend on."""
    lines = [line for line in RECORDED.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    found = (DebianPackage(*line.split(), architecture="") for line in lines)  # type: ignore[misc]
    return {one.name: one for one in found}


def differences(before: dict[str, DebianPackage], now: dict[str, DebianPackage]) -> list[str]:
    """One line for each package whose version, or presence, is not as recorded."""
    lines: list[str] = []
    for name in sorted(before.keys() | now.keys()):
        old, new = (there[name].version if name in there else None for there in (before, now))
        if old != new:
            lines.append(f"{name}: CI had {old or 'none'}, here is {new or 'none'}")
    return lines


def updates(names: list[str]) -> dict[str, str]:
    """The newer version that apt knows of each package that has one, by what `apt-get update` fetched last."""
    told = subprocess.run(
        ["apt-cache", "policy", *names], capture_output=True, text=True, check=True, env={**os.environ, "LC_ALL": "C"}
    ).stdout
    states = re.findall(r"^(\S+):\n +Installed: (\S+)\n +Candidate: (\S+)$", told, re.MULTILINE)
    return {name: candidate for name, have, candidate in states if have not in ("(none)", candidate)}


def _release() -> str:
    try:
        return Path("/etc/debian_version").read_text(encoding="utf-8").strip()
    except OSError:
        return "of an unknown release"


def main(arguments: list[str] | None = None) -> int:
    """The command. Returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--write", action="store_true", help="record what is installed")
    given = parser.parse_args(arguments)
    try:
        there = installed()
    except FileNotFoundError:
        print("system packages: this is not Debian, so there is nothing to compare.")
        return 0
    now = with_dependencies(named(), there)
    if given.write:
        head = HEAD.format(release=_release(), architecture=there["dpkg"].architecture)
        lines = (f"{one.name} {one.version} {one.source} {one.source_version}\n" for one in now.values())
        RECORDED.write_text(head + "".join(lines), encoding="utf-8")
        return 0
    for line in differences(recorded(), now):
        print(line)
    if waiting := updates(list(now)):
        print(f"Updates wait for {len(waiting)} packages: {' '.join(waiting)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
