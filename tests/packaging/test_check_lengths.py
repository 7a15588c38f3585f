"""No function is longer than 60 lines, and the check sees those that are."""

from __future__ import annotations

from pathlib import Path

import pytest

import check_lengths
from check_lengths import LIMIT, ROOT, cpp_functions, python_functions, too_long

BODY = "    x += 1;\n"


def write(root: Path, path: str, text: str) -> None:
    file = root / path
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")


def python(lines: int, before: str = "", doc: str = "") -> str:
    """A function of so many lines, its docstring and decorators not counted."""
    return f"{before}def f(x):\n{doc}" + "    x += 1\n" * (lines - 1)


def cpp(lines: int, signature: str = "int f(int x) {\n", end: str = "}\n") -> str:
    """A block of so many lines."""
    return signature + BODY * (lines - signature.count("\n") - end.count("\n")) + end


def test_the_repository_has_no_function_that_is_too_long() -> None:
    assert [str(function) for function in too_long(ROOT)] == []


def test_only_tables_that_are_there_and_are_too_long_are_let_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    tables = set(check_lengths.TABLES)
    monkeypatch.setattr(check_lengths, "TABLES", {})
    assert tables <= {f"{function.file}:{function.name}" for function in too_long(ROOT)}


@pytest.mark.parametrize("folder", ["shared", "addon/lappet_blender", "packaging", "tests/core", "examples/ellipse"])
def test_a_python_function_of_61_lines_is_named_with_its_file_and_line(tmp_path: Path, folder: str) -> None:
    write(tmp_path, f"{folder}/a.py", "\n" + python(LIMIT + 1))
    (found,) = too_long(tmp_path)
    assert str(found) == f"{folder}/a.py:2: f has 61 lines, 60 are allowed."


def test_docstrings_and_decorators_are_not_counted_and_inner_functions_are() -> None:
    doc = '    """What it does.\n\n    And how.\n    """\n'
    (found,) = python_functions(Path("a.py"), python(LIMIT, "@cache\n@other(\n    1\n)\n", doc))
    assert (found.line, found.length) == (5, LIMIT)
    text = "class A:\n    async def g(self):\n        def h():\n            pass\n        return h\n"
    assert {(f.name, f.length) for f in python_functions(Path("a.py"), text)} == {("g", 4), ("h", 2)}


@pytest.mark.parametrize(
    ("text", "name"),
    [
        (cpp(61), "f"),
        (cpp(62, "template <class T>\nint f(int x,\n      T y) {\n") + "\n", "f"),
        (cpp(61, "A::A(int x)\n    : x_(x),\n      y_{x} {\n"), "A::A"),
        (cpp(61, "void System<Number>::solve() const {\n"), "System<Number>::solve"),
        (cpp(61, "A& A::operator=(const A& a) {\n"), "operator="),
        ("namespace a {\nstruct B {\n" + cpp(61, "  int g() {\n", "  }\n") + "};\n}  // namespace a\n", "g"),
        (cpp(61, 'int f(int x) {\n    say("}");  // }\n#ifdef A\n    if (x) {\n    } else {\n    }\n#endif\n'), "f"),
    ],
)
def test_a_cpp_function_of_61_lines_is_found(tmp_path: Path, text: str, name: str) -> None:
    write(tmp_path, "solverd/src/solve/a.cpp", text)
    (found,) = too_long(tmp_path)
    assert found.name == name
    assert found.length == 61


@pytest.mark.parametrize(
    "text",
    [
        cpp(60),
        cpp(99, "namespace a {\n"),
        cpp(99, "class A : public B<int(int)> {\n", "};\n"),
        cpp(40) + cpp(40),
        cpp(40, end="\n}\n\n") + "int g() { return 1; }\n" + cpp(40),
    ],
)
def test_what_is_no_long_function_passes(tmp_path: Path, text: str) -> None:
    write(tmp_path, "solverd/src/solve/a.h", text)
    assert too_long(tmp_path) == []


def test_kernels_and_tables_may_be_longer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "solverd/src/force/a_kernel.h", cpp(99))
    write(tmp_path, "solverd/src/force/a_kernels_avx2.cpp", cpp(99))
    write(tmp_path, "shared/a.py", python(99))
    monkeypatch.setattr(check_lengths, "TABLES", {"shared/a.py:f": "a list of cases"})
    assert too_long(tmp_path) == []


def test_functions_are_measured_and_the_blocks_in_them_are_not() -> None:
    block = "  if (g(x)) {\n    g(1);\n  } else {\n    g(2);\n  }\n"
    text = f"int f(int x) {{\n{block}  return x;\n}}\n\nvoid h() {{\n  g(1);\n}}\n"
    assert [(f.name, f.line, f.length) for f in cpp_functions(Path("a.cpp"), text)] == [("f", 1, 8), ("h", 10, 3)]
