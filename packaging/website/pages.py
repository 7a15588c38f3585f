"""Stage the site's pages: every Markdown file of the repository with the files that it links to."""

from __future__ import annotations

import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import unquote

from documents import FENCE, LINK, markdown_files

FRONT_PAGE = "README.md"
# Sections of the site and the pages in each, in reading order; a page belongs to the first pattern that it matches.
CONTENTS = (
    (
        "In Blender",
        (
            "docs/blender_tutorial.md",
            "docs/blender_tools.md",
            "docs/blender_plates.md",
            "docs/blender_timeline.md",
            "docs/blender_scripting.md",
            "docs/blender_troubleshooting.md",
            "docs/blender_*.md",
        ),
    ),
    (
        "In the shell and in Python",
        (
            "docs/command_line.md",
            "docs/meshes.md",
            "docs/python_scripting.md",
            "docs/sharing_a_daemon.md",
            "examples/README.md",
            "docs/models.md",
            "docs/materials.md",
            "docs/anatomy.md",
            "docs/tissues.md",
            "docs/flaps.md",
            "docs/literature.md",
            "docs/problem*.md",
            "docs/reports.md",
            "docs/plates.md",
            "docs/label_placement.md",
            "docs/lessons.md",
            "docs/export.md",
            "docs/performance.md",
        ),
    ),
    (
        "How it works",
        (
            "ARCHITECTURE.md",
            "GLOSSARY.md",
            "docs/solver.md",
            "docs/robustness.md",
            "docs/background.md",
            "docs/skin_cache.md",
            "PROTOCOL.md",
            "docs/*.md",
        ),
    ),
    ("Project", ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "*.md", "packaging/*.md", "tests/**/*.md")),
)
# Pages below another page, folded away in the sidebar.
BELOW = {
    "examples/README.md": "examples/*/README.md",
    "docs/flaps.md": "docs/flaps/*.md",
    "docs/plates.md": "docs/gallery/*.md",
}
GALLERY = "gallery"  # the folder of the gallery's files among the downloads
GALLERY_PAGE = Path("docs/gallery/README.md")
API_SECTION = "How it works"  # the API reference closes this section
API_INDEX = "/api/index"


def section_pages(pages: list[Path]) -> list[tuple[str, list[Path]]]:
    """Sort pages into the site's sections.

    Parameters
    ----------
    pages
        Paths relative to the repository.

    Returns
    -------
    list of (str, list of Path)
        Each section's title and its pages in reading order, without the front page and those of `BELOW`.

    Raises
    ------
    ValueError
        If a page belongs to no section.
    """
    below = {page for pattern in BELOW.values() for page in pages if _matches(page, pattern)}
    left = sorted(page for page in pages if page != Path(FRONT_PAGE) and page not in below)
    sections = []
    for title, patterns in CONTENTS:
        taken: list[Path] = []
        for pattern in patterns:
            matching = [page for page in left if _matches(page, pattern)]
            taken += matching
            left = [page for page in left if page not in matching]
        sections.append((title, taken))
    if left:
        names = ", ".join(map(str, left))
        raise ValueError(f"The site has no section for {names}; name one in packaging/website/pages.py.")
    return sections


def stage(root: Path, into: Path, downloads: Path | None = None) -> list[Path]:
    """Copy the repository's pages, and what they link to, into a folder for Sphinx.

    Files that are the same there already are left alone, so that Sphinx reads only what changed.

    Parameters
    ----------
    root
        The repository.
    into
        The staging folder; what is in it from a page that no longer exists is removed.
    downloads
        A folder with files to download, those of a page of `docs/flaps` in a folder of its name, those of the gallery
        in `gallery`; None for none.

    Returns
    -------
    list of Path
        The pages, relative to `root`.
    """
    pages = [page.relative_to(root) for page in markdown_files(root)]
    sections = section_pages(pages)
    wanted = set()
    for page in pages:
        text = (root / page).read_text(encoding="utf-8")
        for file in _linked_files(root, root / page, text):
            wanted.add(file)
            _copy(root / file, into / file)
        if page == Path(FRONT_PAGE):
            text += _contents(sections)
        if pattern := BELOW.get(page.as_posix()):
            text += _tree("", [_document(other) for other in pages if _matches(other, pattern)])
        if downloads is not None and page.parent == Path("docs/flaps"):
            offered = sorted((downloads / page.stem).glob("*"))
            text += download_section([file.name for file in offered], page.stem)
            wanted |= _offer(offered, into, page.parent)
        if downloads is not None and page == GALLERY_PAGE:
            offered = sorted((downloads / GALLERY).glob("*.blend"))
            text = with_project_files(text, [file.name for file in offered])
            wanted |= _offer(offered, into, page.parent)
        wanted.add(page)
        write_if_changed(into / page, text)
    _remove_others(into, wanted)
    return pages


