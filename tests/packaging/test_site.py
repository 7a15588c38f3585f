"""The site builds without a warning, its links and anchors lead somewhere, and it needs no other host."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest

import lappet
from build_site import ROOT, build_site
from documents import markdown_files
from website.api_pages import offered_names
from website.pages import FRONT_PAGE, section_pages, stage

OTHER_HOST = re.compile(r"(?:[a-z][a-z0-9+.-]*:)?//", re.IGNORECASE)
# Attributes that make a browser fetch something by itself; a link that a person follows does not.
FETCHED = {"src", "srcset", "data", "poster", "background", "manifest"}
# What a script would have to say to fetch from another host.
SCRIPT_FETCHES = re.compile(
    r"(?:fetch|import|importScripts|open|Worker|WebSocket|EventSource|sendBeacon)\(\s*(?:[\"']GET[\"']\s*,\s*)?[\"'`]"
    r"(?:https?:|wss?:)?//|\.src\s*=\s*[\"'`](?:https?:)?//"
)


@dataclass
class Page(HTMLParser):
    """What a page of the site refers to, and the anchors that it has."""

    links: list[str] = field(default_factory=list)
    fetched: list[str] = field(default_factory=list)
    anchors: set[str] = field(default_factory=set)
    inline: str = ""

    def __post_init__(self) -> None:
        super().__init__()
        self._inside = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._inside = tag
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        self.inline += given.get("style", "")
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        elif "href" in given:
            self.fetched.append(given["href"])
        self.fetched += [given[name] for name in FETCHED & given.keys() if not given[name].startswith("data:")]

    def handle_data(self, data: str) -> None:
        if self._inside in ("style", "script"):
            self.inline += data

    def handle_endtag(self, tag: str) -> None:
        self._inside = ""


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "html"
    assert build_site(folder) == 0, "Sphinx warned; its words stand above"
    return folder


@pytest.fixture(scope="module")
def pages(site: Path) -> dict[Path, Page]:
    found = {}
    for file in site.rglob("*.html"):
        found[file] = Page()
        found[file].feed(file.read_text(encoding="utf-8"))
    return found


@pytest.mark.slow
def test_every_document_is_a_page_and_every_offered_name_is_described(site: Path, pages: dict[Path, Page]) -> None:
    for document in markdown_files(ROOT):
        assert site / document.relative_to(ROOT).with_suffix(".html") in pages
    assert "lappet.procedure.Hook" in pages[site / "api/lappet.procedure.html"].anchors
    assert "lappet.designs.z_plasty" in pages[site / "api/lappet.designs.html"].anchors
    assert "lappet.output.render_cache" in pages[site / "api/lappet.output.html"].anchors
    assert "lappet.cutting.epochs.build_epochs" in pages[site / "api/lappet.cutting.html"].anchors
    for name in offered_names(lappet):
        assert f">{name}<" in (site / "api/index.html").read_text(encoding="utf-8")
    assert (site / "index.html").read_bytes() == (site / FRONT_PAGE).with_suffix(".html").read_bytes()


@pytest.mark.slow
def test_every_link_and_anchor_of_the_site_leads_somewhere(site: Path, pages: dict[Path, Page]) -> None:
    broken = []
    for file, page in pages.items():
        for link in page.links + page.fetched:
            if re.match(r"[a-z][a-z0-9+.-]*:", link):
                continue
            path, _, anchor = unquote(link).partition("#")
            target = (file.parent / path.partition("?")[0]).resolve() if path else file
            if not target.is_file():
                broken.append(f"{file.relative_to(site)}: {link} leads to no file")
            elif anchor and target.suffix == ".html" and anchor not in pages[target].anchors:
                broken.append(f"{file.relative_to(site)}: {link} leads to no anchor")
    assert broken == []


@pytest.mark.slow
def test_the_site_asks_no_other_host_for_anything(site: Path, pages: dict[Path, Page]) -> None:
    asked = []
    for file, page in pages.items():
        name = file.relative_to(site)
        asked += [f"{name}: {link}" for link in page.fetched if OTHER_HOST.match(link)]
        asked += [f"{name}: {text}" for text in style_fetches(page.inline) + SCRIPT_FETCHES.findall(page.inline)]
    for file in site.rglob("*.css"):
        asked += [f"{file.relative_to(site)}: {text}" for text in style_fetches(file.read_text(encoding="utf-8"))]
    for file in site.rglob("*.js"):
        found = SCRIPT_FETCHES.findall(file.read_text(encoding="utf-8"))
        asked += [f"{file.relative_to(site)}: {text}" for text in found]
    assert asked == []


@pytest.mark.slow
def test_search_works_from_a_file_and_finds_documents_and_names(site: Path) -> None:
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    assert index.startswith("Search.setIndex(")  # a script: browsers load no data from a file
    for word in ("z_plasty", "underm", "docs/blender_tutorial"):
        assert word in index


@pytest.mark.slow
def test_pictures_are_in_the_site(site: Path, pages: dict[Path, Page]) -> None:
    shown = [link for link in pages[site / "examples/README.html"].fetched if link.endswith(".png")]
    assert len(shown) >= len(list((ROOT / "examples").glob("*/*.png")))


def style_fetches(text: str) -> list[str]:
    """Addresses of other hosts that a style asks for."""
    asked = re.findall(r"url\(\s*[\"']?([^\"')]+)|@import\s+[\"']([^\"']+)", text)
    return [link for pair in asked for link in pair if OTHER_HOST.match(link)]


def test_a_request_to_another_host_is_seen() -> None:
    page = Page()
    page.feed(
        '<link href="//fonts.example/a.css"><script src="https://cdn.example/a.js"></script><a href="https://example.org">'
        "<style>@import 'https://fonts.example/b.css'; p { background: url(//example.org/a.png) }</style>"
        '<script>fetch("https://example.org/hits")</script>'
    )
    assert [link for link in page.fetched if OTHER_HOST.match(link)] == [
        "//fonts.example/a.css",
        "https://cdn.example/a.js",
    ]
    assert style_fetches(page.inline) == ["https://fonts.example/b.css", "//example.org/a.png"]
    assert len(SCRIPT_FETCHES.findall(page.inline)) == 1
    assert page.links == ["https://example.org"]


def test_a_document_without_a_section_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match=r"no section for elsewhere/page\.md"):
        section_pages([Path("README.md"), Path("elsewhere/page.md")])


def test_staging_again_changes_nothing_and_drops_what_is_gone(tmp_path: Path) -> None:
    root, into = tmp_path / "repository", tmp_path / "pages"
    (root / "docs").mkdir(parents=True)
    (root / "README.md").write_text("# Top\n\n![a](docs/a.png) [b](docs/b.md)\n")
    (root / "docs/a.png").write_bytes(b"a picture")
    (root / "docs/b.md").write_text("# B\n")
    stage(root, into)
    assert (into / "docs/a.png").read_bytes() == b"a picture"
    assert "/docs/b\n" in (into / "README.md").read_text()
    before = {file: file.stat().st_mtime_ns for file in into.rglob("*") if file.is_file()}
    stage(root, into)
    assert before == {file: file.stat().st_mtime_ns for file in into.rglob("*") if file.is_file()}
    (root / "docs/b.md").unlink()
    stage(root, into)
    assert not (into / "docs/b.md").exists()
