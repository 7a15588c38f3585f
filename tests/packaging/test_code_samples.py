"""The documents' samples work: Python runs, imported names are there, commands and their options exist."""

from __future__ import annotations

import ast
import doctest
import importlib
import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click
import pytest

from blender_operators import operators
from documents import ROOT, markdown_files
from lappet.commands.cli import cli

FENCE = re.compile(r"^( *)```(\w*)[^\n]*\n(.*?)^\1```", re.MULTILINE | re.DOTALL)
CODE_SPAN = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
# Their samples are pieces of something larger: what they import must be there, but they do not run by themselves.
PIECES = {"ARCHITECTURE.md", "CONTRIBUTING.md"}
SHELL = {"", "bash", "console", "sh", "shell"}
PLACEHOLDER = re.compile(r"[A-Z][A-Z_]+|…|\.\.\.")


@dataclass(frozen=True)
class Sample:
    """A fenced piece of a page."""

    page: str
    line: int
    language: str
    text: str

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def samples() -> list[Sample]:
    """Every fence of every Markdown page of the repository."""
    found = []
    for file in markdown_files(ROOT):
        text = file.read_text(encoding="utf-8")
        for match in FENCE.finditer(text):
            line = text.count("\n", 0, match.start()) + 1
            inner = "\n".join(row.removeprefix(match[1]) for row in match[3].splitlines())
            found.append(Sample(file.relative_to(ROOT).as_posix(), line, match[2], inner))
    return found


PYTHON = [sample for sample in samples() if sample.language in ("py", "python")]
BLENDER = [sample for sample in PYTHON if re.search(r"^import bpy$", sample.text, re.MULTILINE)]
RUNNING_PAGES = sorted({s.page for s in PYTHON if s.page not in PIECES and s not in BLENDER})


def missing_names(text: str) -> list[str]:
    """Names that a script imports from lappet and that are not there."""
    missing = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "lappet":
            module = importlib.import_module(str(node.module))
            missing += [f"{node.module}.{alias.name}" for alias in node.names if not hasattr(module, alias.name)]
        elif isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.partition(".")[0] == "lappet":
                    importlib.import_module(alias.name)
    return missing


def unknown_operators(text: str) -> list[str]:
    """Calls of the extension's operators in a script that do not exist, or have no such argument."""
    known = operators()
    unknown = []
    for node in ast.walk(ast.parse(text)):
        match = (
            re.fullmatch(r"(?:bpy\.ops\.)?lappet\.(\w+)", ast.unparse(node.func))
            if isinstance(node, ast.Call)
            else None
        )
        if match is None or not isinstance(node, ast.Call):
            continue
        given = {keyword.arg for keyword in node.keywords if keyword.arg}
        if match[1] not in known:
            unknown.append(match[1])
        elif given - known[match[1]]:
            unknown.append(f"{match[1]}({', '.join(sorted(given - known[match[1]]))})")
    return unknown


@pytest.mark.parametrize("sample", PYTHON, ids=str)
def test_a_python_sample_is_python_and_what_it_imports_is_there(sample: Sample) -> None:
    assert missing_names(sample.text) == []


@pytest.mark.parametrize("sample", BLENDER, ids=str)
def test_a_sample_for_blender_calls_operators_that_exist_with_arguments_that_they_have(sample: Sample) -> None:
    assert unknown_operators(sample.text) == []


def test_the_example_for_blender_calls_operators_that_exist() -> None:
    assert unknown_operators((ROOT / "examples/z_plasty_blender.py").read_text(encoding="utf-8")) == []


@pytest.mark.slow
@pytest.mark.parametrize("page", RUNNING_PAGES)
def test_the_python_samples_of_a_page_run_one_after_the_other(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "store"))
    names: dict[str, object] = {"__name__": "__main__"}
    for sample in PYTHON:
        if sample.page == page and sample not in BLENDER:
            # As many lines down as in the page, so that a traceback tells the place.
            exec(compile("\n" * sample.line + sample.text, str(ROOT / page), "exec"), names)


