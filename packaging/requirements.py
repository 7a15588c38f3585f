"""The requirements of pyproject.toml, as packaging/lock.py resolves them. Needs nothing but Python 3.11."""

from __future__ import annotations

import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).resolve().parent.parent / "pyproject.toml"
# What installs and builds the others: it is locked as they are.
INSTALLERS = ("pip", "setuptools", "wheel")


def extras(pyproject: Path = PYPROJECT) -> list[str]:
    """The names of the project's extras, sorted."""
    return sorted(tomllib.loads(pyproject.read_text(encoding="utf-8"))["project"]["optional-dependencies"])


def requirements(extras: list[str], pyproject: Path = PYPROJECT) -> list[str]:
    """Requirement specifiers of the project and of the named extras, in the file's order.

    Raises ValueError for an extra that the file does not have.
    """
    project = tomllib.loads(pyproject.read_text(encoding="utf-8"))["project"]
    optional: dict[str, list[str]] = project["optional-dependencies"]
    found: list[str] = list(project["dependencies"])
    for extra in extras:
        if extra not in optional:
            raise ValueError(f"{pyproject} has no extra '{extra}'; it has {', '.join(sorted(optional))}.")
        found += optional[extra]
    return found


def everything(pyproject: Path = PYPROJECT) -> list[str]:
    """Requirement specifiers of the project, of all its extras, of its build, and what installs them."""
    build: list[str] = tomllib.loads(pyproject.read_text(encoding="utf-8"))["build-system"]["requires"]
    return [*requirements(extras(pyproject), pyproject), *build, *INSTALLERS]
