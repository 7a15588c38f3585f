"""Every command and option that `lappet` 0.1 had is still there: scripts written for 0.1 still run."""

from __future__ import annotations

import click
import pytest

from lappet.commands.cli import cli

SOLVING = (
    "--spacing --tolerance --quadrature --precision --store --daemon --error-estimate --no-error-estimate --strain "
    "--no-strain --whole -o --output"
)
OPTIONS = {
    "": "--debug --version",
    "check": "PROCEDURE",
    "demo": SOLVING,
    "inspect": "PROCEDURE --daemon --economy --no-lattice --spacing",
    "new": "MESH -o --output --box --spacing --sphere --thickness --units",
    "render": "CACHE -o --output --animation --color --engine --filmstrip --no-filmstrip --frames --movie-samples "
    "--movie-size --samples --size --view",
    "report economy": "-o --output --yardstick",
    "report error-time": "SCENES -o --output --quick",
    "report stability": "-o --output --fuzz --jobs --only --quick",
    "solve": f"PROCEDURE {SOLVING} --frames --report --target-error",
}


@pytest.mark.parametrize("name", OPTIONS)
def test_a_command_of_0_1_takes_what_it_took(name: str) -> None:
    command: click.Command = cli
    for part in name.split():
        assert isinstance(command, click.Group)
        command = command.commands[part]
    taken: set[str] = set()
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            taken.update(parameter.opts, parameter.secondary_opts)
        else:
            taken.add(str(parameter.name).upper())
    assert set(OPTIONS[name].split()) - taken == set()
