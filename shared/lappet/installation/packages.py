"""The Python packages that Lappet needs, and those of its extras."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib import metadata

from lappet.installation.finding import Finding

# What an extra is for; those of developers are not looked at.
PURPOSES = {
    "render": "pictures by Blender (lappet render, lappet demo)",
    "plates": "line drawings for print (lappet plate)",
    "report": "plots (lappet report)",
}
_DEVELOPERS = frozenset({"test", "docs", "dev", "examples"})
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_EXTRA = re.compile(r"extra\s*==\s*['\"]([^'\"]+)['\"]")


def check_packages(requirements: Iterable[str] | None = None) -> list[Finding]:
    """Find which of the packages that Lappet names are installed.

    Parameters
    ----------
    requirements
        Requirements as of Python's metadata, like "shapely>=2.0; extra == 'plates'"; those of the installed Lappet
        when None.

    Returns
    -------
    list[Finding]
        One for what every command needs, and one for each extra.
    """
    if requirements is None:
        try:
            requirements = metadata.requires("lappet") or []
        except metadata.PackageNotFoundError:
            return [Finding("packages", "ok", "a checkout that is not installed: its packages are not known")]
    needed: dict[str, list[str]] = {"": []}
    for each in requirements:
        name, of_extra = _NAME.match(each), _EXTRA.search(each)
        if name is not None:
            needed.setdefault(of_extra[1] if of_extra else "", []).append(name[0])
    findings = [_finding("packages", needed.pop(""), "what every command needs", "", "broken")]
    for extra, names in sorted(needed.items()):
        if extra not in _DEVELOPERS:
            install = f'pip install "lappet[{extra}]"'
            findings.append(_finding(f"extra {extra}", names, PURPOSES.get(extra, ""), install, "missing"))
    return findings


def _finding(name: str, packages: list[str], purpose: str, install: str, otherwise: str) -> Finding:
    versions = {each: _version(each) for each in sorted(set(packages), key=str.lower)}
    absent = [each for each, version in versions.items() if version is None]
    if not absent:
        return Finding(name, "ok", ", ".join(f"{each} {version}" for each, version in versions.items()))
    value = f"{', '.join(absent)} {'is' if len(absent) == 1 else 'are'} not installed"
    remedy = install or f"pip install {' '.join(absent)}"
    return Finding(
        name, "broken" if otherwise == "broken" else "missing", f"{value}; for {purpose}" if purpose else value, remedy
    )


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None
