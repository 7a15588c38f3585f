"""Write the API reference's pages: one for each package, with the names that it offers, then its modules."""

from __future__ import annotations

import importlib
import inspect
import re
from pathlib import Path
from types import ModuleType

from check_imports import FOLDERS
from website.pages import write_if_changed

PACKAGE = "lappet"
LONGEST_VALUE = 160  # letters of a value that is shown whole


def offered_names(package: ModuleType) -> list[str]:
    """Names that a package offers: what its `__all__` lists, without dunder names."""
    return [name for name in getattr(package, "__all__", []) if not name.startswith("__")]


def write_api_pages(folder: Path, into: Path) -> None:
    """Write `api/index.rst` and a page for each package into the staging folder.

    Parameters
    ----------
    folder
        The package's folder, `shared/lappet`.
    into
        The staging folder.
    """
    top = importlib.import_module(PACKAGE)
    packages = [importlib.import_module(f"{PACKAGE}.{name}") for name in FOLDERS]
    described = {id(getattr(package, name)) for package in (top, *packages) for name in offered_names(package)}
    pages = {f"{package.__name__}.rst": _package_page(package, described) for package in packages}
    pages["index.rst"] = _index_page(top, packages)
    for name, text in pages.items():
        write_if_changed(into / "api" / name, text)
    for file in (into / "api").iterdir():
        if file.name not in pages:
            file.unlink()


def _index_page(top: ModuleType, packages: list[ModuleType]) -> str:
    """The reference's first page: the packages, and the names of `lappet` itself with links to their homes."""
    offering = [_row(package) for package in packages if offered_names(package)]
    others = [_row(package) for package in packages if not offered_names(package)]
    homes = {name: _home(top, name, packages) for name in offered_names(top)}
    names = [(f":py:obj:`{name} <{home}.{name}>`", _summary(getattr(top, name))) for name, home in homes.items()]
    return (
        _heading("Python API", "=")
        + f".. py:module:: {top.__name__}\n\n"
        + f"{inspect.getdoc(top)}\n\n"
        + _table("", names)
        + _heading("Packages that offer names to scripts", "-")
        + _table("", offering)
        + _heading("Other packages", "-")
        + _table("", others)
        + "".join(_description(top, name) for name, home in homes.items() if home == top.__name__)
        + "\n.. toctree::\n   :hidden:\n\n"
        + "".join(f"   {package.__name__}\n" for package in packages)
    )


def _row(package: ModuleType) -> tuple[str, str]:
    """A package's row in a table: a link and its first line."""
    return f":doc:`{package.__name__}`", _summary(package)


def _package_page(package: ModuleType, described: set[int]) -> str:
    """A package's page: each name that it offers in full, then its modules without what is described elsewhere."""
    text = _heading(package.__name__, "=") + f".. automodule:: {package.__name__}\n   :no-members:\n\n"
    names = offered_names(package)
    if names:
        text += _table("", [(f":py:obj:`~{package.__name__}.{name}`", _value_summary(package, name)) for name in names])
    for name in names:
        text += _description(package, name)
    return text + "".join(_module_section(module, described) for module in _modules(package))


def _modules(package: ModuleType) -> list[ModuleType]:
    """The modules below a package, but for what runs when it is imported."""
    folder = Path(package.__path__[0])
    files = [file for file in sorted(folder.rglob("*.py")) if not file.name.startswith("__")]
    names = [".".join((package.__name__, *file.relative_to(folder).with_suffix("").parts)) for file in files]
    return [importlib.import_module(name) for name in names]


def _module_section(module: ModuleType, described: set[int]) -> str:
    """A module's section: its docstring and what it defines."""
    elsewhere = [name for name, value in vars(module).items() if id(value) in described]
    imported = [name for name in offered_names(module) if getattr(module, name).__module__ != module.__name__]
    left_out = sorted({name for name in (*elsewhere, *imported) if not name.startswith("_")})
    section = _heading(module.__name__, "-") + f".. automodule:: {module.__name__}\n   :members:\n"
    return section + (f"   :exclude-members: {', '.join(left_out)}\n\n" if left_out else "\n")


def _description(package: ModuleType, name: str) -> str:
    """The directive that describes a name: a class with its methods, a function, or a value."""
    value = getattr(package, name)
    full_name = f"{package.__name__}.{name}"
    if inspect.isclass(value):
        return f".. autoclass:: {full_name}\n   :members:\n\n"
    if inspect.isroutine(value):
        return f".. autofunction:: {full_name}\n\n"
    return f".. py:data:: {full_name}\n\n   {_value_summary(package, name)}\n\n"


def _value_summary(package: ModuleType, name: str) -> str:
    """The first line about a name: its docstring's, or for a value the value itself."""
    value = getattr(package, name)
    if inspect.isclass(value) or inspect.isroutine(value):
        return _summary(value)
    shown = re.sub(r"<class '([\w.]+)'>", r"\1", repr(value)).replace("ndarray[typing.Any, ", "ndarray[")
    shown = re.sub(r"\b[a-z_]\w*\.(?=[\w.]*\w)", "", shown)  # the modules of classes
    return f"``{shown}``" if len(shown) <= LONGEST_VALUE else f"A value of type ``{type(value).__name__}``."


def _summary(value: object) -> str:
    """The first paragraph of a docstring on one line; nothing where only a builtin's docstring is inherited."""
    docstring = getattr(value, "__doc__", None) or ""
    return " ".join(inspect.cleandoc(docstring).partition("\n\n")[0].split())


def _home(top: ModuleType, name: str, packages: list[ModuleType]) -> str:
    """The package whose page describes a name of `lappet`: its own where no other offers it."""
    value = getattr(top, name)
    for package in packages:
        if name in offered_names(package) and getattr(package, name) is value:
            return package.__name__
    return top.__name__


def _heading(text: str, line: str) -> str:
    return f"{text}\n{line * len(text)}\n\n"


def _table(title: str, rows: list[tuple[str, str]]) -> str:
    lines = "".join(f"   * - {first}\n     - {second}\n" for first, second in rows)
    return f".. list-table:: {title}\n   :widths: 30 70\n\n{lines}\n"
