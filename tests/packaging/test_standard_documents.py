"""The repository's standard documents are valid and agree with the project."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from cffconvert import Citation

ROOT = Path(__file__).resolve().parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_citation_is_valid_and_of_this_version() -> None:
    citation = Citation(text("CITATION.cff"))
    citation.validate()
    assert re.search(r"^version: (.+)$", text("CITATION.cff"), re.MULTILINE)[1] == PROJECT["version"]
    assert PROJECT["license"] in text("CITATION.cff")


def test_the_changelog_has_its_sections_in_order() -> None:
    titles = re.findall(r"^## (.+)$", text("CHANGELOG.md"), re.MULTILINE)
    assert titles[0] == "[Unreleased]"
    assert [title for title in titles[1:] if not re.fullmatch(r"\[\d+\.\d+\.\d+\] - \d{4}-\d{2}-\d{2}", title)] == []
    assert titles[1].startswith(f"[{PROJECT['version']}]")
    kinds = set(re.findall(r"^### (.+)$", text("CHANGELOG.md"), re.MULTILINE))
    assert kinds <= {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def test_every_promise_of_the_security_page_names_tests_that_are_there() -> None:
    rows = re.findall(r"^\| [^|]+ \| [^|]+ \| (`.+) \|$", text("SECURITY.md"), re.MULTILINE)
    assert len(rows) >= 5
    for name in (name for row in rows for name in re.findall(r"`([^`]+)`", row)):
        assert (ROOT / name).is_file() if "/" in name else list((ROOT / "tests").rglob(f"test_{name}.py")), name
