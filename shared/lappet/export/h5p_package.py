"""A lesson as a package of H5P, with the small library that shows it: `H5P.Lappet`."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from lappet.export.scorm_package import zip_of

LIBRARY = "H5P.Lappet"
VERSION = (1, 0, 0)  # raise the last number whenever a file of the library changes
_PAGE = "lesson.txt"  # H5P platforms let no .html into a package


def h5p_package(page: str, title: str, language: str) -> bytes:
    """Pack a lesson.

    Parameters
    ----------
    page
        The lesson's page, which reports to the page around it.
    title
        Its title.
    language
        Code of the language that it opens in.

    Returns
    -------
    bytes
        The package: what it is, the library, the lesson.
    """
    major, minor, _ = VERSION
    depends = {"machineName": LIBRARY, "majorVersion": major, "minorVersion": minor}
    about = {
        "title": title,
        "language": language,
        "mainLibrary": LIBRARY,
        "embedTypes": ["iframe"],
        "license": "U",
        "preloadedDependencies": [depends],
    }
    content = {"page": {"path": _PAGE, "mime": "text/plain", "copyright": {"license": "U"}}}
    folder = f"{LIBRARY}-{major}.{minor}"
    library = files("lappet.export") / "h5p_library"
    return zip_of(
        {
            "h5p.json": _json(about),
            "content/content.json": _json(content),
            f"content/{_PAGE}": page.encode("utf-8"),
            f"{folder}/library.json": _json(_library()),
            f"{folder}/semantics.json": (library / "semantics.json").read_bytes(),
            f"{folder}/lesson.js": (library / "lesson.js").read_bytes(),
            f"{folder}/lesson.css": (library / "lesson.css").read_bytes(),
        }
    )


def _library() -> dict[str, Any]:
    major, minor, patch = VERSION
    return {
        "title": "Lappet lesson",
        "description": "A solved operation that turns, plays, explains and asks",
        "machineName": LIBRARY,
        "majorVersion": major,
        "minorVersion": minor,
        "patchVersion": patch,
        "runnable": 1,
        "fullscreen": 0,
        "embedTypes": ["iframe"],
        "author": "Lappet",
        "license": "GPL3",
        "coreApi": {"majorVersion": 1, "minorVersion": 24},
        "preloadedJs": [{"path": "lesson.js"}],
        "preloadedCss": [{"path": "lesson.css"}],
    }


def _json(value: dict[str, Any]) -> bytes:
    return json.dumps(value, ensure_ascii=False, indent=1).encode("utf-8") + b"\n"
