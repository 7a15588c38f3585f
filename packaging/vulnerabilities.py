"""Check that no locked package has a known vulnerability: `vulnerabilities.py [--update]`.

Reads packaging/known_vulnerabilities.json and asks nobody. Fails where a version of packaging/lock.txt, or of a library
of Debian that the wheel carries, is affected and nobody judged it; warns where the file is old or does not know the
version. `--update` asks the registries: PyPI for Python packages, Debian's security tracker for the libraries. What
they answer is written down as it is, and nothing else; judgments stay, which people write into the file.
"""

from __future__ import annotations

import argparse
import datetime
import json
import subprocess
import sys
import urllib.error
import urllib.request
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote

from packaging.version import Version

import locked
import sbom
import system_versions

KNOWN = Path(__file__).resolve().parent / "known_vulnerabilities.json"
OLD = datetime.timedelta(days=90)
DEBIAN_TRACKER = "https://security-tracker.debian.org/tracker/data/json"
RELEASE = "bookworm"
REGISTRIES = {"pypi": "PyPI", "debian": "Debian's security tracker"}


@dataclass(frozen=True, order=True)
class Pin:
    """A version that is installed or carried."""

    registry: str  # a key of REGISTRIES
    name: str  # of the Python package, or of Debian's source package
    version: str


@dataclass(frozen=True)
class Advisory:
    """What a registry says of one version."""

    id: str
    registry: str
    name: str
    version: str  # the one that was asked about, which it affects
    aliases: tuple[str, ...] = ()
    summary: str = ""
    fixed_in: tuple[str, ...] = ()

    def affects(self, pin: Pin) -> bool:
        """Whether it affects a pin, as far as can be told: what is not known to be repaired is affected."""
        if (pin.registry, pin.name) != (self.registry, self.name):
            return False
        if pin.version == self.version or not self.fixed_in:
            return True
        return all(_before(pin, version) for version in self.fixed_in)


@dataclass
class Known:
    """The file."""

    updated: dict[str, str | None] = field(default_factory=lambda: dict.fromkeys(REGISTRIES))  # the day, ISO 8601
    asked: dict[str, dict[str, str]] = field(default_factory=lambda: {one: {} for one in REGISTRIES})  # name: version
    advisories: list[Advisory] = field(default_factory=list)
    judged: list[dict[str, str]] = field(default_factory=list)  # id, name, reason


def read(path: Path = KNOWN) -> Known:
    """The file as a value. Raises ValueError for a judgment without a reason."""
    values = json.loads(path.read_text(encoding="utf-8"))
    advisories = [
        Advisory(**{key: tuple(value) if isinstance(value, list) else value for key, value in one.items()})
        for one in values["advisories"]
    ]
    for one in values["judged"]:
        if not all(one.get(key, "").strip() for key in ("id", "name", "reason")):
            raise ValueError(f"{path} has a judgment without id, name or reason: {one}")
    return Known(values["updated"], values["asked"], advisories, values["judged"])


