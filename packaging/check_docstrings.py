"""Check docstrings beyond their layout: `check_docstrings.py [PACKAGE ...]`.

Every public name of `lappet` has a docstring whose first line is one sentence and starts with no verb in the third
person. The names in the `__all__` of `lappet` and its packages, with their public methods, are held to more of
numpydoc's rules: every parameter is described, and so is what is returned. In the packages of `HELD` (or those named)
that goes for every public name of every module, and ruff finds each `raise` that the docstring leaves out. Types are in
the signatures and not asked for here. Prints every breach and exits with 1 if there is one.
"""

from __future__ import annotations

import ast
import builtins
import enum
import importlib
import inspect
import pydoc
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import ModuleType

from numpydoc.docscrape import get_doc_object
from numpydoc.validate import validate

from website.api_pages import PACKAGE, api_packages, offered_names

ROOT = Path(__file__).resolve().parent.parent
FOLDER = ROOT / "shared" / PACKAGE
# Packages whose every public name is held to the rule. A package joins when it passes; none leaves.
HELD = (
    "core",
    "procedure",
    "usd",
    "tissue",
    "checks",
    "designs",
    "cutting",
    "program",
    "daemon",
    "solve",
    "background",
    "output",
    "bench",
    "demo",
    "reports",
    "commands",
)
SUMMARY = frozenset(("GL08", "SS01", "SS02", "SS03", "SS05", "SS06"))
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

    A method without a docstring is left to the one that describes it: of a class that it overrides, or of a protocol in
    the same module.
    """
    yield full_name
    if not inspect.isclass(value):
        return
    described = protocol_methods(sys.modules[value.__module__])
    for base in value.__mro__[1:]:
        described |= {name for name, member in vars(base).items() if inspect.getdoc(member)}
    for name, member in vars(value).items():
        is_method = isinstance(member, (classmethod, staticmethod, property)) or inspect.isfunction(member)
        if is_method and not name.startswith("_") and (member.__doc__ or name not in described):
            yield f"{full_name}.{name}"


def protocol_methods(module: ModuleType) -> set[str]:
    """Names of the methods that the protocols of a module describe."""
    protocols = [value for value in vars(module).values() if inspect.isclass(value) and is_protocol(value)]
    return {name for protocol in protocols for name, member in vars(protocol).items() if inspect.getdoc(member)}


def is_protocol(value: type) -> bool:
    """Whether a class is a protocol itself, not a class that keeps one."""
    return bool(getattr(value, "_is_protocol", False))


def has_own_parameters(full_name: str) -> bool:
    """Whether parameters are asked for: not of a protocol, an enumeration or a class whose base class has them."""
    value = pydoc.locate(full_name)
    if not inspect.isclass(value):
        return True
    return not is_protocol(value) and not issubclass(value, enum.Enum) and "__init__" in vars(value)


def full_names(values: Iterable[object]) -> list[str]:
    """Full names of the functions, classes and methods among values, each once, by the module that defines it."""
    found: dict[str, None] = {}
    for value in values:
        if inspect.isclass(value) or inspect.isfunction(value):
            found.update(dict.fromkeys(with_methods(f"{value.__module__}.{value.__qualname__}", value)))
    return list(found)


def offered() -> list[str]:
    """Full names of what `lappet` and its packages offer in their `__all__`."""
    packages = map(importlib.import_module, api_packages(FOLDER))
    return full_names(getattr(package, name) for package in packages for name in offered_names(package))


def defined(package: str) -> list[str]:
    """Full names of what the modules of a package define.

    Parameters
    ----------
    package
        Name of a folder in `shared/lappet`.

    Returns
    -------
    list of str
        Every public function, class and method.
    """
    modules = map(importlib.import_module, modules_of(package))
    return full_names(getattr(module, name) for module in modules for name in public_names(module))


def rules_by_name(held: Iterable[str]) -> dict[str, frozenset[str]]:
    """The rules that each name is held to.

    Parameters
    ----------
    held
        Packages whose every public name is held to all rules.

    Returns
    -------
    dict of str to frozenset of str
        numpydoc's codes by full name.
    """
    packages = sorted(file.parent.name for file in FOLDER.glob("*/__init__.py"))
    rules = {name: SUMMARY for package in packages for name in defined(package)}
    rules |= {name: RULES for package in held for name in defined(package)}
    return rules | dict.fromkeys(offered(), RULES)


def breaches(full_name: str, rules: frozenset[str]) -> Iterator[str]:
    """One line for each rule that a name's docstring breaks."""
    found = validate(full_name)
    for code, sentence in found["errors"]:
        asked = code in rules
        if asked and code == "PR01":
            missing = [name for name in re.findall(r"'(\w+)'", sentence) if not name.startswith("_")]
            asked = bool(missing) and has_own_parameters(full_name)
        if asked:
            where = Path(found["file"]).resolve()
            place = where.relative_to(ROOT) if where.is_relative_to(ROOT) else where
            yield f"{place}:{found['file_line']}: {full_name}: {code} {sentence}"


def unknown_exceptions(names: Iterable[str]) -> list[str]:
    """Find sections `Raises` that name what is no exception, or one exception twice.

    Parameters
    ----------
    names
        Full names of functions, classes and methods.

    Returns
    -------
    list of str
        A line for each.
    """
    known = {name for name, value in vars(builtins).items() if is_exception(value)}
    for module in [module for name, module in sys.modules.items() if name.partition(".")[0] in (PACKAGE, "click")]:
        known |= {name for name, value in vars(module).items() if is_exception(value)}
    found = []
    for full_name in names:
        raised = [entry.type for entry in get_doc_object(pydoc.locate(full_name))["Raises"]]
        wrong = [name for name in raised if name not in known]
        found += [f"{full_name}: there is no exception {name}" for name in wrong]
        found += [f"{full_name}: raises {name} twice" for name in set(raised) if raised.count(name) > 1]
    return found


def is_exception(value: object) -> bool:
    """Whether a value is a class of exceptions."""
    return inspect.isclass(value) and issubclass(value, BaseException)


def public_lines(file: Path) -> set[int]:
    """Lines at which the docstrings of public functions and methods begin; those of commands are help texts."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    scopes = [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_"))]
    functions = [node for scope in scopes for node in scope.body if isinstance(node, ast.FunctionDef)]
    return {node.body[0].lineno for node in functions if not node.name.startswith("_") and not is_command(node)}


def is_command(function: ast.FunctionDef) -> bool:
    """Whether a function is a command of click's."""
    return any(re.search(r"\.(command|group)\(", ast.unparse(decorator)) for decorator in function.decorator_list)


def undocumented_raises(held: Iterable[str]) -> list[str]:
    """Ruff's findings in the packages held to the full rule: sections that do not agree with the function's body."""
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
        # Ruff takes a function that makes the exception for its class: such names are not capitalized. An assertion is
        # a fault of the function, and a private exception is no promise.
        if int(row) in public_lines(ROOT / file) and not re.search(r"exception `(_|[a-z]|AssertionError)", line):
            found.append(line)
    return found


def main(arguments: list[str]) -> int:
    """Print every breach; 1 if there is one."""
    held = arguments or HELD
    rules = rules_by_name(held)
    found = [breach for name, codes in rules.items() for breach in breaches(name, codes)]
    found += unknown_exceptions(rules) + undocumented_raises(held)
    print("\n".join(found))
    whole = sum(codes == RULES for codes in rules.values())
    print(f"{len(rules)} docstrings checked, {whole} of them in whole: {len(found)} breaches.")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
