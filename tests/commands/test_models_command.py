"""`lappet models`: list, show, new, targets."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from lappet.commands.cli import cli
from lappet.models.new_model import MODELS
from lappet.usd.stage import read_procedure


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["models", *(str(each) for each in arguments)])


def test_every_model_is_listed_with_what_it_shows() -> None:
    lines = run("list").output.splitlines()
    assert [line.split()[0] for line in lines] == [*MODELS, "body"]
    assert all(len(line.split()) > 3 for line in lines)


@pytest.mark.parametrize("name", list(MODELS))
def test_a_model_is_shown_with_its_license(name: str) -> None:
    shown = run("show", name)
    assert shown.exit_code == 0
    assert "license: " in shown.output
    assert f"lattice spacing: {MODELS[name].spacing:g} mm" in shown.output


def test_an_aged_nose_with_a_hump_is_made_without_its_surroundings(tmp_path: Path) -> None:
    arguments = ("--age", "70", "--sex", "male", "--target", "nose/nose-hump-incr=1", "--skin", "1", "--no-scenery")
    made = run("new", "nose", "-o", tmp_path / "nose.usdc", *arguments, "--spacing", "1", "--position", "supine")
    assert made.exit_code == 0, made.output
    procedure = read_procedure(tmp_path / "nose.usdc")
    assert procedure.tissue.spacing == 1.0
    assert procedure.tissue.gravity_direction == (0.0, -1.0, 0.0)
    assert procedure.tissue.regions[0].depth_from == 1.0
    assert procedure.scenery == ()
    assert not [event for event in procedure.events if event.kind != "Landmark"]


def test_a_patch_comes_with_an_excision_where_it_is_asked_for(tmp_path: Path) -> None:
    assert run("new", "patch", "-o", tmp_path / "patch.usdc", "--excision").exit_code == 0
    kinds = {event.kind for event in read_procedure(tmp_path / "patch.usdc").events}
    assert kinds == {"Incision", "Excision", "Undermine", "Suture"}


def test_targets_are_found_by_a_word() -> None:
    found = run("targets", "nose-hump").output.split()
    assert found == ["nose/nose-hump-decr", "nose/nose-hump-incr"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("new", "knee"), "There is no model knee."),
        (("new", "nose", "--age", "600"), "age is 600."),
        (("new", "nose", "--target", "hump"), "hump is no shape target with an amount."),
        (("new", "patch", "--sex", "male"), "no part of a body"),
    ],
)
def test_what_cannot_be_made_is_refused_in_a_sentence(tmp_path: Path, arguments: tuple[str, ...], said: str) -> None:
    refused = run(*arguments, "-o", tmp_path / "p.usda")
    assert refused.exit_code == 1
    assert said in refused.output
    assert not (tmp_path / "p.usda").exists()
