"""Names that a package re-exports and loads when they are first used, so that importing the package costs nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_exports(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make the `__getattr__` and `__dir__` of a package that loads the names it offers when they are first used.

    Parameters
    ----------
    package
        Dotted name of the package.
    homes
        Module of each name, relative to the package.

    Returns
    -------
    tuple[Callable[[str], Any], Callable[[], list[str]]]
        Both functions.
    """

    def load(name: str) -> Any:
        home = homes.get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{home}"), name)

    def names() -> list[str]:
        return sorted(homes)

    return load, names