def download_section(names: Sequence[str], design: str) -> str:
    """The end of a design's page: its operations as files, first the one on a patch, which has the design's name."""
    if not names:
        return ""
    said = {".usda": "for the command line and other programs that read USD", ".blend": "for Blender and the extension"}
    lines = []
    for on_patch in (True, False):
        files = [name for name in names if (Path(name).stem == design) == on_patch]
        where = "The operation at its defaults on a flat patch" if on_patch else "The same design on a body (CC0)"
        if files:
            lines += [
                f"{where}, not solved:",
                "",
                *(f"- [{name}]({name}), {said[Path(name).suffix]}" for name in files),
            ]
            lines.append("")
    return "\n".join(["", "## Download", "", *lines])


def with_project_files(text: str, names: Sequence[str]) -> str:
    """The gallery's page with a link below each picture to its Blender file, where that is among the names."""

    def linked(found: re.Match[str]) -> str:
        name = f"{Path(found[1]).stem}.blend"
        if name not in names:
            return found[0]
        said = "this page as a project for Blender with the extension, solved when opened."
        return f"{found[0]}\n\n[{name}]({name}): {said}\n"

    return re.sub(r"^!\[[^\]]*\]\(([^)]+)\)$", linked, text, flags=re.MULTILINE)


def write_if_changed(path: Path, text: str) -> None:
    """Write a text file unless it holds that text already."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _matches(page: Path, pattern: str) -> bool:
    """Whether the page matches; `*` matches no slash, `**/` any number of folders."""
    expression = re.escape(pattern).replace(r"\*\*/", "(?:[^/]+/)*").replace(r"\*", "[^/]*")
    return re.fullmatch(expression, page.as_posix()) is not None


def _contents(sections: list[tuple[str, list[Path]]]) -> str:
    """The front page's hidden tables of contents, from which the sidebar is made."""
    trees = []
    for title, pages in sections:
        names = [_document(page) for page in pages]
        trees.append(_tree(title, [*names, API_INDEX] if title == API_SECTION else names))
    return "".join(trees)


def _document(page: Path) -> str:
    """Sphinx's name of a page, from the top of the staging folder."""
    return f"/{page.with_suffix('').as_posix()}"


def _tree(title: str, names: list[str]) -> str:
    caption = f":caption: {title}\n" if title else ""
    return f"\n```{{toctree}}\n:hidden:\n{caption}\n" + "\n".join(names) + "\n```\n"


def _linked_files(root: Path, page: Path, text: str) -> list[Path]:
    """Files of the repository, other than pages, that a page links to; relative to `root`."""
    found = []
    for target in LINK.findall(FENCE.sub("", text)):
        if re.match(r"[a-z][a-z0-9+.-]*:|#", target):
            continue
        file = (page.parent / unquote(target).partition("#")[0]).resolve()
        if file.is_file() and file.suffix != ".md" and file.is_relative_to(root):
            found.append(file.relative_to(root))
    return found


def _offer(files: Sequence[Path], into: Path, folder: Path) -> set[Path]:
    """Copy files for download beside a page; what they are called in the staging folder."""
    for file in files:
        _copy(file, into / folder / file.name)
    return {folder / file.name for file in files}


def _copy(source: Path, target: Path) -> None:
    if target.is_file() and target.read_bytes() == source.read_bytes():
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(source, target)


def _remove_others(folder: Path, wanted: set[Path]) -> None:
    """Remove files that were staged for pages of before; the API's pages are its own writer's."""
    for file in folder.rglob("*"):
        relative = file.relative_to(folder)
        if file.is_file() and relative not in wanted and relative.parts[0] != "api":
            file.unlink()
