"""Where designs belong on a body: the table fits the library and the models, and the pages' commands make the same."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.designs.library import DESIGNS, library_design
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.models.body_package import FOLDER_VARIABLE, is_fetched
from lappet.models.catalogue import BODY_MODELS
from lappet.models.cleft import BORDER
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model, regional_flaps
from lappet.procedure import LaidFlap, Landmark, SutureRun
from lappet.reports.atlas.model_section import model_sections
from lappet.usd.stage import read_procedure
from refusals import refuses


def test_every_operation_is_of_a_design_and_a_model_with_measures_in_their_ranges() -> None:
    for flap in REGIONAL_FLAPS.values():
        assert flap.model in BODY_MODELS
        library_design(flap.design).values(flap.measures)
        assert flap in regional_flaps(flap.design)
    assert sum(len(regional_flaps(name)) for name in DESIGNS) == len(REGIONAL_FLAPS)


def test_operations_that_would_share_a_heading_on_a_page_do_not_occur() -> None:
    for name in DESIGNS:
        places = [flap.place for flap in regional_flaps(name)]
        assert len(set(places)) == len(places)


def test_an_operation_that_is_not_there_is_refused_with_those_that_are() -> None:
    with refuses(ProblemCode.DESIGN_UNKNOWN) as problems:
        flap_on_model("cheek_limburg")
    assert all(name in problems[0].remedy for name in REGIONAL_FLAPS)


def test_without_the_package_an_operation_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path))
    with refuses(ProblemCode.MODELS_NOT_FETCHED):
        flap_on_model("cheek_limberg")


@pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")
@pytest.mark.parametrize("name", ["cheek_limberg", "upper_eyelid", "nose_bilobed", "cleft_lip_millard"])
def test_the_commands_on_a_designs_page_make_its_operation(name: str, tmp_path: Path) -> None:
    """By the lines of the skin, with targets of the body's shape, mirrored, and without weight."""
    text = "\n".join(model_sections(REGIONAL_FLAPS[name].design, {}, {}))
    section = text.partition(f"## On {REGIONAL_FLAPS[name].place}\n")[2].partition("\n## ")[0]
    commands = section.split("```")[1].strip().splitlines()
    runner = CliRunner()
    with runner.isolated_filesystem(tmp_path):
        for command in commands:
            program, *arguments = shlex.split(command)
            result = runner.invoke(cli, arguments)
            assert (program, result.exit_code) == ("lappet", 0), result.output
        made = read_procedure(Path(f"{name}.usda"))
    wanted = flap_on_model(name)
    (laid,), (own,) = made.flaps, wanted.flaps
    assert isinstance(laid, LaidFlap)
    assert (laid.design, laid.measures, laid.mirrored, laid.lines) == (
        own.design,
        own.measures,
        own.mirrored,
        own.lines,
    )
    assert laid.at == pytest.approx(own.at)
    assert laid.direction == pytest.approx(own.direction, abs=1e-4)
    assert [event.name for event in made.events] == [event.name for event in wanted.events]
    assert made.tissue.points == pytest.approx(wanted.tissue.points, abs=1e-3)
    for value in ("spacing", "gravity", "self_contact"):
        assert getattr(made.tissue, value) == getattr(wanted.tissue, value)


@pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")
def test_the_repair_of_a_cleft_pares_both_margins_in_one_piece_and_spares_the_lower_lip() -> None:
    procedure = flap_on_model("cleft_lip_millard", scenery=False)
    epochs = build_epochs(procedure)
    assert [epoch.fragments for epoch in epochs] == [1, 2, 1]
    surface = epochs[-1].surface
    walls = surface.points[surface.triangles[surface.origin == FaceOrigin.WOUND_WALL]].mean(axis=1)
    assert walls[:, 2].min() > BORDER
    (run,) = (event for event in procedure.events if isinstance(event, SutureRun))
    ends = np.array([edge[-1] for edge in run.edges])  # of the red, beside the free border on both margins
    marks = {event.name: np.array(event.points) for event in procedure.events if isinstance(event, Landmark)}
    for end, name in zip(ends, ("cleft_red_lateral", "cleft_red_medial"), strict=True):
        assert np.linalg.norm(marks[name] - end, axis=1).min() < 2.5, name
