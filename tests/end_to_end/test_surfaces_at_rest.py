"""Cut surfaces do not pass through themselves at rest, where self-contact could keep nothing apart."""

from __future__ import annotations

from pathlib import Path

import pytest

from lappet.cutting.epochs import build_epochs
from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import flap_on_patch
from lappet.models.body_package import is_fetched
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model
from lappet.procedure import Procedure
from lappet.usd.stage import read_procedure
from self_intersection import passes_through_itself

EXAMPLES = sorted(Path(__file__).resolve().parents[2].glob("examples/*/*.usda"))
ON_BODY = [pytest.param(name, marks=[] if name == "upper_eyelid" else [pytest.mark.slow]) for name in REGIONAL_FLAPS]


def epochs_that_pass_through_themselves(procedure: Procedure) -> list[int]:
    epochs = build_epochs(procedure)
    return [each.index for each in epochs if passes_through_itself(each.surface.points, each.surface.triangles)]


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_no_epoch_of_an_example_passes_through_itself(file: Path) -> None:
    assert epochs_that_pass_through_themselves(read_procedure(file)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", DESIGNS)
def test_no_epoch_of_a_design_on_the_patch_passes_through_itself(name: str) -> None:
    assert epochs_that_pass_through_themselves(flap_on_patch(name)) == []


@pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")
@pytest.mark.parametrize("name", ON_BODY)
def test_no_epoch_of_an_operation_on_a_body_passes_through_itself(name: str) -> None:
    assert epochs_that_pass_through_themselves(flap_on_model(name, scenery=False)) == []
