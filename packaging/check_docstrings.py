"""Check docstrings beyond their layout, which ruff checks.

Every public function, class and method of `lappet` keeps numpydoc's rules: a first line that is one sentence and starts
with no verb in the third person, and a description of every parameter and of what is returned. Every `raise` is
described, and what a docstring says is raised is an exception that exists. Types are in the signatures and not asked
for here. Prints every breach and exits with 1 if there is one.
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

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = "lappet"
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
SECTIONS = "DOC102,DOC201,DOC402"  # ruff's: parameters that there are not, returns and yields that are left out


def modules(folder: Path) -> Iterator[ModuleType]:
    """Import every module below a folder of `shared`, but for those that run when they are imported."""
    for file in sorted(folder.rglob("*.py")):
        parts = file.relative_to(ROOT / "shared").with_suffix("").parts
        if parts[-1] != "__main__":
            yield importlib.import_module(".".join(parts[:-1] if parts[-1] == "__init__" else parts))


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


def checked_names(folder: Path) -> list[str]:
    """List the public functions, classes and methods of the modules below a folder.

    Parameters
    ----------
    folder
        `shared/lappet`, or a folder in it.

    Returns
    -------
    list of str
        Full names, each by the module that defines it.
    """
    values = [(module, name) for module in modules(folder) for name in public_names(module)]
    return [full for module, name in values for full in with_methods(f"{module.__name__}.{name}", vars(module)[name])]


def breaches(full_name: str) -> Iterator[str]:
    """One line for each of `RULES` that a name's docstring breaks."""
    found = validate(full_name)
    for code, sentence in found["errors"]:
        asked = code in RULES
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


def public_functions(file: Path) -> Iterator[ast.FunctionDef]:
    """Every public function and method of a module that has a docstring; those of commands are help texts."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    scopes = [tree, *(node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_"))]
    for node in (node for scope in scopes for node in scope.body):
        is_public = isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
        if is_public and ast.get_docstring(node) and not is_command(node):
            yield node


def is_command(function: ast.FunctionDef) -> bool:
    """Whether a function is a command of click's."""
    return any(re.search(r"\.(command|group)\(", ast.unparse(decorator)) for decorator in function.decorator_list)


def raised_names(function: ast.FunctionDef) -> Iterator[str]:
    """What a function itself raises: names of exceptions, and of functions that make one."""
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, (ast.FunctionDef, ast.Lambda)):
            continue
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            yield ast.unparse(node.exc.func)
        waiting += ast.iter_child_nodes(node)


def undocumented_raises(file: Path) -> Iterator[str]:
    """Find exceptions that the docstrings of a module's public functions leave out.

    An assertion is a fault of the function, and a private exception is no promise. Where a function makes the exception
    (`raise refused(…)`, `raise DaemonDied.of(…)`), any section `Raises` will do.

    Parameters
    ----------
    file
        The module.

    Yields
    ------
    str
        A line for each.
    """
    for function in public_functions(file):
        section = (ast.get_docstring(function) or "").partition("\nRaises\n---")[2]
        for name in sorted(set(raised_names(function))):
            made = "." in name or name.lstrip("_")[0].islower()
            promised = bool(section) if made else re.search(rf"^{name}$", section, re.MULTILINE) is not None
            if not promised and not re.match(r"_[A-Z]|AssertionError$", name):
                yield f"{file.relative_to(ROOT)}:{function.lineno}: {function.name}: `{name}` is missing in Raises"


def disagreements(folder: Path) -> list[str]:
    """Sections below a folder that do not agree with the function's signature or body."""
    options = ["check", "--quiet", "--preview", "--output-format", "concise", "--select", SECTIONS]
    done = subprocess.run(
        [sys.executable, "-m", "ruff", *options, str(folder)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    files = sorted(folder.rglob("*.py"))
    public = {f"{f.relative_to(ROOT)}:{node.body[0].lineno}" for f in files for node in public_functions(f)}
    found = [line for line in done.stdout.splitlines() if ":".join(line.split(":")[:2]) in public]
    return done.stderr.splitlines() + found + [line for file in files for line in undocumented_raises(file)]


def main() -> int:
    """Print every breach; 1 if there is one."""
    folder = ROOT / "shared" / PACKAGE
    names = checked_names(folder)
    found = [breach for name in names for breach in breaches(name)]
    found += unknown_exceptions(names) + disagreements(folder)
    print("\n".join([*found, f"{len(names)} docstrings checked, {len(found)} breaches."]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
