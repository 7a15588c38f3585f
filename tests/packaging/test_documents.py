"""The documents lead somewhere and say what the program says."""

from __future__ import annotations

import re
import tomllib
from dataclasses import fields
from pathlib import Path

import click
import pytest

from documents import PAGE, ROOT, broken_links, command_line_page, heading_anchor
from lappet.program.settings import MaterialParameters, SolverSettings


def test_every_link_of_the_repository_leads_somewhere() -> None:
    assert broken_links(ROOT) == []


def test_the_page_of_the_command_line_is_what_the_program_prints() -> None:
    from lappet.commands.cli import cli

    assert (ROOT / PAGE).read_text(encoding="utf-8") == command_line_page(cli), "run `make docs`"


def test_a_page_holds_every_visible_command_with_its_options() -> None:
    @click.group()
    def lappet() -> None:
        """Flaps."""

    @lappet.command()
    @click.option("--spacing", type=float, help="Lattice edge in mm.")
    def solve(spacing: float) -> None:
        """Find the equilibrium."""

    @lappet.command(hidden=True)
    def secret() -> None:
        """Not for people."""

    page = command_line_page(lappet)
    assert "## lappet\n" in page
    assert "## lappet solve\n" in page
    assert "Usage: lappet solve [OPTIONS]" in page
    assert "Lattice edge in mm." in page
    assert "secret" not in page


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[a](missing.md)", "missing.md leads to no file"),
        ("![a](pictures/missing.png)", "pictures/missing.png leads to no file"),
        ("[a](other.md#no-such-part)", "leads to no heading of other.md"),
        ("[a](#nowhere)", "leads to no heading of page.md"),
    ],
)
def test_a_link_that_leads_nowhere_is_named(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "other.md").write_text("# One part\n")
    (tmp_path / "page.md").write_text(f"# Page\n\n{text}\n")
    (sentence,) = broken_links(tmp_path)
    assert sentence.startswith("page.md: the link ")
    assert said in sentence


def test_a_link_that_leads_somewhere_passes(tmp_path: Path) -> None:
    (tmp_path / "with space.md").write_text("# The `lappet` command, in full\n")
    (tmp_path / "page.md").write_text(
        "# Page\n[a](with%20space.md#the-lappet-command-in-full) [b](https://example.org/none) [c](#page)\n"
        "```\n[in code](none.md)\n```\n"
    )
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "foreign.md").write_text("[a](none.md)")
    assert broken_links(tmp_path) == []


def test_headings_have_the_anchors_that_the_web_page_gives_them() -> None:
    assert heading_anchor("What it is not (yet)") == "what-it-is-not-yet"


def test_the_protocol_describes_every_setting_and_every_parameter_of_a_material() -> None:
    text = (ROOT / "PROTOCOL.md").read_text(encoding="utf-8")
    for start, told in (("`settings`:", SolverSettings), ("`materials`:", MaterialParameters)):
        paragraph = text.partition(f"\n{start}")[2].partition("\n\n")[0]
        assert [item.name for item in fields(told) if f"`{item.name}`" not in paragraph] in ([], ["materials"])


def test_what_the_pages_about_blender_say_to_press_is_there() -> None:
    """Every label of the extension is in the table of its translations; what else is pressed is a key."""
    table = tomllib.loads((ROOT / "addon/lappet_blender/translation/labels.toml").read_text(encoding="utf-8"))
    labels = set(table)
    known = [re.compile(re.sub(r"\\{\w+\\}", ".+", re.escape(label))) for label in labels]
    keys = re.compile(r"((Ctrl|Alt|Shift)-)*(Numpad \d|F\d+|Home|Return|Esc|Tab|Backspace|[A-Z])")
    missing = []
    for page in sorted((ROOT / "docs").glob("blender_*.md")):
        for name in re.findall(r"[Pp]ress \*+([^*]+)\*", page.read_text(encoding="utf-8")):
            if not keys.fullmatch(name) and not any(each.fullmatch(name) for each in known):
                missing.append(f"{page.name}: {name}")
    assert missing == []
