"""What `--help` says of values: every one that is allowed is named, and is allowed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

import click
import pytest
from click.shell_completion import ShellComplete
from click.testing import CliRunner

from lappet.commands import new_command, render_command, report_command
from lappet.commands.cli import cli
from lappet.core.problem import RefusedError
from lappet.daemon.keys_folder import QUOTA_RANGES
from lappet.designs.library import DESIGNS
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import MODELS, WHOLE_BODIES, new_model
from lappet.models.regional_flaps import REGIONAL_FLAPS
from lappet.output import render
from lappet.reports.error_estimate.hold_out_scenes import hold_out_scenes
from lappet.reports.error_time.run import NAMES
from lappet.reports.literature.rows import ROWS
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


def test_an_option_of_a_number_says_its_range() -> None:
    """But for a time code, which may be any, and coordinates."""
    silent = [
        f"{name} {each.opts[-1]}"
        for name, each in options(cli, "lappet")
        if each.type in (click.FLOAT, click.INT) and each.nargs == 1 and each.opts[-1] != "--start"
        if not re.search(r"\d to \d|up to \d|to \d+|above 0|From 0", (each.help or "").partition("[")[0])
    ]
    assert silent == []


def test_the_ranges_in_the_help_are_those_that_are_allowed() -> None:
    by_name = {f"{name} {each.opts[-1]}": each.help or "" for name, each in options(cli, "lappet")}
    for quota, (least, most) in QUOTA_RANGES.items():
        assert f"{least:g} to {most:.0f}." in by_name[f"lappet keys allow --{quota.replace('_', '-')}"]
    for option, around in (("--skin", (0.3, 5.0)), ("--spacing", (0.05, 20.0)), ("--reach", (0.5, 3.0))):
        least, most = around
        assert f"{least:g} to {most:g}." in by_name[f"lappet models new {option}"]
        field = option.removeprefix("--")
        for value in (0.99 * least, 1.01 * most):
            with pytest.raises(RefusedError, match=f"{field} is"):
                new_model("cheek" if field == "reach" else "patch", ModelChoice(**{field: value}))


@pytest.mark.parametrize(
    ("line", "names"),
    [
        ("flap add", DESIGNS),
        ("flap show", DESIGNS),
        ("report atlas", DESIGNS),
        ("models new", {**MODELS, **WHOLE_BODIES}),
        ("models show", {**MODELS, **WHOLE_BODIES}),
        ("report surroundings", REGIONAL_FLAPS),
        ("report literature", [row.name for row in ROWS]),
    ],
)
def test_the_help_names_what_an_argument_may_be_and_a_shell_completes_it(line: str, names: Iterable[str]) -> None:
    told = CliRunner().invoke(cli, [*line.split(), "--help"]).output
    listed = told.rpartition(": ")[2].replace("-\n", "-").split()
    assert {each.strip(",.") for each in listed} == set(names)
    first = next(iter(names))
    found = ShellComplete(cli, {}, "lappet", "_LAPPET_COMPLETE").get_completions(line.split(), first[:2])
    assert first in {each.value for each in found}
    assert all(each.value.startswith(first[:2]) for each in found)


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
