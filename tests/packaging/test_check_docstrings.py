"""The check of docstrings passes, and sees what it is there to see."""

from __future__ import annotations

import sys
import types
from pathlib import Path

import pytest

import check_docstrings
from check_docstrings import PACKAGE, ROOT, breaches, checked_names, disagreements, unknown_exceptions

GOOD = '''
def spread(points, width=1.0):
    """Spread points along x.

    Parameters
    ----------
    points
        Points in mm, shape (n, 3).
    width
        Length in mm.

    Returns
    -------
    ndarray
        Points in mm, shape (n, 3).
    """
    return points
'''


def load(source: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> str:
    """Make a module of a source, and return the full name of its function `spread`."""
    file = tmp_path / "spread_points.py"
    file.write_text(source)
    module = types.ModuleType("spread_points")
    module.__file__ = str(file)
    exec(compile(source, str(file), "exec"), module.__dict__)
    monkeypatch.setitem(sys.modules, "spread_points", module)
    return "spread_points.spread"


def codes(source: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> set[str]:
    """The rules that the function `spread` of a module breaks."""
    return {line.split(": ", 2)[2].split()[0] for line in breaches(load(source, monkeypatch, tmp_path))}


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("Spread points", "Spread points", ""),
        ('"""Spread points along x.', '"""Spreads points along x.', "SS05"),
        ("along x.", "along x", "SS03"),
        ("    width\n        Length in mm.\n", "", "PR01"),
        ("    width\n", "    length\n", "PR02"),
        ("        Length in mm.\n", "", "PR07"),
        ("    Returns\n    -------\n    ndarray\n        Points in mm, shape (n, 3).\n", "", "RT01"),
        ("    ndarray\n        Points in mm, shape (n, 3).\n", "    ndarray\n", "RT03"),
    ],
)
def test_what_a_docstring_leaves_out_is_seen(
    old: str, new: str, code: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert old in GOOD
    found = codes(GOOD.replace(old, new), monkeypatch, tmp_path)
    assert code in found if code else found == set()


def test_an_exception_that_there_is_not_is_seen(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    section = "\n    Raises\n    ------\n    {}\n        If it fails.\n"
    for name, wrong in (("ValueError", 0), ("RefusedError", 0), ("NoSuchError", 1)):
        source = GOOD.replace('    """\n    return', section.format(name) + '    """\n    return')
        assert len(unknown_exceptions([load(source, monkeypatch, tmp_path)])) == wrong


@pytest.mark.parametrize(
    ("raising", "said"),
    [
        ("raise ValueError(width)", "`ValueError` is missing"),
        ("raise refused(width)", "`refused` is missing"),
        ("raise SomeError.of(width)", "`SomeError.of` is missing"),
        ("raise _Private(width)", None),
    ],
)
def test_a_raise_that_is_not_described_is_seen(
    raising: str, said: str | None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(check_docstrings, "ROOT", tmp_path)
    (tmp_path / "ruff.toml").write_text('[lint.pydocstyle]\nconvention = "numpy"\n')
    source = GOOD.replace("    return points", f"    if width < 0:\n        {raising}\n    return points")
    (tmp_path / "spread.py").write_text(source)
    found = disagreements(tmp_path)
    assert [said in line for line in found] == [True] if said else found == []
    raises = "\n    Raises\n    ------\n    ValueError\n        If the width is negative.\n"
    (tmp_path / "spread.py").write_text(source.replace('    """\n    if', raises + '    """\n    if'))
    assert disagreements(tmp_path) == []


def test_every_docstring_keeps_the_rules() -> None:
    names = checked_names(ROOT / "shared" / PACKAGE)
    for name in ("lappet.procedure.events.Hook", "lappet.designs.z_plasty_design.z_plasty"):
        assert name in names
    assert len(names) > 500
    assert [breach for name in names for breach in breaches(name)] == []
    assert unknown_exceptions(names) == []
    assert disagreements(ROOT / "shared" / PACKAGE) == []
