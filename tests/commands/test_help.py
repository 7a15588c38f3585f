"""What `--help` says of values: every one that is allowed is named, and is allowed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import click
import pytest

from lappet.commands import new_command, render_command, report_command
from lappet.commands.cli import cli
from lappet.output import render
from lappet.reports.error_estimate.hold_out_scenes import hold_out_scenes
from lappet.reports.error_time.run import NAMES
from lappet.reports.stability.run import chosen_cases
from lappet.tissue import mesh_file

# What somebody makes up: the words of a title, the name of what a file holds.
FREE = {"--title", "--step", "--landmark", "--defect"}


def options(command: click.Command, name: str) -> Iterator[tuple[str, click.Option]]:
    """The options of a command and of the commands in it, with the command's name."""
    if isinstance(command, click.Group):
        for each, inner in command.commands.items():
            yield from options(inner, f"{name} {each}")
    yield from ((name, each) for each in command.params if isinstance(each, click.Option))


def test_an_option_of_text_says_what_is_allowed() -> None:
    silent = [
        f"{name} {each.opts[-1]}"
        for name, each in options(cli, "lappet")
        if each.type is click.STRING and not each.metavar and each.opts[-1] not in FREE
    ]
    assert silent == []


def test_the_values_in_the_help_are_those_that_are_allowed() -> None:
    assert tuple(render.VIEWS) == render_command.VIEWS
    assert tuple(render.COLORS) == render_command.COLORS
    assert tuple(render.ENGINES) == render_command.ENGINES
    assert set(new_command.UNITS) == set(mesh_file.UNITS)
    assert tuple(dict.fromkeys(case.group for case in chosen_cases([], quick=False))) == report_command.GROUPS


@pytest.mark.parametrize(
    ("command", "names"),
    [
        (report_command.error_time, NAMES),
        (report_command.error_estimate, [scene.name for scene in hold_out_scenes()]),
        (report_command.stability, " ".join(report_command.GROUPS).split()),
    ],
)
def test_the_help_of_a_report_names_all_that_it_measures(command: click.Command, names: Iterable[str]) -> None:
    words = set(re.findall(r"[\w-]+", command.help or ""))
    assert set(names) <= words
