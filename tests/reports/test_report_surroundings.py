"""`lappet report surroundings`: a free rim and a held one are two bounds, and wider tissue lies between."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from fusiform_scene import TOP, closed_fusiform
from lappet import Incision, Procedure, check
from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.output.solve_to_cache import solve_procedure
from lappet.procedure import Region, SkinLine
from lappet.reports.surroundings.free_rim import with_free_rim
from lappet.reports.surroundings.measurement import SurroundingsRow, measure_surroundings
from lappet.reports.surroundings.table import surroundings_table
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import SKIN
from lappet.tissue.surface import skin_faces
from lappet.usd.cache_end import read_cache_end
from lappet.usd.stage import write_procedure
from refusals import refuses
from small_procedure import small_procedure

pytestmark = pytest.mark.slow


def fusiform(length: float, width: float) -> Procedure:
    """A fusiform excision, closed, on a patch that reaches so far."""
    procedure = closed_fusiform(2.0, skin=SKIN.unstretched)
    return replace(procedure, tissue=flat_patch((length, width, TOP), resolution=2.0, spacing=2.0))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[SurroundingsRow, float, float]:
    """The narrow patch's row; the scar's greatest way to that on a wide patch, and the force there."""
    folder = tmp_path_factory.mktemp("surroundings")
    for name, size in (("narrow", (64.0, 52.0)), ("wide", (104.0, 84.0))):
        write_procedure(fusiform(*size), folder / f"{name}.usda")
    row = measure_surroundings(str(folder / "narrow.usda"), folder)
    solve_procedure(folder / "wide.usda", folder / "wide_held.usdc", error_estimate=False)
    narrow, wide = (read_cache_end(folder / f"{name}_held.usdc") for name in ("narrow", "wide"))
    ways = [np.linalg.norm(wide.seams[name] - line, axis=1).max() for name, line in narrow.seams.items()]
    return row, float(max(ways)), sum(wide.forces.values())


def test_the_force_of_wider_tissue_lies_between_those_of_a_held_and_a_free_rim(
    measured: tuple[SurroundingsRow, float, float],
) -> None:
    row, _, force = measured
    assert row.held_mn is not None
    assert row.free_mn is not None
    assert row.free_mn < force < row.held_mn
    assert row.free_mn < 0.98 * row.held_mn  # the bound has room


def test_the_scar_of_wider_tissue_lies_within_the_bound(measured: tuple[SurroundingsRow, float, float]) -> None:
    row, way, _ = measured
    assert row.free_mm is not None
    assert row.free_rms_mm is not None
    assert 0.0 < way < row.free_mm
    assert row.free_rms_mm <= row.free_mm


def test_a_free_rim_stays_rim_and_everything_else_is_as_it_was() -> None:
    procedure = fusiform(64.0, 52.0)
    freed = with_free_rim(procedure)
    assert "fixed" not in freed.tissue.subsets
    np.testing.assert_array_equal(skin_faces(freed.tissue), skin_faces(procedure.tissue))
    np.testing.assert_array_equal(freed.tissue.subsets["rim"], procedure.tissue.subsets["fixed"])
    np.testing.assert_array_equal(freed.tissue.points, procedure.tissue.points)
    assert check(freed) == []


def test_what_no_free_rim_would_bound_is_refused() -> None:
    procedure = fusiform(64.0, 52.0)
    tissue = procedure.tissue
    bare = {name: faces for name, faces in tissue.subsets.items() if name != "fixed"}
    with refuses(ProblemCode.SURROUNDINGS_NO_RIM):
        with_free_rim(replace(procedure, tissue=replace(tissue, subsets=bare)))
    unsupported = {name: faces for name, faces in tissue.subsets.items() if name != "bed"}
    with refuses(ProblemCode.SURROUNDINGS_NOT_HELD):
        with_free_rim(replace(procedure, tissue=replace(tissue, subsets=unsupported)))
    taut = replace(SKIN.unstretched, prestretch=(1.1, 1.0))
    with refuses(ProblemCode.SURROUNDINGS_STRETCHED):
        with_free_rim(replace(procedure, materials=(taut,)))
    line = SkinLine("line", ((-20.0, 0.0, TOP), (20.0, 0.0, TOP)), (4.0, 2.0))
    with refuses(ProblemCode.SURROUNDINGS_STRETCHED):
        with_free_rim(replace(procedure, skin_lines=(line,)))


def test_a_stretched_scar_away_from_the_rim_is_no_obstacle() -> None:
    procedure = fusiform(64.0, 52.0)
    tissue = procedure.tissue
    taut = replace(SKIN.unstretched, name="scar", prestretch=(1.1, 1.0))
    skin = np.flatnonzero(skin_faces(tissue))
    for faces, is_refused in ((skin[len(skin) // 2 :][:1], False), (tissue.subsets["fixed"][:1], True)):
        with_scar = replace(
            procedure,
            materials=(*procedure.materials, taut),
            tissue=replace(tissue, subsets={**tissue.subsets, "scar": faces}, regions=(Region("scar", "scar", 2.0),)),
        )
        if is_refused:
            with refuses(ProblemCode.SURROUNDINGS_STRETCHED):
                with_free_rim(with_scar)
        else:
            assert "fixed" not in with_free_rim(with_scar).tissue.subsets


def test_the_command_refuses_what_closes_nothing_and_writes_what_it_measured(tmp_path: Path) -> None:
    source = tmp_path / "open.usda"
    cut = Incision("slit", 1.0, ((-6.0, 0.0, 2.0), (6.0, 0.0, 2.0)), kerf=0.1)
    write_procedure(small_procedure(materials=(SKIN.unstretched,), events=(cut,), end_time=1.0), source)
    said = CliRunner().invoke(cli, ["report", "surroundings", str(source), "-o", str(tmp_path / "report")])
    assert said.exit_code == 1, said.output
    assert not list((tmp_path / "report").glob("*.usdc"))  # before anything was solved
    assert not (tmp_path / "report" / "surroundings.json").exists()


def test_the_table_says_what_was_not_solved_and_what_is_not_within_the_bound() -> None:
    rows = [
        SurroundingsRow("a_flap", "cheek", 0.5, 0.4, 100.0, 90.0, 1.3, 0.2, 0.1, 97.0),
        SurroundingsRow("b_flap", "nose", 0.5, 0.4, 100.0, 90.0, 1.3, 0.6, 0.1, 97.0),
        SurroundingsRow("c_flap", "lips", 0.5, 0.4, 100.0, 90.0, 1.3, problem="It did not converge."),
        SurroundingsRow("own", "", 0.5, 0.4, 100.0, 90.0),
    ]
    assert [row.bounded for row in rows] == [True, False, None, None]
    lines = surroundings_table(rows).splitlines()[2:]
    assert [line.rstrip("| ").endswith(end) for line, end in zip(lines[:2], ("yes", "no"), strict=True)] == [True, True]
    assert "not solved" in lines[2]
    assert "not solved" not in lines[3]
