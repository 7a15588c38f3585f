"""A lesson as a page: one HTML file with its program, its words and its arrays, which asks for nothing else."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

# Nothing is fetched from anywhere; the program and its styles stand in the file.
_POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
_NOTICE = "font:18px/1.5 system-ui,sans-serif;max-width:34em;margin:12vh auto;padding:0 1.5em;color:CanvasText"


@dataclass(frozen=True)
class LessonBlock:
    """A block of arrays.

    Parameters
    ----------
    data
        The deflated arrays.
    size
        Number of bytes once they are inflated.
    """

    data: bytes
    size: int


def lesson_page(content: dict[str, Any], blocks: Sequence[LessonBlock], program: str) -> str:
    """Make the page.

    A sentence stands first; the program takes it away when it has all it needs. So a file that was cut anywhere
    behind its head shows a sentence.

    Parameters
    ----------
    content
        What the viewer knows of the lesson, for JSON: `title`, `language` and `words` among it, and either
        `procedures` or a list of `parts` of which each has them.
    blocks
        The arrays of the lesson, or of each of its parts.
    program
        The viewer, as JavaScript.

    Returns
    -------
    str
        The page.
    """
    language, title = content["language"], content["title"]
    words = content["words"][language]
    sizes = [{"bytes": len(block.data), "size": block.size} for block in blocks]
    if "parts" in content:
        every = zip(content["parts"], sizes, strict=True)
        told = {**content, "parts": [{**part, **size} for part, size in every]}
        names = [f"arrays-{k}" for k in range(len(blocks))]
    else:
        told = {**content, **sizes[0]}
        names = ["arrays"]
    data = json.dumps(told, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    parts = [
        f'<!doctype html>\n<html lang="{language}">\n<head>\n<meta charset="utf-8">',
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">',
        '<meta name="viewport" content="width=device-width, initial-scale=1, viewport-fit=cover">',
        '<meta name="color-scheme" content="light dark">',
        f'<meta name="generator" content="Lappet {escape(content["version"])}">',
        f"<title>{escape(title)}</title>\n</head>\n<body>",
        f'<main id="notice" style="{_NOTICE}"><h1 style="font-size:1.3em">{escape(title)}</h1>'
        f'<p role="status">{escape(words["opening"])}</p></main>',
        f"<script>\n{program}\n</script>",
        f'<script type="application/json" id="lesson">{data}</script>',
        *(_block(name, block) for name, block in zip(names, blocks, strict=True)),
        "</body>\n</html>\n",
    ]
    return "\n".join(parts)


def _block(name: str, block: LessonBlock) -> str:
    return f'<script type="text/plain" id="{name}">{base64.b64encode(block.data).decode("ascii")}</script>'
