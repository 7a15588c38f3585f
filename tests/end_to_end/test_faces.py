"""Flaps of the library on models of the face: each is a sound procedure, and one is solved until it is closed."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from lappet.checks.validation import check
from lappet.models.body_package import is_fetched
from lappet.models.new_model import new_model
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model
from lappet.output.report import report
from lappet.output.solve_to_cache import solve_procedure
from lappet.procedure import Undermine
from lappet.program.compile import compile_program
from lappet.solve.contact_reach import contact_reach
from lappet.solve.store import FrameStore
from lappet.usd.stage import read_procedure

FACES = Path(__file__).resolve().parents[2] / "examples" / "faces"
NAMES = tuple(REGIONAL_FLAPS)
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch"),
]


@pytest.fixture(scope="module", autouse=True)
def each_model_is_made_once() -> Iterator[None]:
    """Operations on one model share it: it takes longer than what is drawn on it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("lappet.models.regional_flaps.new_model", cache(new_model))
        yield


def test_the_example_writes_each_operation_and_names_them_for_a_wrong_name(tmp_path: Path) -> None:
    file = tmp_path / "web.usda"
    command = [sys.executable, str(FACES / "build.py")]
    subprocess.run([*command, "web_z_plasty", str(file)], check=True, capture_output=True)
    assert read_procedure(file) == flap_on_model("web_z_plasty")
    wrong = subprocess.run([*command, "webb"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 1
    assert all(name in wrong.stderr for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_an_operation_on_a_face_is_sound(name: str) -> None:
    procedure = flap_on_model(name)
    assert [str(each) for each in check(procedure) if each.severity == "error"] == []
    program = compile_program(procedure)
    assert [str(note) for note in program.notes if note.severity == "error"] == []
    assert procedure.scenery  # the rest of the head


def test_limbergs_flap_closes_the_defect_of_a_cheek(tmp_path: Path) -> None:
    procedure = flap_on_model("cheek_limberg", spacing=2.0)
    assert procedure.tissue.self_contact
    result = solve_procedure(
        procedure, tmp_path / "cheek.usdc", store=FrameStore(tmp_path / "store"), error_estimate=False
    )
    assert result.complete, result.reason
    assert all(frame.solved.converged for frame in result.frames)
    assert max(frame.solved.diagnostics.self_contacts for frame in result.frames) > 0
    assert {frame.solved.diagnostics.piercings for frame in result.frames} == {0}
    last = report(result)["frames"][-1]
    marks = {name: np.array(at) for name, at in last["landmarks"].items()}
    for corner in ("donor", "shoulder", "tip"):
        apart = np.linalg.norm(marks[f"{corner} flap"] - marks[f"{corner} wound"])
        assert apart < 0.6 + contact_reach(2.0), corner
    seam = report(result)["seams"][-1]
    # Of a defect of 105 mm²; walls that touch are as far apart as the coarse lattice keeps them.
    assert seam["open_area_mm2"] < 5.0 + contact_reach(2.0) * seam["scar_length_mm"]


def test_a_keystone_flap_goes_into_its_defect_on_the_bed_that_carries_it(tmp_path: Path) -> None:
    procedure = flap_on_model("limb_keystone", spacing=3.0)
    assert not any(isinstance(event, Undermine) for event in procedure.events)
    result = solve_procedure(
        procedure, tmp_path / "limb.usdc", store=FrameStore(tmp_path / "store"), error_estimate=False
    )
    assert result.complete, result.reason
    assert all(frame.solved.converged for frame in result.frames)
    first, last = (report(result)["frames"][k]["landmarks"] for k in (0, -1))
    moved = np.subtract(last["flap middle"], first["flap middle"])
    assert 3.0 < float(np.linalg.norm(moved)) < 14.0  # towards a defect of 14 mm
    seam = report(result)["seams"][-1]
    assert seam["open_area_mm2"] < 20.0 + contact_reach(3.0) * seam["scar_length_mm"]  # of 400 mm²


def test_a_contracted_scar_pulls_across_the_lines_of_the_skin() -> None:
    procedure = flap_on_model("neck_z_plasty", spacing=2.5)
    regions = {region.material: region for region in procedure.tissue.regions}
    assert len(procedure.tissue.subsets[regions["scar"].faces]) > 20
    along, across = procedure.material("scar").prestretch
    assert across > max(along, 1.02)  # the band crosses the lines of the skin
