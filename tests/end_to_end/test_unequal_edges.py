"""Edges of unequal length: a run pairs them at equal shares, so that no rest is left over at its end."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.procedure import Event, Excision, Incision, Procedure, Suture, SutureRun, Undermine
from lappet.suturing.lip_pair import on_edge
from lappet.suturing.single_sutures import skin_of
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import read_procedure, write_procedure

pytestmark = pytest.mark.slow

TOP, APART = 3.0, 2.0
TISSUE = flat_patch((70.0, 50.0, TOP), resolution=2.0, spacing=1.5)
BOW = [(15.0 * np.cos(t), 7.0 * np.sin(t), TOP) for t in np.linspace(np.pi, 0.0, 40)]
CHORD = [(15.0 * np.cos(t), -1.0 * np.sin(t), TOP) for t in np.linspace(np.pi, 0.0, 40)]


def closed(sutures: Sequence[Event], folder: Path) -> SolveResult:
    """A half moon cut out of undermined skin and sewn."""
    events = (
        Incision("moon", 2.0, (*BOW, *CHORD[-2:0:-1]), closed=True),
        Excision("piece", 2.0, ((0.0, 2.0, TOP),)),
        Undermine("around", 2.0, ((-28.0, -18.0, TOP), (28.0, -18.0, TOP), (28.0, 18.0, TOP), (-28.0, 18.0, TOP))),
        *sutures,
    )
    folder.mkdir()
    write_procedure(Procedure(TISSUE, events=events, end_time=9.0), folder / "p.usda")
    return solve_procedure(read_procedure(folder / "p.usda"), folder / "p.usdc", error_estimate=False)


def test_edges_of_unequal_lengths_are_sewn_with_nothing_left_over_at_the_end(binary: Path, tmp_path: Path) -> None:
    run = SutureRun("wound", (tuple(BOW), tuple(CHORD)), 3.0, duration=5.0, spacing=APART, bite=0.05)
    long, short = run.lengths
    assert 1.1 < long / short < 1.3
    assert binary.exists()
    by_shares = closed([run], tmp_path / "run")
    # What happens where the stitches are as far apart on both edges: the rest of the longer one is left over.
    skin = skin_of(TISSUE)
    single = []
    for k, at in enumerate(np.arange(0.5 * APART, short, APART), start=1):
        ends = []
        for edge, length, side in zip(run.edges, run.lengths, run.sides, strict=True):
            place = on_edge(np.array(edge), at / length)
            ends.append(skin.beside(place.point, place.along, 0.05 * side))
        single.append(Suture(f"wound_{k}", (ends[0], ends[1]), 3.0, 5.0))
    by_length = closed(single, tmp_path / "single")
    mine, theirs = by_shares.seams[-1], by_length.seams[-1]
    assert mine.closed_share == 1.0
    assert mine.open_area_mm2 < 0.5 * theirs.open_area_mm2
    assert mine.greatest_gap_mm < 0.5 * theirs.greatest_gap_mm
    assert mine.edge_mismatch_mm < 0.6 * theirs.edge_mismatch_mm
    # Left over at the end, the longer edge stands up there; shared out, the dog-ears are alike at both ends.
    assert mine.end_dog_ear_mm < 0.8 * theirs.end_dog_ear_mm
    assert mine.end_dog_ear_mm == pytest.approx(mine.start_dog_ear_mm, rel=0.25)
    forces = [row for row in by_shares.suture_forces if row.time == 9.0]
    assert [row.suture for row in forces] == [f"wound/{k}" for k in range(1, len(forces) + 1)]
    assert {row.closure for row in forces} == {"wound"}
