"""Writes docs/problems.md from the catalogue of problems: by code and by message."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/problems.md"
INTRODUCTION = """# Problems by code and by message

`make docs` writes this page from `shared/lappet/core/texts/`. Every refusal and every warning of `lappet`, of the
Blender extension and of the reports has a code. The code stays the same from release to release; the wording may
change. In Python it is `problem.code`, in a report of `lappet solve --report` it is `code`. Each problem fills the
fields in {braces} with its values. A warning does not prevent the solve: what it names is possible, but probably not
meant, or not to be trusted. A note says what the program does besides, or otherwise than it is told.
"""


def problem_page() -> str:
    """Return the text of docs/problems.md."""
    sys.path[:0] = [] if str(ROOT / "shared") in sys.path else [str(ROOT / "shared")]
    from lappet.core.problem_text import catalogue

    entries = sorted(catalogue().items())
    lines = [INTRODUCTION, "## By message", "", "| message | code |", "|---|---|"]
    for code, text in sorted(entries, key=lambda entry: (_plain(entry[1]), entry[0])):
        lines.append(f"| {_cell(_shown(text.message) or text.title)} | [`{code}`](#{code}) |")
    lines += ["", "## By code", ""]
    for code, text in entries:
        kind = "" if text.severity == "error" else f" ({text.severity})"
        lines += [f"### {code}", "", f"**{text.title}**{kind}", ""]
        message = _shown(text.message) or "in the words of the program that refuses"
        lines += [f"- Message: {message}", f"- Remedy: {_shown(text.remedy) or text.advice}", ""]
    return "\n".join(lines).rstrip() + "\n"


def _shown(text: str) -> str:
    """The template without format specifications; empty where it is one field alone."""
    plain = re.sub(r"\{(\w+)[^{}]*\}", r"{\1}", text)
    return "" if re.fullmatch(r"\{\w+\}", plain) else plain


def _plain(text: object) -> str:
    said = _shown(getattr(text, "message", "")) or str(getattr(text, "title", ""))
    return re.sub(r"[^a-z ]", "", said.lower()).strip()


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
