"""What is undermined where the skin ends nearby: as far from the cuts as asked, and not up to the border."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.designs.library_operation import add_flap
from lappet.designs.undermined_area import INSET, SkinBorder, contour_around, reaches_border
from lappet.procedure import Procedure, Tissue, Undermine
from lappet.program.compile import compile_program
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_sheet import SkinSheet

CUT = (((-10.0, 0.0, 4.0), (0.0, 0.0, 4.0), (10.0, 0.0, 4.0)),)


def line_around(tissue: Tissue, cuts=CUT, beyond: float = 12.0) -> NDArray[np.float64]:
    return np.array(contour_around(SkinBorder(tissue), SkinSheet.of(tissue), cuts, beyond))


def to_cut(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distance to the straight cut of 20 mm."""
    return np.hypot(np.maximum(np.abs(points[:, 0]) - 10.0, 0.0), points[:, 1])


def test_away_from_borders_the_line_is_as_far_from_the_cuts_as_asked() -> None:
    line = line_around(flat_patch((100.0, 80.0, 4.0)))
    assert to_cut(line) == pytest.approx(np.full(len(line), 12.0), abs=1.0)
    around = np.arctan2(line[:, 1], line[:, 0])
    assert np.all(np.diff(np.unwrap(around)) > 0.0)  # counter-clockwise, once


def test_at_a_border_the_line_stays_on_the_skin() -> None:
    patch = flat_patch((100.0, 16.0, 4.0))
    line = line_around(patch)
    assert np.abs(line[:, 1]).max() == pytest.approx(8.0 - INSET, abs=0.4)
    assert np.abs(line[:, 0]).max() == pytest.approx(22.0, abs=1.0)
    assert not reaches_border(SkinBorder(patch), [tuple(point) for point in line * (1.0, 0.9, 1.0)])
    assert reaches_border(SkinBorder(patch), [(0.0, 7.5, 4.0)])


def test_skin_across_an_opening_is_not_undermined() -> None:
    """Two sheets that face each other over a slit of 4 mm, as lips over a mouth."""
    sheets = [flat_patch((60.0, 30.0, 4.0), center=(0.0, y)) for y in (15.0, -19.0)]
    both = Tissue(
        points=np.vstack([sheet.points for sheet in sheets]),
        face_vertex_counts=np.concatenate([sheet.face_vertex_counts for sheet in sheets]),
        face_vertex_indices=np.concatenate(
            [sheets[0].face_vertex_indices, sheets[1].face_vertex_indices + len(sheets[0].points)]
        ),
        subsets={
            name: np.concatenate([sheets[0].subsets[name], sheets[1].subsets[name] + len(sheets[0].face_vertex_counts)])
            for name in ("fixed", "bed")
        },
    )
    line = line_around(both, (((-8.0, 6.0, 4.0), (8.0, 6.0, 4.0)),), 14.0)
    assert line[:, 1].min() == pytest.approx(INSET, abs=0.4)


def test_a_flap_beside_the_border_of_a_dome_can_be_cut_and_undermined() -> None:
    dome = Procedure(dome_scalp(90.0, 48.0, 6.0, resolution=2.0), start_time=1, end_time=1)
    turn = 27.0 / 90.0
    at = (90.0 * np.sin(turn), 0.0, 90.0 * np.cos(turn))
    procedure = add_flap(dome, "limberg", at, (0.0, 1.0, 0.0), {"side": 11.0})
    (event,) = [event for event in procedure.events if isinstance(event, Undermine)]
    from_pole = 90.0 * np.arccos(np.array(event.points)[:, 2] / np.linalg.norm(event.points, axis=1))
    assert from_pole.max() < 48.0 - INSET + 0.3
    assert compile_program(procedure).epochs