def write(known: Known, path: Path = KNOWN) -> None:
    """Write the file, in an order that makes differences small."""
    known.advisories.sort(key=lambda one: (one.registry, one.name, one.id))
    known.asked = {registry: dict(sorted(names.items())) for registry, names in known.asked.items()}
    path.write_text(json.dumps(asdict(known), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def pins() -> list[Pin]:
    """What the lock installs, and the sources of the libraries of Debian that the wheel carries or has compiled in."""
    python = [Pin("pypi", one.name, one.version) for one in locked.read().values()]
    debian = {
        Pin("debian", one.source, one.source_version)
        for one in system_versions.recorded().values()
        if one.name in sbom.LICENSES
    }
    return python + sorted(debian)


def check(known: Known, pinned: list[Pin], today: datetime.date) -> tuple[list[str], list[str]]:
    """Failures and warnings, each a sentence."""
    judged = {(one["id"], one["name"]) for one in known.judged}
    failures: list[str] = []
    used: set[tuple[str, str]] = set()
    for pin in pinned:
        for one in known.advisories:
            if not one.affects(pin):
                continue
            if (one.id, one.name) in judged:
                used.add((one.id, one.name))
                continue
            repaired = f"repaired in {', '.join(one.fixed_in)}" if one.fixed_in else "not repaired yet"
            names = ", ".join([one.id, *one.aliases])
            failures.append(f"{pin.name} {pin.version}: {names}, {repaired}. {one.summary}".rstrip())
    stale = sorted(judged - used)
    warnings = [f"The judgment of {key} for {name} is about nothing: take it out." for key, name in stale]
    for registry, title in REGISTRIES.items():
        day = known.updated[registry]
        if day is None:
            warnings.append(f"{title} was never asked: run vulnerabilities.py --update where it can be reached.")
            continue
        if today - datetime.date.fromisoformat(day) > OLD:
            warnings.append(f"{title} was last asked on {day}: run vulnerabilities.py --update.")
        asked = known.asked[registry]
        unknown = [pin for pin in pinned if pin.registry == registry and asked.get(pin.name) != pin.version]
        if unknown:
            listed = ", ".join(f"{pin.name} {pin.version}" for pin in unknown)
            warnings.append(f"{title} has not answered about {len(unknown)} of the versions: {listed}.")
    return failures, warnings


def update(known: Known, pinned: list[Pin], today: datetime.date, *, pypi: str, debian: str) -> list[str]:
    """Ask the registries and write their answers into `known`; returns which of them could not be reached, and why.

    pypi: where PyPI's JSON interface is, without a slash at the end. debian: the tracker's whole data.
    """
    unreachable: list[str] = []
    for registry, ask, address in (("pypi", _ask_pypi, pypi), ("debian", _ask_debian, debian)):
        wanted = [pin for pin in pinned if pin.registry == registry]
        try:
            answers = ask(wanted, address)
        except (OSError, ValueError) as error:
            unreachable.append(f"{REGISTRIES[registry]}: {error}")
            continue
        if wanted and not answers:
            unreachable.append(f"{REGISTRIES[registry]}: it knows none of the versions")
            continue
        known.updated[registry] = today.isoformat()
        asked = {**known.asked[registry], **{pin.name: pin.version for pin in answers}}
        known.asked[registry] = {pin.name: asked[pin.name] for pin in wanted if pin.name in asked}
        silent = {pin.name for pin in wanted} - {pin.name for pin in answers}
        known.advisories = [one for one in known.advisories if one.registry != registry or one.name in silent]
        known.advisories += [one for found in answers.values() for one in found]
    return unreachable


def _ask_pypi(wanted: list[Pin], address: str) -> dict[Pin, list[Advisory]]:
    """The advisories of each version that PyPI answers about.

    Where it has no page of the version, the package's serves if that, the newest version's, is about the one asked for.
    """
    answers: dict[Pin, list[Advisory]] = {}
    for pin in wanted:
        package = f"{address}/{quote(pin.name)}"
        page = _get(f"{package}/{quote(pin.version)}/json") or _get(f"{package}/json")
        if page is None or page["info"]["version"] != pin.version or "vulnerabilities" not in page:
            continue
        answers[pin] = [
            Advisory(
                one["id"],
                "pypi",
                pin.name,
                pin.version,
                tuple(one.get("aliases") or ()),
                one.get("summary") or (one.get("details") or "").partition("\n")[0][:200],
                tuple(one.get("fixed_in") or ()),
            )
            for one in page["vulnerabilities"]
            if not one.get("withdrawn")
        ]
    return answers


def _ask_debian(wanted: list[Pin], address: str) -> dict[Pin, list[Advisory]]:
    """What is open for each source package in the release, or repaired in a later version than the one that is had."""
    data = _get(address)
    if data is None:
        raise ValueError("there is no data at its address")
    answers: dict[Pin, list[Advisory]] = {pin: [] for pin in wanted}
    for pin, found in answers.items():
        for name, issue in data.get(pin.name, {}).items():
            state = issue.get("releases", {}).get(RELEASE)
            if state is None or state["status"] == "undetermined":
                continue
            fixed = tuple(filter(None, [state.get("fixed_version")]))
            if state["status"] == "open" or any(_before(pin, version) for version in fixed):
                found.append(Advisory(name, "debian", pin.name, pin.version, (), issue.get("description", ""), fixed))
    return answers


def _before(pin: Pin, version: str) -> bool:
    """Whether the pinned version is older than the other."""
    if pin.registry == "pypi":
        return Version(pin.version) < Version(version)
    compared = subprocess.run(["dpkg", "--compare-versions", pin.version, "lt", version], check=False)
    return compared.returncode == 0


def _get(address: str) -> Any:
    """The JSON at an address; None where there is no such page. Raises OSError, ValueError."""
    try:
        with urllib.request.urlopen(address, timeout=60) as answer:
            return json.load(answer)
    except urllib.error.HTTPError as error:
        if error.code == 404:
            return None
        raise


def _pypi_address() -> str:
    from pip._internal.models.index import PyPI

    address: str = PyPI.pypi_url
    return address


def main(arguments: list[str] | None = None) -> int:
    """The command. Returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--update", action="store_true", help="ask the registries first")
    parser.add_argument("--pypi", help="another address of PyPI's JSON interface")
    parser.add_argument("--debian", default=DEBIAN_TRACKER, help="another address of the tracker's data")
    given = parser.parse_args(arguments)
    known, pinned, today = read(), pins(), datetime.date.today()
    unreachable: list[str] = []
    if given.update:
        unreachable = update(known, pinned, today, pypi=given.pypi or _pypi_address(), debian=given.debian)
        write(known)
    failures, warnings = check(known, pinned, today)
    for line in unreachable:
        print(f"vulnerabilities: no answer of {line}", file=sys.stderr)
    for line in warnings:
        print(f"vulnerabilities: warning: {line}", file=sys.stderr)
    for line in failures:
        print(f"vulnerabilities: {line}", file=sys.stderr)
    if failures:
        print(f"vulnerabilities: raise these, or judge them in packaging/{KNOWN.name} with a reason.", file=sys.stderr)
    return 1 if failures or unreachable else 0


if __name__ == "__main__":
    sys.exit(main())
