"""A setting is defined once: the command line, the wire, the protocol and the daemon follow from its field."""

from __future__ import annotations

import re
from dataclasses import fields, replace
from pathlib import Path

import pytest

from lappet.commands.cli import cli
from lappet.core.value_codec import pack, unpack
from lappet.procedure import Procedure
from lappet.program.compile import compile_program
from lappet.program.payloads import open_payload
from lappet.program.settings import SolverSettings, for_tissue, options
from lappet.tissue import flat_patch

ROOT = Path(__file__).parents[2]
NAMES = [item.name for item in fields(SolverSettings)]


def test_every_setting_is_told_to_the_daemon_under_its_own_name() -> None:
    told = open_payload(SolverSettings(spacing=1.0))
    assert [*told.fields["settings"], "materials"] == NAMES
    assert len(told.fields["materials"]) == 1


def test_the_daemon_reads_these_settings_and_no_others() -> None:
    text = (ROOT / "solverd" / "src" / "session" / "program.h").read_text(encoding="utf-8")
    assert set(re.findall(r'visit(?:\.optional)?\("(\w+)"', text)) == set(NAMES) - {"materials"}


def test_the_protocol_describes_every_setting() -> None:
    text = (ROOT / "PROTOCOL.md").read_text(encoding="utf-8")
    assert [name for name in NAMES if f"`{name}`" not in text] == []


@pytest.mark.parametrize("command", ["solve", "demo"])
def test_every_option_of_a_setting_is_on_the_command_line(command: str) -> None:
    known = {parameter.name: parameter for parameter in cli.get_command(None, command).params}  # type: ignore[arg-type]
    for item, option in options():
        assert known[item.name].help == option.help  # type: ignore[attr-defined]
        if option.shown and option.value is None and item.default is not None:
            assert type(item.default)(known[item.name].default) == item.default


def test_settings_go_to_the_worker_and_back() -> None:
    changed = replace(SolverSettings(), spacing=0.1, region="whole", strain=False)
    assert unpack(pack(changed), SolverSettings) == changed


@pytest.mark.parametrize("tissue", [False, True])
@pytest.mark.parametrize("asked", [None, False, True])
def test_the_tissue_says_whether_it_passes_through_itself_unless_the_settings_do(
    tissue: bool, asked: bool | None
) -> None:
    patch = replace(flat_patch(spacing=2.0), self_contact=tissue)
    settings = for_tissue(SolverSettings(self_contact=asked), patch)
    assert settings.self_contact is (tissue if asked is None else asked)
    assert settings.spacing == 2.0
    program = compile_program(Procedure(patch, end_time=1.0), settings=SolverSettings(self_contact=asked))
    assert program.settings.self_contact is settings.self_contact
    assert open_payload(program.settings).fields["settings"]["self_contact"] == settings.self_contact
