"""Names that a package re-exports and loads when they are first used, so that importing the package costs nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def lazy_exports(
    package: str, modules: Mapping[str, Sequence[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Make the `__getattr__` and `__dir__` of a package that loads the names it offers when they are first used.

    Parameters
    ----------
    package
        Dotted name of the package.
    modules
        The names that each module has, the module relative to the package.

    Returns
    -------
    tuple[Callable[[str], Any], Callable[[], list[str]]]
        Both functions.
    """
    homes = {name: module for module, names in modules.items() for name in names}

    def load(name: str) -> Any:
        home = homes.get(name)
        if home is None:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(f"{package}.{home}"), name)

    return load, lambda: sorted(homes)
