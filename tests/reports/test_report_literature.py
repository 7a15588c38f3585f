"""`lappet report literature`: what it measures is what was solved, and its verdicts follow from the numbers."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.core.problem_code import ProblemCode
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.reports.literature import measured
from lappet.reports.literature.measured import (
    Measure,
    Measured,
    closing_force,
    designed_arc,
    limb_turn,
    scar_gain,
    scar_length,
)
from lappet.reports.literature.operations import OPERATIONS
from lappet.reports.literature.page import literature_page
from lappet.reports.literature.published import Published, Verdict
from lappet.reports.literature.rows import ROWS
from lappet.reports.literature.run import compare, run_literature
from lappet.reports.report_progress import ReportProgress
from lappet.solve.measure_errors import FORCE_ORDER
from refusals import refuses

COARSE = 4.0  # mm
NOTHING = Measure((), lambda: Measured(0.0))


def row(least: float, most: float) -> Published:
    return Published("row", "something", "mm", least, most, "a paper", "there", "here", NOTHING)


@pytest.fixture(scope="module")
def fusiform(tmp_path_factory: pytest.TempPathFactory) -> SolveResult:
    """An excision of 2 : 1 on a coarse lattice."""
    return solve_procedure(OPERATIONS["fusiform-2"](COARSE), tmp_path_factory.mktemp("literature") / "fusiform.usdc")


@pytest.mark.slow
def test_the_front_of_an_advancement_flap_is_the_middle_of_its_run(tmp_path: Path) -> None:
    """Its sutures were looked for by a name that runs do not have, and the rows said that nothing was solved."""
    result = solve_procedure(OPERATIONS["u-plasty-2"](COARSE), tmp_path / "flap.usdc", error_estimate=False)
    front, whole = measured.greatest_in_middle(result, "flap", 14.0), measured.greatest_of(result, "flap")
    assert 0.0 < front.value <= whole.value
    sides = [row for row in result.measures[-1].sutures if "flap" in row.closure and row.along_mm < 20.0]
    assert sides
    assert measured.greatest_in_middle(result, "flap", 200.0).value == pytest.approx(whole.value)
    assert math.isnan(measured.greatest_in_middle(result, "nothing", 14.0).value)


def test_every_row_whose_operations_are_solved_measures_something() -> None:
    found = json.loads((Path(__file__).resolve().parents[2] / "docs" / "literature.json").read_text(encoding="utf-8"))
    assert {each["name"] for each in found["rows"]} == {each.name for each in ROWS}
    assert all(each["value"] is not None for each in found["rows"])


@pytest.mark.parametrize(
    ("value", "error", "verdict"),
    [
        (1.5, None, Verdict.AGREES),
        (1.0, 0.1, Verdict.AGREES),
        (0.9, 0.2, Verdict.WITHIN_ERROR),
        (2.3, 0.2, Verdict.DISAGREES),
        (0.9, None, Verdict.DISAGREES),
        (1.5, 1.6, Verdict.UNCERTAIN),
        (0.9, 1.0, Verdict.UNCERTAIN),
        (-1.0, 1.5, Verdict.DISAGREES),
        (None, None, Verdict.NOT_SOLVED),
        (math.nan, 0.1, Verdict.NOT_SOLVED),
    ],
)
def test_a_number_agrees_where_it_or_its_error_reaches_the_published_range(value, error, verdict) -> None:
    assert row(1.0, 2.0).verdict(value, error) is verdict


def test_a_bound_on_one_side_holds_on_that_side_only() -> None:
    assert row(-math.inf, 1.0).verdict(-50.0, None) is Verdict.AGREES
    assert row(1.0, math.inf).verdict(0.5, 0.1) is Verdict.DISAGREES
    assert row(-math.inf, 1.0).range_text == "at most 1 mm"
    assert row(1.0, 2.0).range_text == "1 to 2 mm"


def test_errors_add_in_differences_and_as_shares_in_quotients() -> None:
    one, two = Measured(6.0, 0.6), Measured(3.0, 0.15)
    assert one.minus(two) == Measured(3.0, 0.75)
    quotient = one.per(two)
    assert quotient.value == 2.0
    assert quotient.error == pytest.approx(2.0 * (0.1 + 0.05))
    assert one.per(Measured(3.0)).error is None
    assert math.isnan(one.per(Measured(0.0, 0.1)).value)
    assert one.times(-2.0) == Measured(-12.0, 1.2)


def test_there_are_25_rows_each_with_its_source_and_every_operation_is_of_use() -> None:
    assert len(ROWS) >= 25
    assert len({each.name for each in ROWS}) == len(ROWS)
    assert all(each.source and each.there and each.here and each.least <= each.most for each in ROWS)
    assert {name for each in ROWS for name in each.measure.operations} == set(OPERATIONS)


def test_a_scar_is_compared_with_the_arc_of_its_design(fusiform: SolveResult) -> None:
    # Arcs of a circle over an axis twice as long as they are wide apart are 1.159 times as long as the axis; the lip
    # that is measured is a polygon through points of the cut.
    assert designed_arc(fusiform).value == pytest.approx(1.159 * 24.0, rel=0.02)
    measured = fusiform.measures[-1].seams[0].measure
    assert scar_length(fusiform).value == measured.scar_length_mm
    (row,) = (each for each in ROWS if each.name == "fusiform-scar-2")
    compared = compare(row, {"fusiform-2": fusiform})
    assert compared.value == pytest.approx(measured.scar_length_mm / designed_arc(fusiform).value)
    assert compared.error is not None
    assert compared.verdict == row.verdict(compared.value, compared.error).value
    assert compare(row, {}).verdict == Verdict.NOT_SOLVED.value


def test_a_closing_force_is_the_sum_over_the_sutures_that_the_lattice_resolves(fusiform: SolveResult) -> None:
    time, sums = fusiform.frames[-1].solved.time, fusiform.measures[-1].sums
    assert sums is not None
    last = [force for force in fusiform.suture_forces if force.time == time]
    resolved = [force.force_mn for force in last if force.suture not in sums.unresolved]
    assert len(resolved) == len(last) - len(sums.unresolved) > 0
    assert closing_force(fusiform).value == pytest.approx(1e-3 * sum(resolved), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("angle", [30, 60, 90])
def test_before_it_is_cut_a_z_plasty_has_gained_nothing_and_its_limb_lies_at_the_angle_drawn(
    angle: int, tmp_path: Path
) -> None:
    procedure = OPERATIONS[f"z-plasty-{angle}"](COARSE)
    result = solve_procedure(procedure, tmp_path / "z.usdc", frames=(1, 1), error_estimate=False)
    assert scar_gain(result).value == pytest.approx(0.0, abs=0.05)
    assert limb_turn(result).value == pytest.approx(angle, abs=0.05)


def test_a_row_that_there_is_not_is_refused_before_anything_is_solved(tmp_path: Path) -> None:
    with refuses(ProblemCode.REPORT_UNKNOWN):
        run_literature(["z-plasty-gain-61"], tmp_path / "literature", ReportProgress())
    assert not (tmp_path / "literature").exists()


def test_the_command_prints_the_rows_and_the_page_shows_them(tmp_path: Path) -> None:
    arguments = ["report", "literature", "lines-gape", "-o", str(tmp_path), "--spacing", "4"]
    result = CliRunner().invoke(cli, arguments)
    assert result.exit_code == 0, result.output
    assert "lines-gape" in result.stdout
    results = json.loads((tmp_path / "literature.json").read_text(encoding="utf-8"))
    (found,) = results["rows"]
    assert found["verdict"] == Verdict.AGREES.value  # in taut skin a cut across the lines gapes more
    page = literature_page(results)
    assert "### lines-gape" in page
    assert "1 row: 1 agree" in page
    assert "Disagrees" not in page
    found["verdict"] = Verdict.DISAGREES.value
    assert "Disagrees" in literature_page(results)


def test_what_the_lattice_costs_two_forces_alike_is_no_error_of_their_quotient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both are 20 % uncertain, and 20 and 25 % greater on the coarse lattice: as one the quotient is 3 % uncertain.

    The geometric mean with the sum of both, 40 %, is taken.
    """
    forces = {"held": Measured(10.0, 2.0), "freed": Measured(8.0, 1.6), "coarser": Measured(8.0, 2.4)}
    shares = {"held": 1.2, "freed": 1.25, "coarser": 1.2, "unresolved": None}
    monkeypatch.setattr(measured, "closing_force", lambda name: forces.get(name, Measured(8.0, 1.6)))
    monkeypatch.setattr(measured, "_coarse_share", shares.__getitem__)
    found = measured.closing_share("held", "freed")
    assert found.value == pytest.approx(0.8)
    as_one = 1.0 - (1.2 / 1.25) ** (1.0 / (2.0**FORCE_ORDER - 1.0))
    assert as_one == pytest.approx(0.03, abs=2e-3)
    assert found.error == pytest.approx(0.8 * math.sqrt(as_one * 0.4))
    # Where the two agree by chance, what their own errors differ by is left: 30 % less 20 %.
    assert measured.closing_share("held", "coarser").error == pytest.approx(0.8 * math.sqrt(0.1 * 0.5))
    # Where the coarse lattice resolves no suture, both errors add as they did.
    assert measured.closing_share("held", "unresolved").error == pytest.approx(0.8 * 0.4)
