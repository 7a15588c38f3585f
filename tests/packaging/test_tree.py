"""README's tables of folders, ARCHITECTURE.md, the order that imports keep and the tree say the same."""

from __future__ import annotations

import ast
import re
import subprocess
from pathlib import PurePosixPath

import pytest

import check_imports
from documents import ROOT, markdown_files

PYTHON, DAEMON, ADDON = "shared/lappet", "solverd/src", "addon/lappet_blender"
ORDERS = {
    PYTHON: check_imports.FOLDERS,
    DAEMON: check_imports.LAYERS,
    ADDON: check_imports.ADDON_FOLDERS,
}
CODE_SPAN = re.compile(r"(?<!`)`([^`\n]+)`(?!`)")
PATH = re.compile(r"\.?[\w-][\w.-]*(/[\w.-]+)*/?")
MADE = {"build", "dist", ".venv"}  # not in the repository: what commands make
RECIPES = ["Add a material", "Add an event", "Add a setting", "Add a flap design", "Add a report"]
MOST_FILES = 5


def tracked() -> list[PurePosixPath]:
    """Every file that git tracks and that is there."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [PurePosixPath(path) for path in listed.split("\0") if path and (ROOT / path).is_file()]


FILES = tracked()
TOP = {path.parts[0] for path in FILES if len(path.parts) > 1}


def text(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def rows() -> list[str]:
    """The folders of README's tables, in order, without their closing slash."""
    return [row.rstrip("/") for row in re.findall(r"^\| `([\w./-]+/)` \|", text("README.md"), re.MULTILINE)]


def folders_below(top: str, suffixes: set[str]) -> set[str]:
    """Folders below `top`, relative to it, that hold sources themselves."""
    own = {path.parent for path in FILES if path.suffix in suffixes and path.is_relative_to(top)}
    return {folder.relative_to(top).as_posix() for folder in own if folder != PurePosixPath(top)}


def sections(page: str, level: str) -> dict[str, str]:
    """The text below each heading of a level, up to the next heading of it."""
    parts = re.split(rf"^{level} (.+)$", text(page), flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2], strict=True))


@pytest.mark.parametrize("top", ORDERS)
def test_readme_lists_the_folders_of_each_part_in_the_order_of_imports(top: str) -> None:
    listed = [row.removeprefix(f"{top}/") for row in rows() if row.startswith(f"{top}/")]
    assert listed == list(ORDERS[top])


@pytest.mark.parametrize("top", ORDERS)
def test_the_order_of_imports_holds_exactly_the_folders_of_the_tree(top: str) -> None:
    found = folders_below(top, {".py", ".h", ".cpp"})
    if top != DAEMON:
        found = {folder.split("/")[0] for folder in found}
    assert found == set(ORDERS[top])


def test_every_folder_of_the_repository_has_its_line_in_readme() -> None:
    listed = rows()
    assert [row for row in listed if not (ROOT / row).is_dir()] == []
    assert len(listed) == len(set(listed))
    shown = {PurePosixPath(row).parts[0] for row in listed}
    assert {top for top in TOP if not top.startswith(".")} == shown


def test_the_tests_mirror_the_folders_that_they_test() -> None:
    own = {row.removeprefix("tests/") for row in rows() if row.startswith("tests/")}
    found = {path.parts[1] for path in FILES if path.parts[0] == "tests" and len(path.parts) > 2}
    assert found - own <= set(check_imports.FOLDERS)
    assert own <= found
    daemon = {path.parts[2] for path in FILES if path.is_relative_to("solverd/tests") and len(path.parts) > 3}
    assert daemon <= {layer.split("/")[0] for layer in check_imports.LAYERS}


def test_a_test_module_lies_in_the_folder_of_something_that_it_imports() -> None:
    lost = []
    for path in FILES:
        if path.parts[0] != "tests" or len(path.parts) != 3 or not path.name.startswith("test_"):
            continue
        folder = path.parts[1]
        if folder in check_imports.FOLDERS and f"lappet.{folder}" not in text(path.as_posix()):
            lost.append(path.as_posix())
    assert lost == []


@pytest.mark.parametrize("top", [PYTHON, ADDON])
def test_every_python_package_says_what_belongs_in_it(top: str) -> None:
    silent = []
    for folder in sorted({top, *(f"{top}/{folder}" for folder in folders_below(top, {".py"}))}):
        file = ROOT / folder / "__init__.py"
        if not file.is_file() or not ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))):
            silent.append(folder)
    assert silent == []


def test_architecture_has_a_section_for_each_folder_in_order() -> None:
    parts = sections("ARCHITECTURE.md", "##")
    for title, top in (("The Python package", PYTHON), ("The daemon", DAEMON), ("The Blender extension", ADDON)):
        assert re.findall(r"\*\*`([\w/]+)/`\*\*", parts[title]) == list(ORDERS[top]), title


def named_paths(page: str, body: str) -> list[str]:
    """Paths of the repository among the code spans of a text.

    A page may shorten a path of `shared/lappet/`, `solverd/src/` or `addon/lappet_blender/` where it is about these.
    """
    found = []
    for span in CODE_SPAN.findall(body):
        if "/" not in span or not PATH.fullmatch(span):
            continue
        first = span.split("/")[0]
        if first in TOP or (page == "ARCHITECTURE.md" and first not in MADE):
            found.append(span)
    return found


def is_there(path: str) -> bool:
    """Whether a path exists, from the repository or from one of its three parts."""
    return any((ROOT / top / path).exists() for top in ("", *ORDERS))


@pytest.mark.parametrize("page", [file.relative_to(ROOT).as_posix() for file in markdown_files(ROOT)])
def test_every_path_that_a_document_names_is_there(page: str) -> None:
    assert [path for path in named_paths(page, text(page)) if not is_there(path)] == []


def test_the_recipes_are_there_and_each_touches_few_files() -> None:
    recipes = {
        title: body.split("\n## ")[0] for title, body in sections("ARCHITECTURE.md", "###").items() if title in RECIPES
    }
    assert list(recipes) == RECIPES
    for title, body in recipes.items():
        files = {path for path in named_paths("ARCHITECTURE.md", body) if "." in PurePosixPath(path).name}
        folders = set(named_paths("ARCHITECTURE.md", body)) - files
        assert 1 <= len(files) <= MOST_FILES, (title, files)
        assert all(is_there(path) for path in files | folders), title
