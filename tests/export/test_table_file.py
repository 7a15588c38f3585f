"""The table of a cache has what the cache has, frame by frame."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from lappet.drawing.skin_read import SkinCache
from lappet.export.export_request import ExportRequest
from lappet.export.formats import export
from lappet.output.skin_cache import write_skin_cache
from lappet.program.compile import compile_program
from lappet.solve.measures import FrameMeasures, Gauges
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.usd.stage import write_procedure
from small_procedure import FakeSolver, small_procedure


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[FrameMeasures]]:
    folder = tmp_path_factory.mktemp("table")
    program = compile_program(small_procedure())
    frames = solve_program(program, FrameStore(folder / "s"), FakeSolver().connect, "fake", SolveObserver()).frames
    gauges = Gauges(program)
    measures = [gauges.measure(frame.solved) for frame in frames]
    write_procedure(small_procedure(), folder / "p.usda")
    states = [frame.solved for frame in frames]
    write_skin_cache(folder / "c.usdc", folder / "p.usda", small_procedure(), program, states, "key", measures)
    return folder / "c.usdc", measures


def table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_a_row_for_each_frame_has_forces_lengths_and_places(
    solved: tuple[Path, list[FrameMeasures]], tmp_path: Path
) -> None:
    path, measures = solved
    (written,) = export(ExportRequest((path,), tmp_path / "t.csv"))
    rows, cache = table(written), SkinCache(path)
    assert [float(row["time code"]) for row in rows] == list(cache.frames)
    assert [float(row["time [s]"]) for row in rows] == pytest.approx([k / 24.0 for k in range(8)], abs=1e-6)
    for row, time, measured in zip(rows, cache.frames, measures, strict=True):
        place = cache.named_landmarks(time)["corner"]
        assert [float(row[f"landmark corner {axis} [mm]"]) for axis in "xyz"] == pytest.approx(list(place), abs=1e-4)
        sutures = cache.sutures(time)
        assert bool(row["suture stitch force [mN]"]) == bool(sutures.active[0])
        if sutures.active[0]:
            apart = float(np.linalg.norm(sutures.ends[0, 1] - sutures.ends[0, 0]))
            assert float(row["suture stitch length [mm]"]) == pytest.approx(apart, abs=1e-4)
            assert float(row["suture stitch force [mN]"]) == pytest.approx(5.0)
        if measured.seams:
            (seam,) = measured.seams
            assert float(row["seam stitch scar length [mm]"]) == pytest.approx(seam.measure.scar_length_mm, rel=1e-4)
            assert float(row["seam stitch widest gap [mm]"]) == pytest.approx(float(np.max(seam.gap)), rel=1e-3)


def test_chosen_frames_alone_have_rows(solved: tuple[Path, list[FrameMeasures]], tmp_path: Path) -> None:
    (written,) = export(ExportRequest((solved[0],), tmp_path / "t.csv", {"frames": (2.0, 7.0)}))
    assert [row["time code"] for row in table(written)] == ["2", "7"]
