"""Check the sections of docstrings: `check_docstrings.py [PACKAGE ...]`.

Every name in the `__all__` of `lappet` and its packages, with its public methods, is held to numpydoc's rules: a first
line that is one sentence, every parameter described, what is returned described. In the packages of `HELD` (or those
named) every public name of every module is, and ruff finds each `raise` that the docstring leaves out. Types are in the
signatures and not asked for here. Prints every breach and exits with 1 if there is one.
"""

from __future__ import annotations

import ast
import enum
import importlib
import inspect
import pydoc
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

from numpydoc.validate import validate

from website.api_pages import PACKAGE, api_packages, offered_names

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "shared" / PACKAGE
# Packages whose every public name is held to the rule. A package joins when it passes; none leaves.
HELD = ("core", "procedure", "usd", "tissue", "designs", "cutting")
# numpydoc's codes, by section. Not asked for: types (PR04, RT02), longer summaries, examples, the place of quotes.
RULES = frozenset(
    f"{section}{number}"
    for section, numbers in (
        ("GL", ("03", "06", "07", "08")),
        ("SS", ("01", "02", "03", "05", "06")),
        ("PR", ("01", "02", "03", "06", "07", "08", "09", "10")),
        ("RT", ("01", "03", "04", "05")),
        ("YD", ("01",)),
    )
    for number in numbers
)
RAISES = "DOC102,DOC201,DOC402,DOC501"


def modules_of(package: str) -> list[str]:
    """List a package's modules.

    Parameters
    ----------
    package
        Name of a folder in `shared/lappet`.

    Returns
    -------
    list of str
        Dotted names of the package and of every module below it that can be imported without being run.
    """
    names = []
    for file in sorted((FOLDER / package).rglob("*.py")):
        parts = file.relative_to(FOLDER.parent).with_suffix("").parts
        if parts[-1] != "__main__":
            names.append(".".join(parts[:-1] if parts[-1] == "__init__" else parts))
    return names


def public_names(module: ModuleType) -> list[str]:
    """List the public functions and classes that a module defines itself."""
    return [
        name
        for name, value in vars(module).items()
        if not name.startswith("_")
        and (inspect.isclass(value) or inspect.isfunction(value))
        and value.__module__ == module.__name__
    ]


def with_methods(full_name: str, value: object) -> Iterator[str]:
    """Full names of a function or class and, for a class, of the public methods that it defines itself.

    A method without a docstring whose module has a protocol that describes it is left to that description.
    """
    yield full_name
    if not inspect.isclass(value):
        return
    described = protocol_methods(sys.modules[value.__module__])
    for name, member in vars(value).items():
        is_method = isinstance(member, (classmethod, staticmethod, property)) or inspect.isfunction(member)
        if is_method and not name.startswith("_") and (inspect.getdoc(member) or name not in described):
            yield f"{full_name}.{name}"


def protocol_methods(module: ModuleType) -> set[str]:
    """Names of the methods that the protocols of a module describe."""
    protocols = [value for value in vars(module).values() if inspect.isclass(value) and is_protocol(value)]
    return {name for protocol in protocols for name, member in vars(protocol).items() if inspect.getdoc(member)}


def is_not_called(value: object) -> bool:
    """Whether a class is not made by a call with parameters of its own: a protocol or an enumeration."""
    return inspect.isclass(value) and (is_protocol(value) or issubclass(value, enum.Enum))


def is_protocol(value: type) -> bool:
    """Whether a class is a protocol itself, not a class that keeps one."""
    return bool(getattr(value, "_is_protocol", False))


def checked_names(held: tuple[str, ...]) -> list[str]:
    """Every name that is checked.

    Parameters
    ----------
    held
        Packages whose every public name is checked.

    Returns
    -------
    list of str
        Full names of functions, classes and methods, each once, by the module that defines it.
    """
    found: dict[str, None] = {}

    def add(value: object) -> None:
        if inspect.isclass(value) or inspect.isfunction(value):
            found.update(dict.fromkeys(with_methods(f"{value.__module__}.{value.__qualname__}", value)))

    for package in map(importlib.import_module, api_packages(FOLDER)):
        for name in offered_names(package):
            add(getattr(package, name))
    for module in map(importlib.import_module, (name for package in held for name in modules_of(package))):
        for name in public_names(module):
            add(getattr(module, name))
    return list(found)


def breaches(full_name: str) -> Iterator[str]:
    """One line for each rule that a name's docstring breaks."""
    found = validate(full_name)
    for code, sentence in found["errors"]:
        if code in RULES and not (code == "PR01" and is_not_called(pydoc.locate(full_name))):
            where = Path(found["file"]).resolve()
            place = where.relative_to(ROOT) if where.is_relative_to(ROOT) else where
            yield f"{place}:{found['file_line']}: {full_name}: {code} {sentence}"


def public_lines(file: Path) -> set[int]:
    """Lines at which the docstrings of a module's public functions and methods begin."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    scopes = [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_"))]
    functions = [node for scope in scopes for node in scope.body if isinstance(node, ast.FunctionDef)]
    return {node.body[0].lineno for node in functions if not node.name.startswith("_")}


def undocumented_raises(held: tuple[str, ...]) -> list[str]:
    """Ruff's findings in the packages held to the full rule: sections that do not agree with the function's body."""
    if not held:
        return []
    options = ["check", "--quiet", "--preview", "--output-format", "concise", "--select", RAISES]
    folders = [str(FOLDER / package) for package in held]
    done = subprocess.run(
        [sys.executable, "-m", "ruff", *options, *folders], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.stderr:
        return done.stderr.splitlines()
    found = []
    for line in done.stdout.splitlines():
        file, row, _ = line.split(":", 2)
        # Ruff takes a function that makes the exception for its class; such names are not capitalized.
        if int(row) in public_lines(ROOT / file) and not re.search(r"exception `_?[a-z]", line):
            found.append(line)
    return found


def main(arguments: list[str]) -> int:
    """Print every breach; 1 if there is one."""
    held = tuple(arguments) or HELD
    names = checked_names(held)
    found = [breach for name in names for breach in breaches(name)] + undocumented_raises(held)
    print("\n".join(found))
    print(f"{len(names)} docstrings checked, {len(found)} breaches.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
