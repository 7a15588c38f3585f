"""Check that no function has more than 60 lines.

In Python a function's docstring and decorators are not counted. In C++ the lines from the signature to the closing
brace are; kernel files are left out, because a kernel is one block of arithmetic. The sources are taken to be formatted
by clang-format: a function's last line is a `}` that is indented as its signature is. Prints every function that is too
long and exits with 1 if there is one.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parent.parent
LIMIT = 60  # lines
PYTHON_FOLDERS = ("shared", "addon", "packaging", "tests", "examples")
CPP_FOLDER = "solverd/src"
# Functions that only list cases and may be longer: "file:function" and the reason.
TABLES: dict[str, str] = {}

# How statements begin that end in a block and are no functions.
_NO_FUNCTION = re.compile(
    r"\}|(namespace|class|struct|union|enum|extern|if|else|for|while|do|switch|try|catch|case|default)\b"
)


class Function(NamedTuple):
    """A function and how long it is."""

    file: Path
    line: int
    name: str
    length: int

    def __str__(self) -> str:
        """Return one line for a person who looks for the function."""
        return f"{self.file}:{self.line}: {self.name} has {self.length} lines, {LIMIT} are allowed."


def python_functions(file: Path, text: str) -> Iterator[Function]:
    """Measure every function of a Python module, also those inside of others.

    Parameters
    ----------
    file
        The module.
    text
        What is in it.

    Yields
    ------
    Function
        Each function.
    """
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            assert node.end_lineno is not None
            length = node.end_lineno - node.lineno + 1
            first = node.body[0]
            if ast.get_docstring(node, clean=False) is not None and first.end_lineno is not None:
                length -= first.end_lineno - first.lineno + 1
            yield Function(file, node.lineno, node.name, length)


def cpp_functions(file: Path, text: str) -> Iterator[Function]:
    """Measure every function of a C++ file that clang-format has formatted.

    Parameters
    ----------
    file
        The file.
    text
        What is in it.

    Yields
    ------
    Function
        Each function, without lambdas and without those that fit on one line.
    """
    lines = [_without_literals(line) for line in text.splitlines()]
    for last in (number for number, line in enumerate(lines) if line.strip() == "}"):
        first = _beginning(lines, last)
        statement = " ".join(line.strip() for line in lines[first:last]).partition("{")[0]
        name = re.search(r"(operator\W+|[\w:~]+(?:<[^()\s]*>[\w:~]+)?)\(", statement)
        if name is not None and not _NO_FUNCTION.match(statement):
            yield Function(file, first + 1, name[1], last - first + 1)


def _without_literals(line: str) -> str:
    """A line without its comment and without what its literals hold."""
    return re.sub(r"\s*//.*", "", re.sub(r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])\'', '""', line))


def _beginning(lines: list[str], last: int) -> int:
    """The line where the statement begins that ends on line `last`: the nearest above that is indented as much."""
    indent = _indent(lines[last])
    above = (number for number in range(last - 1, -1, -1) if lines[number].strip() and lines[number].lstrip()[0] != "#")
    return next((number for number in above if _indent(lines[number]) <= indent), last)


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


def too_long(root: Path) -> list[Function]:
    """Find the functions of a checkout that are too long and no tables.

    Parameters
    ----------
    root
        The checkout.

    Returns
    -------
    list of Function
        Them, by file and line.
    """
    found: list[Function] = []
    for folder in PYTHON_FOLDERS:
        for file in sorted((root / folder).rglob("*.py")):
            found += python_functions(file.relative_to(root), file.read_text(encoding="utf-8"))
    for file in sorted((root / CPP_FOLDER).rglob("*")):
        if file.suffix in (".h", ".cpp") and "_kernel" not in file.name:
            found += cpp_functions(file.relative_to(root), file.read_text(encoding="utf-8"))
    long = [function for function in found if function.length > LIMIT]
    return [function for function in long if f"{function.file}:{function.name}" not in TABLES]


def main() -> int:
    """Print every function that is too long; 1 if there is one."""
    found = too_long(ROOT)
    print("\n".join([*map(str, found), f"{len(found)} functions are longer than {LIMIT} lines."]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
