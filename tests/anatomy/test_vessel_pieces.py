"""What cuts leave of vessels: where they are divided, what an excision takes with it, what is refused."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from lappet.anatomy.vessel_pieces import VesselPieces
from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Event, Excision, Incision, Point, Procedure, Undermine, Vessel
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch
from refusals import refuses

TOP, KERF = 6.0, 0.05
CUT = Incision("cut", 2.0, ((-10.0, 0.0, TOP), (10.0, 0.0, TOP)))
ACROSS = Vessel("angular", ((3.0, -12.0, 3.0), (3.0, 12.0, 3.0)), label="angular artery")


def compiled(events: Sequence[Event], *vessels: Vessel, spacing: float = 2.0) -> Program:
    """The program of a 40 x 30 x 6 mm patch with its skin at z = 6."""
    tissue = flat_patch((40.0, 30.0, TOP), spacing=spacing)
    return compile_program(Procedure(tissue, events=tuple(events), end_time=6.0, vessels=vessels))


def lengths(program: Program, epoch: int) -> list[float]:
    """Length of each piece in an epoch, mm."""
    pieces: VesselPieces = program.vessels_at[epoch]
    return [float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum()) for line in pieces.split(pieces.points)]


@pytest.mark.parametrize("spacing", [1.0, 2.0])
def test_an_incision_divides_a_vessel_at_its_two_walls(spacing: float) -> None:
    program = compiled([CUT], ACROSS, spacing=spacing)
    assert lengths(program, 0) == pytest.approx([24.0])
    assert lengths(program, 1) == pytest.approx([12.0 - KERF / 2] * 2)
    pieces = program.vessels_at[1]
    assert pieces.divided.tolist() == [[0, 1], [1, 0]]
    ends = [pieces.split(pieces.points)[0][-1], pieces.split(pieces.points)[1][0]]
    assert np.allclose(ends, [(3.0, -KERF / 2, 3.0), (3.0, KERF / 2, 3.0)])
    (crossing,) = program.vessel_crossings
    assert (crossing.incision, crossing.vessel, crossing.time) == ("cut", 0, 2.0)
    assert (crossing.along, crossing.depth) == pytest.approx((13.0, 3.0), abs=1e-6)
    assert crossing.point == pytest.approx((3.0, 0.0, 3.0), abs=1e-6)
    (note,) = program.notes
    assert (note.code, note.severity, note.prim) == (ProblemCode.VESSEL_CUT, "warning", "/Procedure/Timeline/cut")
    assert "cut crosses the angular artery at 13 mm" in note.message


def test_an_oblique_vessel_is_reported_where_it_meets_the_plane_of_the_cut() -> None:
    """The line from (-8, -10, 2) to (12, 10, 5) meets y = 0 at (2, 0, 3.5): 12 mm along, 2.5 mm deep."""
    program = compiled([CUT], Vessel("oblique", ((-8.0, -10.0, 2.0), (12.0, 10.0, 5.0)), "vein"))
    (crossing,) = program.vessel_crossings
    assert (crossing.along, crossing.depth) == pytest.approx((12.0, 2.5), abs=0.01)


def test_a_shallow_incision_and_one_that_ends_before_it_leave_a_vessel_whole() -> None:
    shallow = replace(CUT, depth=2.0)
    aside = replace(CUT, points=((-10.0, 0.0, TOP), (2.0, 0.0, TOP)))
    for cut in (shallow, aside):
        program = compiled([cut], ACROSS)
        assert program.vessel_crossings == ()
        assert program.notes == ()
        assert lengths(program, 1) == pytest.approx([24.0])
        assert not program.vessels_at[1].divided.any()


def test_a_vessel_is_divided_once_by_each_incision_and_told_once_over_the_epochs() -> None:
    second = Incision("second", 4.0, ((-10.0, 5.0, TOP), (10.0, 5.0, TOP)))
    free = Undermine("free", 5.0, ((-8.0, -4.0, TOP), (8.0, -4.0, TOP), (8.0, 4.0, TOP), (-8.0, 4.0, TOP)))
    program = compiled([CUT, second, free], ACROSS)
    assert [(each.incision, each.time) for each in program.vessel_crossings] == [("cut", 2.0), ("second", 4.0)]
    assert lengths(program, 2) == pytest.approx([12.0 - KERF / 2, 5.0 - KERF, 7.0 - KERF / 2])
    assert lengths(program, 3) == pytest.approx(lengths(program, 2), abs=1e-3)


def test_excised_tissue_takes_its_piece_of_the_vessel_with_it() -> None:
    ring = ((-5.0, -4.0, TOP), (5.0, -4.0, TOP), (5.0, 4.0, TOP), (-5.0, 4.0, TOP))
    around = Incision("around", 2.0, ring, closed=True)
    program = compiled([around, Excision("out", 3.0, ((0.0, 0.0, TOP),))], ACROSS)
    assert lengths(program, 1) == pytest.approx([8.0 - KERF / 2, 8.0 - KERF, 8.0 - KERF / 2], abs=1e-3)
    assert lengths(program, 2) == pytest.approx([8.0 - KERF / 2] * 2, abs=1e-3)
    assert [each.along for each in program.vessel_crossings] == pytest.approx([8.0, 20.0], abs=0.05)
    inside = compiled(
        [around, Excision("out", 3.0, ((0.0, 0.0, TOP),))], Vessel("own", ((-2.0, 0.0, 3.0), (2.0, 0.0, 3.0)))
    )
    assert len(inside.vessels_at[1].counts) == 1
    assert len(inside.vessels_at[2].counts) == 0


def test_a_vessel_on_curved_skin_stays_whole_where_its_chords_leave_the_tissue() -> None:
    tissue = dome_scalp(radius=40.0, reach=20.0, resolution=2.0, spacing=2.0)
    angles = np.linspace(-0.3, 0.3, 5)
    arc: list[Point] = [(40.0 * math.sin(angle), 0.0, 40.0 * math.cos(angle)) for angle in angles.tolist()]
    procedure = Procedure(tissue, vessels=(Vessel("vein", tuple(arc), "vein"),))
    (pieces,) = compile_program(procedure).vessels_at
    assert pieces.counts.shape == (1,)
    assert not pieces.divided.any()


def test_what_is_wrong_with_a_vessel_is_said_with_its_prim() -> None:
    tissue = flat_patch((40.0, 30.0, TOP), spacing=2.0)
    wrong = (
        (replace(ACROSS, kind="duct"), ProblemCode.VESSEL_KIND, "error"),  # type: ignore[arg-type]
        (replace(ACROSS, radius=0.0), ProblemCode.VESSEL_RADIUS, "error"),
        (replace(ACROSS, radius=float("nan")), ProblemCode.VESSEL_RADIUS, "error"),
        (replace(ACROSS, points=((3.0, -12.0, 3.0),)), ProblemCode.CURVE_TOO_SHORT, "error"),
        (replace(ACROSS, points=((3.0, -12.0, 3.0), (3.0, 12.0, 8.0))), ProblemCode.EVENT_OFF_TISSUE, "error"),
        (replace(ACROSS, points=((3.0, -12.0, 3.0), (3.0, 12.0, 6.5))), ProblemCode.EVENT_ANCHOR_MOVED, "warning"),
    )
    for vessel, code, severity in wrong:
        (found,) = check(Procedure(tissue, vessels=(vessel,)))
        assert (found.code, found.severity, found.prim) == (code, severity, "/Procedure/Anatomy/angular")
    assert check(Procedure(tissue, vessels=(ACROSS,))) == []
    (twice,) = {each.code for each in check(Procedure(tissue, vessels=(ACROSS, ACROSS)))}
    assert twice == ProblemCode.NAME_TWICE


def test_a_course_far_outside_is_refused_and_one_a_little_outside_is_moved_onto_the_skin() -> None:
    with refuses(ProblemCode.PROGRAM_POINT_OFF_TISSUE, "/Procedure/Anatomy/angular"):
        compiled([], replace(ACROSS, points=((3.0, -12.0, 3.0), (3.0, 12.0, 8.0))))
    pieces = compiled([], replace(ACROSS, points=((3.0, -12.0, 6.0), (3.0, 12.0, 6.5)))).vessels_at[0]
    assert len(pieces.counts) == 1
    assert np.allclose(pieces.points[:, 2], TOP)
