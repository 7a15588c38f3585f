"""The table of suture forces: closures, sums, shares, warnings and the file."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.output.tables import write_table
from lappet.procedure import Incision, Suture
from lappet.procedure.stitches import Station, running, simple
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.force_sums import force_sums
from lappet.solve.mean_tension import greatest_mean_tension
from lappet.solve.suture_forces import (
    SutureForce,
    closing_tension,
    closure_of,
    suture_forces,
    suture_warnings,
)
from lappet.tissue.patch import flat_patch
from lappet.tissue.surface import tissue_surface
from small_procedure import TOP, small_procedure

# Two rows across the slit, placed in another order than they are numbered.
SEWN = tuple(
    Suture(f"{name}_{number}", ((x, -1.0, TOP), (x, 1.0, TOP)), 5.0)
    for name, number, x in (
        ("near", 2, 0.0),
        ("near", 1, -3.0),
        ("near", 10, 4.0),
        ("donor", 1, 5.0),
        ("donor", 2, 8.0),
    )
)
FORCES = {"near_1": 10.0, "near_2": 20.0, "near_10": 50.0, "donor_1": 15.0, "donor_2": 5.0}


def test_a_thread_that_turns_back_may_cut_through_with_half_the_tension() -> None:
    bites = ((0.0, -1.0, TOP), (0.0, 1.0, TOP), (1.0, -1.0, TOP))
    thread = Suture("running", bites, 5.0, mode="thread", pull_through=1500.0)
    solved = SolvedFrame(
        7.0,
        np.zeros((0, 3), np.float32),
        suture_index=np.zeros(1, np.int32),
        suture_points=np.array([[bites[0], bites[2]]]),
        suture_forces=np.array([900.0]),
        suture_inner_bites=np.ones(1, np.int32),
        inner_bite_points=np.array([bites[1]]),
    )
    program = Program((), (), SolverSettings(), stitches=(thread,))
    (row,) = suture_forces(program, solved)
    assert row.force_mn == 900.0
    assert row.apart_mm == pytest.approx(2.0 + np.sqrt(5.0))
    turn = np.linalg.norm(np.array([0.0, -1.0]) + np.array([1.0, -2.0]) / np.sqrt(5.0))
    assert row.bite_mn == pytest.approx(900.0 * turn, rel=1e-6)
    (warning,) = suture_warnings(program, [row])
    assert (warning.code, warning.value) == (ProblemCode.SUTURE_PULLS_THROUGH, f"{row.bite_mn:.4g}")


def frame(shared: dict[str, float]) -> tuple[Program, SolvedFrame]:
    program = Program((), (), SolverSettings(), stitches=SEWN)
    ends = np.array([suture.anchors for suture in SEWN])
    ends[:, :, 1] *= 0.25
    return (
        program,
        SolvedFrame(
            7.0,
            np.zeros((0, 3), np.float32),
            suture_index=np.arange(len(SEWN), dtype=np.int32),
            suture_points=ends,
            suture_forces=np.array([FORCES[suture.name] for suture in SEWN]),
            suture_force_vectors=np.array([[0.6, -0.8, 0.0]]) * np.array([[FORCES[suture.name]] for suture in SEWN]),
            suture_shared=np.array([shared.get(suture.name, 0.0) for suture in SEWN]),
        ),
    )


@pytest.mark.parametrize(
    ("name", "closure"), [("skin_near_12", "skin_near"), ("stitch", "stitch"), ("stitch 3", "stitch"), ("42", "42")]
)
def test_a_closure_is_a_name_without_its_number(name: str, closure: str) -> None:
    assert closure_of(name) == closure


def test_forces_lie_along_their_closures_in_the_order_of_their_numbers() -> None:
    rows = suture_forces(*frame({}))
    assert [row.suture for row in rows] == ["donor_1", "donor_2", "near_1", "near_2", "near_10"]
    assert [row.along_mm for row in rows] == pytest.approx([0.0, 3.0, 0.0, 3.0, 7.0])
    assert [row.force_mn for row in rows] == [15.0, 5.0, 10.0, 20.0, 50.0]
    assert [row.force_x_mn for row in rows] == pytest.approx([9.0, 3.0, 6.0, 12.0, 30.0])
    assert [row.force_y_mn for row in rows] == pytest.approx([-12.0, -4.0, -8.0, -16.0, -40.0])
    assert {row.force_z_mn for row in rows} == {0.0}
    assert {row.apart_mm for row in rows} == {0.5}
    assert sum(row.share for row in rows) == pytest.approx(1.0)


def test_sums_and_shares_of_closures() -> None:
    found = force_sums(suture_forces(*frame({})))
    assert (found.total_mn, found.greatest_mn, found.greatest_suture) == (100.0, 50.0, "near_10")
    assert found.donor_share == pytest.approx(0.2)
    near = next(each for each in found.closures if each.closure == "near")
    assert (near.total_mn, near.greatest_mn, near.share) == (80.0, 50.0, pytest.approx(0.8))
    assert near.force_mn == (10.0, 20.0, 50.0)
    assert near.tension_n_per_mm is None  # it belongs to no seam here


def test_the_closing_tension_is_the_pull_per_length_of_scar_and_closures_over_each_other_add() -> None:
    rows = suture_forces(*frame({}))
    near, donor = ([row for row in rows if row.closure == name] for name in ("near", "donor"))
    assert closing_tension(near, 8.0) == pytest.approx(0.08 / 8.0)
    assert closing_tension(rows, 8.0) == pytest.approx(0.08 / 8.0 + 0.02 / 8.0)
    # Two of three are resolved and stand for two thirds of the length.
    lost = [replace(row, resolved=row.suture != "near_10") for row in near]
    assert closing_tension(lost, 9.0) == pytest.approx(0.03 / 6.0)
    assert closing_tension([replace(row, resolved=False) for row in rows], 8.0) is None
    assert closing_tension([], 8.0) is closing_tension(donor, 0.0) is None


def test_a_suture_that_the_lattice_does_not_resolve_is_in_no_sum_and_said() -> None:
    program, solved = frame({"near_10": 0.6, "donor_1": 0.05})
    rows = suture_forces(program, solved)
    found = force_sums(rows)
    assert (found.total_mn, found.greatest_mn, found.unresolved) == (50.0, 20.0, ("near_10",))
    (warning,) = suture_warnings(program, rows)
    assert (warning.code, warning.prim) == (ProblemCode.SUTURE_UNRESOLVED, "/Procedure/Timeline/near_10")
    assert warning.severity == "warning"
    assert warning.place is not None


def test_a_thread_counts_by_the_pieces_that_cross_the_wound_and_is_resolved_where_one_of_them_is() -> None:
    """A loop: down beside the cut, across it, up on the other side and back over it."""
    loop = simple(Station((0.0, 0.0, TOP), (0.0, 1.0, 0.0)), 1.0, 1.0).suture("loop", 5.0)
    slit = Incision("slit", 3.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1)
    procedure = small_procedure(events=(slit, loop))
    program = compile_program(procedure)
    constraints = program.frames[-1]
    bites = np.array(loop.anchors)

    def resolved(*shared: float) -> bool:
        solved = SolvedFrame(
            constraints.time,
            np.zeros((0, 3), np.float32),
            suture_index=np.zeros(1, np.int32),
            suture_points=bites[None, [0, -1]],
            suture_forces=np.array([30.0]),
            suture_shared=np.array(shared),
            suture_inner_bites=np.array([3], np.int32),
            inner_bite_points=bites[1:-1],
        )
        (row,) = suture_forces(program, solved)
        return row.resolved

    assert resolved(0.0, 0.0, 0.0, 0.0)
    assert resolved(0.5, 0.0, 0.5, 0.0)  # the pieces beside the cut may share what they hold
    assert not resolved(0.0, 0.5, 0.0, 0.5)
    assert resolved(0.0, 0.5, 0.0, 0.05)  # it slides: what one crossing draws together is drawn together


def test_a_loop_draws_the_edges_together_with_every_piece_across_the_wound() -> None:
    """Twice its tension where it crosses straight; a running suture once for each pass and askew on its way back."""
    stations = [Station((x, 0.0, TOP), (0.0, 1.0, 0.0), gap=0.1) for x in (-3.0, 0.0, 3.0)]
    loop = simple(stations[1], 1.0, 1.0).suture("loop", 5.0)
    run = running(stations, 1.0).suture("run", 5.0)
    slit = Incision("slit", 3.0, ((-6.0, 0.0, TOP), (6.0, 0.0, TOP)), kerf=0.1)
    procedure = small_procedure(events=(slit, loop, run))
    program = compile_program(procedure)
    threads = [next(each for each in (loop, run) if each.name == name) for name in program.sutures]
    solved = SolvedFrame(
        program.frames[-1].time,
        np.zeros((0, 3), np.float32),
        suture_index=np.arange(2, dtype=np.int32),
        suture_points=np.array([(each.anchors[0], each.anchors[-1]) for each in threads]),
        suture_forces=np.array([30.0, 30.0]),
        suture_inner_bites=np.array([len(each.anchors) - 2 for each in threads], np.int32),
        inner_bite_points=np.concatenate([each.anchors[1:-1] for each in threads]),
    )
    rows = {row.suture: row for row in suture_forces(program, solved)}
    across = 2.0 + 0.1
    askew = across / np.hypot(across, 3.0)
    assert rows["loop"].pull_mn == pytest.approx(2.0 * 30.0, rel=1e-6)
    assert rows["run"].pull_mn == pytest.approx((3.0 + 2.0 * askew) * 30.0, rel=1e-6)
    assert [row.force_mn for row in rows.values()] == [30.0, 30.0]


def test_a_thread_that_may_cut_through_is_warned_of_once() -> None:
    program, solved = frame({})
    events = tuple(replace(suture, pull_through=30.0) for suture in SEWN)
    program = replace(program, stitches=events)
    rows = suture_forces(program, solved)
    later = suture_forces(program, replace(solved, time=8.0, suture_forces=0.9 * solved.suture_forces))
    (warning,) = suture_warnings(program, [*rows, *later])
    assert warning.code == ProblemCode.SUTURE_PULLS_THROUGH
    assert "50 mN at time 7" in warning.message
    assert "30 mN" in warning.message


def test_the_file_has_a_row_for_each_suture_and_frame(tmp_path: Path) -> None:
    rows = suture_forces(*frame({"near_10": 0.6}))
    write_table(tmp_path / "forces.csv", SutureForce, rows)
    with (tmp_path / "forces.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["suture"] for row in table] == [row.suture for row in rows]
    assert [float(row["force_mn"]) for row in table] == [row.force_mn for row in rows]
    assert [row["resolved"] for row in table] == ["True", "True", "True", "True", "False"]
    assert list(table[0]) == list(SutureForce.__dataclass_fields__)


def test_the_greatest_mean_tension_is_that_of_an_area() -> None:
    """A ridge of 4 mm is a mean over more than itself; a peak of a single point hardly counts."""
    surface = tissue_surface(flat_patch((60.0, 40.0, 4.0), resolution=0.5))
    skin = surface.points[:, 2] == 4.0
    x, y = surface.points[:, 0], surface.points[:, 1]
    wide = np.where(skin & (np.hypot(x - 10.0, y) < 6.0), 20.0, 1.0)
    peak = np.where(skin & (np.hypot(x + 10.0, y) < 0.1), 300.0, wide)
    for tension in (wide, peak):
        found = greatest_mean_tension(surface, tension)
        assert found is not None
        assert found.tension == pytest.approx(20.0)
        assert found.area == pytest.approx(25.0, rel=0.05)
        assert np.hypot(found.place[0] - 10.0, found.place[1]) < 4.0
    assert (surface.origin == FaceOrigin.SKIN).any()
    assert greatest_mean_tension(surface, np.zeros(0)) is None
