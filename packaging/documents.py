"""Keep the documents true: `documents.py --write` or `documents.py --check`.

`--write` writes `docs/command_line.md` from the command line itself, `docs/problems.md` from the catalogue of
problems, `docs/models.md` from the catalogue of models, `docs/tissues.md` from the presets of tissue, `docs/flaps.md`
and the pages in `docs/flaps` from the flap library and its last atlas, `docs/literature.md` from the literature's rows
and their last run, and `docs/robustness.md` from its last results. Both check that every relative link and picture of
every Markdown file of the repository leads to a file, and every anchor to a heading.
`--check` changes nothing. The exit status is 1 if a page is out of date or a link leads nowhere.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

import click

import label_page
import models_page
import problem_page
import robustness_page

ROOT = Path(__file__).resolve().parent.parent
PAGE = "docs/command_line.md"
TISSUES = "docs/tissues.md"
FLAPS, FLAP_FOLDER, ATLAS = "docs/flaps.md", "docs/flaps", ROOT / "docs" / "atlas.json"
LITERATURE, COMPARED = "docs/literature.md", ROOT / "docs" / "literature.json"
SURROUNDINGS = ROOT / "docs" / "surroundings.json"
SKIPPED = {"build", "dist", "node_modules"}
LINK = re.compile(r"(?<!\\)!?\[[^\]]*\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)")
FENCE = re.compile(r"^(```|~~~).*?^\1\s*$", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#{1,6}\s+(.+?)\s*#*\s*$", re.MULTILINE)
INTRODUCTION = """# The command line

`make docs` writes this page from the program; `lappet COMMAND --help` prints the same text.
"""


def command_help(command: click.Command, name: str, parent: click.Context | None = None) -> Iterator[tuple[str, str]]:
    """Full name and help text of a command and, for a group, of every command below it."""
    settings = {**command.context_settings, "max_content_width": 100, "terminal_width": 100}
    context = click.Context(command, info_name=name, parent=parent, **settings)
    yield context.command_path, command.get_help(context)
    if isinstance(command, click.Group):
        for sub_name in command.list_commands(context):
            sub_command = command.get_command(context, sub_name)
            if sub_command is not None and not sub_command.hidden:
                yield from command_help(sub_command, sub_name, context)


def command_line_page(command: click.Command) -> str:
    """The text of docs/command_line.md for a click command called `lappet`."""
    sections = [f"## {name}\n\n```\n{text.rstrip()}\n```\n" for name, text in command_help(command, "lappet")]
    return "\n".join([INTRODUCTION, *sections])


def heading_anchor(heading: str) -> str:
    """The anchor that GitHub-flavoured Markdown gives a heading."""
    plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
    return re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-")


def markdown_files(root: Path) -> list[Path]:
    """Markdown files of the repository, without what is built, installed or hidden."""
    found = []
    for folder, inner, names in os.walk(root):
        inner[:] = [name for name in inner if not name.startswith(".") and name not in SKIPPED]
        found += [Path(folder) / name for name in names if name.endswith(".md")]
    return sorted(found)


def broken_links(root: Path) -> list[str]:
    """One sentence for each relative link of a Markdown file under `root` that leads nowhere."""
    sentences = []
    for file in markdown_files(root):
        text = FENCE.sub("", file.read_text(encoding="utf-8"))
        for target in LINK.findall(text):
            if re.match(r"[a-z][a-z0-9+.-]*:", target):
                continue
            path, _, anchor = unquote(target).partition("#")
            destination = (file.parent / path).resolve() if path else file
            where = f"{file.relative_to(root)}: the link {target}"
            if not destination.exists():
                sentences.append(f"{where} leads to no file.")
            elif anchor and destination.suffix == ".md":
                headings = HEADING.findall(FENCE.sub("", destination.read_text(encoding="utf-8")))
                if anchor not in map(heading_anchor, headings):
                    sentences.append(f"{where} leads to no heading of {destination.name}.")
    return sentences


def main(arguments: list[str]) -> int:
    """Write or check; 1 where something is wrong, 2 for a wrong call."""
    if arguments not in (["--write"], ["--check"]):
        print(__doc__.splitlines()[0], file=sys.stderr)
        return 2
    from lappet.commands.cli import cli
    from lappet.reports.atlas.design_page import design_pages
    from lappet.reports.atlas.page import flap_page
    from lappet.reports.literature.page import literature_page
    from lappet.reports.tissues.page import tissue_page

    problems = []
    atlas, compared = (json.loads(file.read_text(encoding="utf-8")) for file in (ATLAS, COMPARED))
    flaps = {f"{FLAP_FOLDER}/{name}.md": text for name, text in design_pages(atlas, compared).items()}
    pages = {
        PAGE: command_line_page(cli),
        models_page.PAGE: models_page.models_page(json.loads(SURROUNDINGS.read_text(encoding="utf-8"))["rows"]),
        problem_page.PAGE: problem_page.problem_page(),
        robustness_page.PAGE: robustness_page.robustness_page(),
        label_page.PAGE: label_page.label_page(),
        TISSUES: tissue_page(),
        FLAPS: flap_page(atlas),
        **flaps,
        LITERATURE: literature_page(compared),
    }
    for file in sorted((ROOT / FLAP_FOLDER).glob("*.md")):
        if f"{FLAP_FOLDER}/{file.name}" in flaps:
            continue
        if arguments == ["--write"]:
            file.unlink()
        else:
            problems.append(f"{FLAP_FOLDER}/{file.name} is the page of no design; run `make docs`.")
    for name, text in pages.items():
        page = ROOT / name
        if arguments == ["--write"]:
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(text, encoding="utf-8")
            print(f"wrote {name}")
        elif not page.is_file() or page.read_text(encoding="utf-8") != text:
            problems.append(f"{name} does not say what the program says; run `make docs`.")
    problems += broken_links(ROOT)
    for problem in problems:
        print(problem)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
