"""`lappet flap`: the library on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from lappet.commands.cli import cli
from lappet.designs.library import DESIGNS
from lappet.procedure import Excision, Hook, Incision, Landmark, Material, Procedure, SutureRun
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.usd.stage import read_procedure, write_procedure


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["flap", *(str(each) for each in arguments)])


@pytest.fixture
def dome(tmp_path: Path) -> Path:
    """A dome with a landmark on it."""
    mark = Landmark("lesion", ((0.0, 10.0, 89.4),), "lesion")
    path = tmp_path / "dome.usda"
    write_procedure(Procedure(dome_scalp(90.0, 70.0, 6.0), events=(mark,), start_time=1, end_time=1), path)
    return path


def test_the_list_names_every_design_and_what_it_is_for() -> None:
    result = run("list")
    assert result.exit_code == 0
    for design in DESIGNS.values():
        assert any(line.startswith(design.name) and design.indication in line for line in result.stdout.splitlines())


@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_is_shown_with_its_measures_and_their_ranges(name: str) -> None:
    result = run("show", name)
    assert result.exit_code == 0, result.output
    for parameter in DESIGNS[name].parameters:
        assert parameter.name in result.stdout
        assert f"{parameter.default:g}" in result.stdout


def test_a_design_without_a_procedure_comes_on_a_patch_of_its_own(tmp_path: Path) -> None:
    result = run("add", "limberg", "-o", tmp_path / "p.usda", "--set", "side=12", "--spacing", 2, "--mirrored")
    assert result.exit_code == 0, result.output
    procedure = read_procedure(tmp_path / "p.usda")
    assert procedure.tissue.spacing == 2.0
    assert {Incision, Hook, SutureRun, Landmark} <= {type(event) for event in procedure.events}


def test_a_flap_on_a_narrow_base_is_written_with_a_warning(tmp_path: Path) -> None:
    result = run("add", "u-plasty", "-o", tmp_path / "p.usda", "--set", "length=4", "--spacing", 2)
    assert result.exit_code == 0
    assert (tmp_path / "p.usda").exists()
    assert "more than 3:1" in result.stderr
    assert "warning" in result.stderr
    assert run("add", "u-plasty", "-o", tmp_path / "p.usda", "--spacing", 2).stderr == ""


def test_a_design_is_laid_at_a_landmark_across_the_lines_of_the_skin(dome: Path, tmp_path: Path) -> None:
    result = run("add", "z-plasty", dome, "-o", tmp_path / "p.usda", "--landmark", "lesion", "--lines", "across")
    assert result.exit_code == 0, result.output
    procedure = read_procedure(tmp_path / "p.usda")
    (cut,) = [event for event in procedure.events if isinstance(event, Incision)]
    assert procedure.event("lesion") is not None
    middle = [sum(values) / len(values) for values in zip(*cut.points, strict=True)]
    assert middle[0] == pytest.approx(0.0, abs=0.5)
    assert middle[1] == pytest.approx(10.0, abs=0.7)


@pytest.mark.parametrize(
    ("options", "status", "said"),
    [
        (("limberg", "--at", 0, 0, 90), 2, "--direction"),
        (("limberg", "--at", 0, 0, 90, "--landmark", "lesion"), 2, "Give one of"),
        (("limberg", "--at", 0, 0, 90, "--direction", 1, 0, 0, "--lines", "along"), 2, "not both"),
        (("limberg", "--at", 0, 0, 90, "--direction", 1, 0, 0, "--set", "side"), 2, "NAME=VALUE"),
        (("limberg", "--at", 0, 0, 90, "--direction", 1, 0, 0, "--set", "side=1000"), 1, "side"),
        (("limberg", "--at", 0, 60, 60, "--direction", 0, 1, 0, "--set", "side=40"), 1, "limberg"),
        (("limberg", "--landmark", "ala", "--direction", 1, 0, 0), 1, "ala"),
        (("limburg", "--at", 0, 0, 90, "--direction", 1, 0, 0), 1, "limburg"),
    ],
)
def test_what_cannot_be_added_is_refused_and_nothing_is_written(
    dome: Path, tmp_path: Path, options: tuple, status: int, said: str
) -> None:
    name, *rest = options
    result = run("add", name, dome, "-o", tmp_path / "p.usda", *rest)
    assert result.exit_code == status, result.output
    assert said in result.output
    assert not (tmp_path / "p.usda").exists()


def test_a_place_needs_a_procedure(tmp_path: Path) -> None:
    result = run("add", "limberg", "-o", tmp_path / "p.usda", "--at", 0, 0, 4)
    assert result.exit_code == 2
    assert "PROCEDURE" in result.output


def test_the_plan_of_a_design_is_drawn_with_the_corners_that_meet(tmp_path: Path) -> None:
    result = run("show", "limberg", "--picture", tmp_path / "plan.svg", "--set", "side=20")
    assert result.exit_code == 0, result.output
    assert "In the end meet: " in result.stdout
    assert (tmp_path / "plan.svg").read_text(encoding="utf-8").startswith("<?xml")
    assert "plan.txt is no .svg, .pdf or .png file; choose" in run("show", "limberg", "--picture", "plan.txt").output


def test_a_flap_is_as_large_as_a_drawn_defect_and_takes_its_place(tmp_path: Path) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False)
    ring = np.column_stack([3.0 + 6.0 * np.cos(angle), -2.0 + 6.0 * np.sin(angle), np.full(32, 4.0)])
    lesion = Incision("lesion", 2.0, tuple(map(tuple, ring.tolist())), closed=True)
    tissue = flat_patch((90.0, 90.0, 4.0))
    write_procedure(Procedure(tissue, (Material("skin"),), events=(lesion,), end_time=2), tmp_path / "drawn.usda")
    result = run(
        "add",
        "limberg",
        tmp_path / "drawn.usda",
        "-o",
        tmp_path / "p.usda",
        "--defect",
        "lesion",
        "--direction",
        1,
        0,
        0,
    )
    assert result.exit_code == 0, result.output
    assert "Lengths: side 13.8" in result.stdout
    procedure = read_procedure(tmp_path / "p.usda")
    (excision,) = [event for event in procedure.events if isinstance(event, Excision)]
    assert excision.seeds[0] == pytest.approx((3.0, -2.0, 4.0), abs=0.1)
    assert "lesion" not in [event.name for event in procedure.events]
    twice = run("add", "limberg", tmp_path / "drawn.usda", "-o", "x.usda", "--defect", "lesion", "--at", 0, 0, 4)
    assert twice.exit_code == 2


@pytest.mark.parametrize(
    ("design", "options", "said"),
    [
        ("limberg", ("--at", 0, 0, 60), "lies 56 mm off the skin"),
        ("limberg", ("--at", 25, 0, 4), "leaves the skin at"),
        ("limberg", ("--at", 0, 0, 4, "--set", "side=90"), "Give 4 to 60 mm"),
        ("s-excision", ("--at", 0, 0, 4, "--set", "length=15.4", "--set", "width=10", "--set", "swing=22.5"), "cross"),
        ("u-plasty", ("--defect", "lesion"), "needs a width of"),
    ],
)
def test_bad_input_is_refused_in_one_sentence_and_nothing_is_written(
    tmp_path: Path, design: str, options: tuple[object, ...], said: str
) -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = tuple((26.0 * np.cos(a), 26.0 * np.sin(a), 4.0) for a in turn)
    patch = Procedure(flat_patch((70.0, 70.0, 4.0), resolution=5.0, spacing=5.0), (SKIN.material,))
    write_procedure(patch.with_events(Incision("lesion", 1, ring, closed=True)), tmp_path / "patch.usda")
    done = run("add", design, tmp_path / "patch.usda", *options, "-o", tmp_path / "flap.usda", "--direction", 1, 0, 0)
    assert done.exit_code == 1
    assert said in done.output
    assert not (tmp_path / "flap.usda").exists()


def test_a_flap_is_edited_by_its_name(tmp_path: Path) -> None:
    assert run("add", "limberg", "-o", tmp_path / "a.usda", "--spacing", 4).exit_code == 0
    done = run("edit", "limberg", tmp_path / "a.usda", "-o", tmp_path / "b.usda", "--set", "side=14", "--mirrored")
    assert done.exit_code == 0
    (laid,) = read_procedure(tmp_path / "b.usda").flaps
    assert (dict(laid.measures), laid.mirrored) == ({"side": 14.0}, True)
    assert "limberg: limberg at (0, 0, 4) mm, side 14, mirrored" in repr(read_procedure(tmp_path / "b.usda"))
    wrong = run("edit", "bilobed", tmp_path / "a.usda", "-o", tmp_path / "c.usda")
    assert (wrong.exit_code, "Those laid are: limberg" in wrong.output) == (1, True)
