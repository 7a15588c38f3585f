"""How the patient lies, said on the command line: `lappet new` writes it, `lappet solve` overrides it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from lappet.commands.cli import cli
from lappet.usd.stage import read_procedure, write_procedure
from small_procedure import small_procedure


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(each) for each in arguments])


@pytest.mark.parametrize(
    ("given", "direction", "gravity"),
    [
        ((), (0.0, 0.0, -1.0), 9.81),
        (("--position", "supine"), (0.0, -1.0, 0.0), 9.81),
        (("--position", "0.5,0,-1", "--gravity", "1.62"), (0.5, 0.0, -1.0), 1.62),
        (("--gravity", "0"), (0.0, 0.0, -1.0), 0.0),
    ],
)
def test_new_lays_the_patient_down(
    tmp_path: Path, given: tuple[str, ...], direction: tuple[float, float, float], gravity: float
) -> None:
    import trimesh

    trimesh.creation.box((40.0, 30.0, 4.0)).export(tmp_path / "box.stl")
    done = run("new", tmp_path / "box.stl", "-o", tmp_path / "p.usda", "--units", "mm", *given)
    assert done.exit_code == 0, done.output
    tissue = read_procedure(tmp_path / "p.usda").tissue
    assert (tissue.gravity_direction, tissue.gravity) == (direction, gravity)
    assert np.linalg.norm(tissue.gravity_vector) == pytest.approx(gravity)
    assert np.cross(tissue.gravity_vector, direction) == pytest.approx(0.0)


def marked(path: Path, folder: Path, name: str, *given: str) -> list[float]:
    """Where the landmark of the first frame lies, in which nothing is done but to weigh."""
    report = folder / f"{name}.json"
    done = run(
        "solve", path, "-o", folder / f"{name}.usdc", "--report", report, "--store", folder / "store",
        "--no-error-estimate", "--frames", ":1", *given,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    return [float(each) for each in json.loads(report.read_text())["frames"][0]["landmarks"]["corner"]]


def test_solve_lays_the_patient_otherwise_than_the_procedure_and_leaves_its_file_alone(tmp_path: Path) -> None:
    path = tmp_path / "p.usda"
    write_procedure(small_procedure(), path)
    before = path.read_bytes()
    at_rest = np.array(marked(path, tmp_path, "weightless", "--gravity", "0"))
    for name, down in (("supine", (0.0, -1.0, 0.0)), ("right_lateral", (1.0, 0.0, 0.0))):
        sagged = marked(path, tmp_path, name, "--position", name, "--gravity", "9.81")
        assert np.dot(np.array(sagged) - at_rest, down) > 1e-4, name
        lying = tmp_path / f"{name}_lying.usda"
        procedure = small_procedure()
        tissue = replace(procedure.tissue, gravity_direction=down, gravity=9.81)
        write_procedure(replace(procedure, tissue=tissue), lying)
        assert marked(lying, tmp_path, f"{name}_lying") == sagged
        assert read_procedure(tmp_path / f"{name}.procedure.usda").tissue.gravity_direction == down
    assert path.read_bytes() == before


@pytest.mark.parametrize("given", [("--position", "sideways"), ("--position", "0,0,0"), ("--gravity", "-1")])
def test_a_position_that_is_none_is_refused_before_anything_is_read(tmp_path: Path, given: tuple[str, ...]) -> None:
    done = run("solve", tmp_path / "absent.usda", *given)
    assert done.exit_code == 2
    assert given[0] in done.stderr
