"""Cut surfaces do not pass through themselves at rest, where self-contact could keep nothing apart."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.cutting.epochs import build_epochs
from lappet.models.body_package import is_fetched
from lappet.models.regional_flaps import flap_on_model
from lappet.procedure import Procedure
from lappet.usd.stage import read_procedure
from self_intersection import passes_through_itself

EXAMPLES = sorted(Path(__file__).resolve().parents[2].glob("examples/*/*.usda"))
# Of all designs and operations those in which some steps of tidying lead walls or skin through each other.
ON_BODY = ("upper_eyelid", "lip_a_t", "cheek_island", pytest.param("nose_forehead", marks=pytest.mark.slow))


def epochs_that_pass_through_themselves(procedure: Procedure) -> list[int]:
    epochs = build_epochs(procedure)
    return [each.index for each in epochs if passes_through_itself(each.surface.points, each.surface.triangles)]


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_no_epoch_of_an_example_passes_through_itself(file: Path) -> None:
    assert epochs_that_pass_through_themselves(read_procedure(file)) == []


@pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")
@pytest.mark.parametrize("name", ON_BODY)
def test_no_epoch_of_an_operation_on_a_body_passes_through_itself(name: str) -> None:
    assert epochs_that_pass_through_themselves(flap_on_model(name, scenery=False)) == []
