"""A quantity has one default: what the schema says of an attribute is what the procedure's values say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import lappet
from lappet.procedure import Hook, Incision, Material, Suture, Tissue
from lappet.program.materials import parameters
from lappet.program.settings import SolverSettings

SCHEMA = Path(lappet.__file__).parent / "usd" / "schema" / "schema.usda"


@pytest.mark.parametrize(
    ("schema", "attribute", "default"),
    [
        ("LappetHookAPI", "stiffness", Hook.stiffness),
        ("LappetSutureAPI", "stiffness", Suture.stiffness),
        ("LappetSutureAPI", "duration", Suture.duration),
        ("LappetSutureAPI", "length", Suture.length),
        ("LappetSutureAPI", "tension", Suture.tension),
        ("LappetSutureAPI", "pullThrough", Suture.pull_through),
        ("LappetIncisionAPI", "kerf", Incision.kerf),
        ("LappetTissueAPI", "spacing", Tissue.spacing),
        ("LappetTissueAPI", "bedStiffness", Tissue.bed_stiffness),
        ("LappetTissueAPI", "bedShear", Tissue.bed_shear),
        ("LappetTissueAPI", "gravity", Tissue.gravity),
        ("LappetMaterialAPI", "youngsModulus", Material.youngs_modulus),
        ("LappetMaterialAPI", "poissonsRatio", Material.poissons_ratio),
        ("LappetMaterialAPI", "density", Material.density),
    ],
)
def test_the_schema_has_the_defaults_of_the_values(schema: str, attribute: str, default: float) -> None:
    found = re.search(rf'class "{schema}" \(.*? lappet:{attribute} = (\S+)', SCHEMA.read_text("utf-8"), re.DOTALL)
    assert found is not None
    assert float(found[1]) == default


def test_what_the_daemon_is_told_by_default_is_a_procedures_default() -> None:
    assert SolverSettings.materials == (parameters(Material("skin")),)
    assert (SolverSettings.bed_stiffness, SolverSettings.bed_shear) == (Tissue.bed_stiffness, Tissue.bed_shear)
