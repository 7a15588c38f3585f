"""Runs of the command line in this process."""

from __future__ import annotations

from click.testing import CliRunner, Result

from lappet.commands.cli import cli


def run(*arguments: object) -> Result:
    """`lappet` with these arguments."""
    return CliRunner().invoke(cli, [str(each) for each in arguments])


def is_one_sentence(text: str) -> bool:
    return len(text.strip().splitlines()) == 1 and "Traceback" not in text
