"""The pages about the extension say what it says: messages, operators and arguments."""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from blender_operators import operators
from lappet.core.problem_text import catalogue

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
ADDON = ROOT / "addon" / "lappet_blender"
PYTHON = (ADDON, ROOT / "shared" / "lappet")
CATALOGUE = ROOT / "shared" / "lappet" / "core" / "texts"
CPP = ROOT / "solverd" / "src"
LEAST = 9  # letters of a piece of a message that tell anything


def python_words(tree: ast.AST) -> Iterator[str]:
    """Every text of a module, what is filled in as …"""
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield re.sub(r"\{[^{}]*\}", "…", node.value)
        elif isinstance(node, ast.JoinedStr):
            yield "".join(str(v.value) if isinstance(v, ast.Constant) else "…" for v in node.values)


@pytest.fixture(scope="module")
def said() -> str:
    """Everything that the program can say, one text a line."""
    words = [
        text for folder in PYTHON for file in folder.rglob("*.py") for text in python_words(ast.parse(file.read_text()))
    ]
    for file in CATALOGUE.glob("*.toml"):
        for entry in tomllib.loads(file.read_text(encoding="utf-8")).values():
            words += [re.sub(r"\{[^{}]*\}", "…", entry.get(name, "")) for name in ("message", "remedy")]
    for file in CPP.rglob("*.cpp"):
        whole = re.sub(r'"\s*\n\s*"', "", file.read_text(encoding="utf-8"))
        words += [re.sub(r"\{[^{}]*\}", "…", text) for text in re.findall(r'"((?:[^"\\]|\\.)*)"', whole)]
    for text in catalogue().values():
        words += [re.sub(r"\{[^{}]*\}", "…", f"{text.message} {text.remedy}")]
    return "\n".join(words)


def messages() -> list[str]:
    """The messages of the page on troubleshooting: what stands in backticks in the first column of its tables."""
    rows = re.findall(r"^\| (`.+?) \|", (DOCS / "blender_troubleshooting.md").read_text(encoding="utf-8"), re.MULTILINE)
    return [message for row in rows for message in re.findall(r"`([^`]+)`", row)]


def is_said(piece: str, said: str) -> bool:
    """Whether a text says the piece, or two texts of which one is filled into the other do."""
    if piece in said:
        return True
    cuts = range(1, len(piece))
    return any(piece[:cut].strip() in said and piece[cut:].strip(" ,.;:") in said for cut in cuts)


def test_every_message_on_the_troubleshooting_page_is_one_that_the_program_says(said: str) -> None:
    assert len(messages()) > 100
    unknown = []
    for message in messages():
        pieces = [piece.strip(" .,:;()'\"") for piece in re.split("…|Incision: ", message)]
        telling = [piece for piece in pieces if len(piece) >= LEAST]
        if not telling or not all(is_said(piece, said) for piece in telling):
            unknown.append(message)
    assert not unknown, "\n".join(unknown)


def test_every_operator_and_argument_on_the_scripting_page_is_there() -> None:
    known = operators()
    text = (DOCS / "blender_scripting.md").read_text(encoding="utf-8").partition("## Operators")[2]
    rows = re.findall(r"^\| (`.+?) \| (.*) \|$", text, re.MULTILINE)
    assert len(rows) > 25
    for names, arguments in rows:
        listed = re.findall(r"`([a-z_]+)`", names)
        assert set(listed) <= set(known), names
        offered = set().union(*(known[name] for name in listed))
        outside = re.sub(r"\([^()]*\([^()]*\)[^()]*\)|\([^()]*\)", "", arguments)
        assert set(re.findall(r"`([a-z_]+)`", outside)) <= offered, (names, arguments)


def test_every_act_that_scripts_can_do_is_on_the_scripting_page() -> None:
    text = (DOCS / "blender_scripting.md").read_text(encoding="utf-8")
    # What only a mouse does, and what panels call about a problem that they show.
    by_hand = {"ignore_click", "failure_show", "problem_show", "tissue_show_problem"}
    by_hand |= {name for name in operators() if name.startswith(("draw_", "place_", "click_", "edit_"))}
    by_hand |= {"annotation_add", "annotation_drag"}
    missing = {name for name in operators() if f"`{name}`" not in text} - by_hand
    assert not missing