def command_lines() -> Iterator[tuple[str, str]]:
    """Place and text of every shell line, from fences and from code in the text."""
    for file in markdown_files(ROOT):
        name = file.relative_to(ROOT).as_posix()
        for span in CODE_SPAN.findall(FENCE.sub("", file.read_text(encoding="utf-8"))):
            yield name, span
    for sample in samples():
        if sample.language in SHELL:
            for row in sample.text.splitlines():
                yield str(sample), row.strip().removeprefix("$ ")


def words_of(line: str) -> list[str]:
    """The words of a shell line without its comment; brackets around what may be left out are dropped."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=False)
    lexer.whitespace_split = True
    try:
        words = list(lexer)
    except ValueError:  # a quotation mark of its own: no command
        return []
    return [word.strip("[]") for word in words if word.strip("[].…")]


def wrong_call(words: list[str]) -> str | None:
    """What is wrong with the words after `lappet`, if anything: commands and options must exist, choices be offered."""
    command: click.Command = cli
    context = click.Context(cli, info_name="lappet", **cli.context_settings)
    while isinstance(command, click.Group) and words and not words[0].startswith("-"):
        name, *words = words
        if PLACEHOLDER.fullmatch(name):
            return None
        found = command.get_command(context, name)
        if found is None:
            return f"there is no command {name}"
        command, context = found, click.Context(found, info_name=name, parent=context, **found.context_settings)
    options = {
        name: option for option in command.get_params(context) for name in (*option.opts, *option.secondary_opts)
    }
    for word, following in zip(words, [*words[1:], ""], strict=False):
        if not re.match(r"--?[a-zA-Z]", word):
            continue
        option = options.get(word.partition("=")[0])
        if option is None:
            return f"{command.name} has no option {word}"
        offered = option.type.choices if isinstance(option.type, click.Choice) else ()
        if offered and following and following not in offered and not PLACEHOLDER.fullmatch(following):
            return f"{following} is no choice of {word}"
    return None


def test_every_lappet_command_of_the_documents_exists_with_its_options() -> None:
    wrong, seen = [], 0
    for place, line in command_lines():
        words = words_of(line)
        if words and Path(words[0]).name == "lappet" and "=" not in line.partition("--")[0]:
            seen += 1
            problem = wrong_call(words[1:])
            if problem:
                wrong.append(f"{place}: {line}: {problem}")
    assert seen > 40
    assert wrong == []


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("lappet solve P.usda --spacing 2", None),
        ("lappet report stability -o DIR [--only GROUP] [--quick]", None),
        ("lappet COMMAND --help", None),
        ("lappet solev P.usda", "there is no command solev"),
        ("lappet solve P.usda --spacin 2", "solve has no option --spacin"),
        ("lappet solve P.usda --precision half", "half is no choice of --precision"),
    ],
)
def test_a_wrong_command_is_seen(line: str, problem: str | None) -> None:
    found = wrong_call(words_of(line)[1:])
    assert found is None if problem is None else problem in str(found)


def test_every_make_target_and_script_of_the_documents_exists() -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    wrong, seen = [], 0
    for place, line in command_lines():
        words = [word for word in words_of(line) if not re.fullmatch(r"\w+=\S*", word)]
        tool = Path(words[0]).name if len(words) > 1 else ""
        if tool == "make" and re.fullmatch(r"[a-z-]+", words[1]) and words[1] not in targets:
            wrong.append(f"{place}: make {words[1]}")
        if tool in ("bash", "python") and re.fullmatch(r"(packaging|examples|tests|docs)/\S+", words[1]):
            seen += 1
            if not (ROOT / words[1]).is_file():
                wrong.append(f"{place}: {words[1]}")
    assert seen > 10
    assert wrong == []


def test_examples_in_docstrings_print_what_they_say() -> None:
    tried = 0
    for file in sorted((ROOT / "shared/lappet").rglob("*.py")):
        if ">>> " in file.read_text(encoding="utf-8"):
            parts = file.relative_to(ROOT / "shared").with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            outcome = doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE)
            assert outcome.failed == 0, name
            tried += outcome.attempted
    assert tried > 0
