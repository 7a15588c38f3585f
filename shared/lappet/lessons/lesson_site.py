"""A lesson as a site: a folder with a page for each chapter and one that lists them, which needs no server."""

from __future__ import annotations

import base64
import re
import shutil
import tempfile
from collections.abc import Sequence
from html import escape
from pathlib import Path

from lappet.core.durable import write_whole
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.core.version import version
from lappet.export.lesson_delivery import delivered
from lappet.lessons.chapter_picture import SIZE, chapter_picture
from lappet.lessons.lesson_course import lesson_course
from lappet.lessons.lesson_plan import LessonPlan
from lappet.lessons.plan_sources import ChapterSource
from lappet.output.png_writer import write_png

INDEX = "index.html"
_LIFTED = 0.55  # of the steps: about there a picture tells most of an operation
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; img-src data:"
_STYLE = """
:root { color-scheme: light dark; font: 17px/1.5 system-ui, sans-serif }
body { max-width: 76rem; margin: 0 auto; padding: 1.5rem }
h1 { font-size: 1.9rem; margin: 0.5rem 0 0.2rem }
ul { list-style: none; padding: 0; display: grid; gap: 1.25rem;
  grid-template-columns: repeat(auto-fill, minmax(17rem, 1fr)) }
li { border: 1px solid color-mix(in srgb, CanvasText 22%, transparent); border-radius: 0.6rem; overflow: hidden }
a { color: inherit; text-decoration: none; display: block; height: 100% }
a:hover h2, a:focus-visible h2 { text-decoration: underline }
a:focus-visible { outline: 3px solid Highlight; outline-offset: -3px }
img { width: 100%; height: auto; display: block }
div { padding: 0.7rem 1rem 1rem }
h2 { font-size: 1.12rem; margin: 0 0 0.3rem }
p { margin: 0 0 0.4rem } small { opacity: 0.8 }
@media print { li { break-inside: avoid } }
"""


def is_site(target: Path) -> bool:
    """Tell whether a lesson is to become a site.

    Parameters
    ----------
    target
        What is to be written.

    Returns
    -------
    bool
        Whether it has no suffix, as folders have none.
    """
    return not target.suffix


def check_site(target: Path) -> None:
    """Refuse a folder that holds something else.

    Parameters
    ----------
    target
        The folder.

    Raises
    ------
    RefusedError
        If it is there, is not empty and is no site of Lappet, or is a file.
    """
    if target.is_file():
        raise refused(ProblemCode.LESSON_SITE, target, "a file of that name is there")
    if target.is_dir() and any(target.iterdir()):
        index = target / INDEX
        if not index.is_file() or 'content="Lappet' not in index.read_text(encoding="utf-8", errors="replace"):
            raise refused(ProblemCode.LESSON_SITE, target, "it holds other files")


def write_site(plan: LessonPlan, sources: Sequence[ChapterSource], target: Path) -> None:
    """Write the site; it takes the place of one that was there once all of it is written.

    Parameters
    ----------
    plan
        The plan.
    sources
        The solved procedure of each chapter.
    target
        The folder.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    folder = target.absolute().parent
    with tempfile.TemporaryDirectory(prefix=f".{target.name}-", dir=folder) as work:
        made = Path(work) / target.name
        made.mkdir()
        cards = []
        for number, source in enumerate(sources, 1):
            name = f"{number:02d}_{_plain(source.plan.title)}.html"
            own = LessonPlan(plan.path, source.plan.title, plan.language, None, (source.plan,))
            content, blocks = lesson_course(own, [source])
            write_whole(made / name, delivered(content, blocks, ".html"))
            cards.append(_card(name, source, Path(work) / "card.png"))
        write_whole(made / INDEX, _index(plan, cards).encode())
        if target.is_dir():
            shutil.move(target, Path(work) / "before")
        shutil.move(made, target)


def _plain(title: str) -> str:
    return re.sub(r"[^a-z0-9]+", "_", title.lower()).strip("_") or "chapter"


def _card(name: str, source: ChapterSource, work: Path) -> str:
    steps = source.shown.steps
    time = steps[int(_LIFTED * len(steps))].time if steps else source.shown.frames[-1]
    write_png(chapter_picture(source.shown, time), work)
    picture = base64.b64encode(work.read_bytes()).decode("ascii")
    text = f"<p>{escape(source.plan.text[0])}</p>" if source.plan.text else ""
    title = escape(source.plan.title)
    return (
        f'<li><a href="{name}"><img alt="" width="{SIZE[0]}" height="{SIZE[1]}" src="data:image/png;base64,{picture}">'
        f"<div><h2>{title}</h2>{text}</div></a></li>"
    )


def _index(plan: LessonPlan, cards: Sequence[str]) -> str:
    title = escape(plan.title)
    return "\n".join(
        [
            f'<!doctype html>\n<html lang="{plan.language}">\n<head>\n<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f'<meta name="generator" content="Lappet {escape(version())}">',
            f"<title>{title}</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n<ul>",
            *cards,
            "</ul>\n</main>\n</body>\n</html>\n",
        ]
    )
