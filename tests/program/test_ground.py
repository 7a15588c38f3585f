"""Undermined tissue is told the ground that it rests on, whole as it was before any cut; other tissue is told none."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.procedure import Excision, Incision, Undermine
from lappet.program.compile import compile_program
from lappet.program.payloads import epoch_payload
from small_procedure import TOP, small_procedure

SQUARE = tuple((x, y, TOP) for x, y in ((-5.0, -5.0), (5.0, -5.0), (5.0, 5.0), (-5.0, 5.0)))
HOLE = tuple((x, y, TOP) for x, y in ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)))


def test_the_ground_of_undermined_tissue_is_all_of_its_bed_also_below_what_is_excised() -> None:
    events = (
        Incision("hole", 2.0, HOLE, closed=True),
        Excision("out", 3.0, ((0.0, 0.0, TOP),)),
        Undermine("free", 4.0, SQUARE),
    )
    program = compile_program(small_procedure(events=events))
    before, freed = program.epochs[-2], program.epochs[-1]
    assert len(before.ground.triangles) == 0
    points, triangles = freed.ground.points, freed.ground.triangles
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    assert 0.5 * np.linalg.norm(normals, axis=1).sum() == pytest.approx(24.0 * 16.0)
    assert (normals[:, 2] < 0.0).all()  # out of the tissue

    told = epoch_payload(freed, program.grips[-1], program.landmarks_at[-1]).arrays
    assert np.array_equal(told["ground_triangles"], triangles)
    assert "ground_points" not in epoch_payload(before, program.grips[-2], program.landmarks_at[-2]).arrays
