"""Small tissues from timeline to report: one sinks, one does not converge, one is too large, one is cut to pieces."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.daemon.client import SolverClient, SolverRefused
from lappet.designs import oval
from lappet.procedure import (
    Incision,
    Landmark,
    Material,
    Procedure,
    Region,
    Suture,
)
from lappet.program.settings import SolverSettings
from lappet.tissue.patch import flat_patch
from lappet.tissue.surface import skin_faces
from lappet.usd.stage import write_procedure
from lappet_runs import solve
from small_procedure import small_procedure

pytestmark = pytest.mark.slow

TOP = 2.0


def test_every_part_of_a_tissue_on_its_bed_sinks_by_its_own_weight(tmp_path: Path) -> None:
    """Heavy below 1 mm, but light throughout on the right: from the USD file to the landmarks in the report.

    u = (sum of density times thickness) g / bed stiffness, away from where the two meet; the bending of the sheet dies
    off within 3 mm: (4 E t^3 / (12 k))^(1/4).
    """
    patch = flat_patch((48.0, 8.0, TOP), resolution=2.0, spacing=1.0)
    whole = np.flatnonzero(skin_faces(patch))
    corners = patch.points[patch.face_vertex_indices.reshape(-1, 4)[whole]]
    subsets = {"bed": patch.subsets["bed"], "rim": patch.subsets["fixed"]}
    subsets |= {"deep": whole, "right": whole[corners[:, :, 0].min(axis=1) >= 0.0]}
    tissue = replace(
        patch,
        subsets=subsets,
        gravity=9.81,
        bed_stiffness=2.0,
        bed_shear=2.0,
        regions=(Region("deep", "heavy", 1.0), Region("right", "light")),
    )
    skin = Material("skin", "corotated", 50.0, 0.0, density=1000.0)
    materials = (skin, replace(skin, name="heavy", density=3000.0), replace(skin, name="light", density=500.0))
    marks = tuple(Landmark(name, ((x, 0.0, TOP),), name) for name, x in (("left", -20.0), ("right", 20.0)))
    slit = Incision("slit", 2.0, ((-22.0, 2.0, TOP), (22.0, 2.0, TOP)), depth=1.0)  # changes no weight
    procedure = Procedure(tissue, materials, (slit, *marks), end_time=2.0)
    write_procedure(procedure, tmp_path / "p.usda")
    run = solve(tmp_path, "--tolerance", "1e-5", "--precision", "double")
    assert run.status == 0, run.stderr
    assert run.report["scene_profile"]["materials"]
    assert len(run.report["settings"]["materials"]) == 3
    for time in (1, 2):
        found = run.frame(time)["landmarks"]
        for name, mass in (("left", 1000.0 + 3000.0), ("right", 500.0 + 500.0)):
            expected = mass * 9.81e-6 / 2.0
            assert TOP - found[name][2] == pytest.approx(expected, rel=0.05), (time, name)


def test_a_frame_that_cannot_converge_exits_with_1_naming_frame_and_reason(tmp_path: Path) -> None:
    """All faces are fixed: nothing can draw the ends of the suture together, 8 mm apart, which is told at frame 6.

    Eight points per cell see what the tissue within would have to bear; one lets it shear on to 250 N.
    """
    small = small_procedure()
    everywhere = np.arange(len(small.tissue.face_vertex_counts), dtype=np.int32)
    held = replace(small.tissue, subsets={**small.tissue.subsets, "fixed": everywhere})
    slit, hook, _, mark = small.events
    stitch = Suture("stitch", ((2.0, -4.0, TOP), (2.0, 4.0, TOP)), 5.0, 2.0)
    write_procedure(small_procedure(tissue=held, events=(slit, hook, stitch, mark)), tmp_path / "p.usda")
    run = solve(tmp_path, "--quadrature", "8")
    assert run.status == 1
    assert "Frame 6: " in run.stderr
    assert run.report["failed"]["time_code"] == 6
    assert run.report["failed"]["code"] in (ProblemCode.FRAME_GAP, ProblemCode.FRAME_ITERATIONS)
    assert run.report["failed"]["reason"] in run.report["reason"]
    assert run.report["reason"] in run.stderr
    assert [frame["time_code"] for frame in run.report["frames"]] == [1, 2, 3, 4, 5]
    assert run.cache


def test_a_lattice_too_large_for_the_memory_is_refused_before_it_is_made(tmp_path: Path) -> None:
    write_procedure(small_procedure(), tmp_path / "p.usda")
    run = solve(tmp_path, "--spacing", "0.005")
    assert run.status == 1
    assert "GiB" in run.stderr
    assert "spacing" in run.stderr
    assert not run.cache
    epoch = build_epochs(small_procedure())[0]
    with SolverClient() as client:
        client.open(SolverSettings(spacing=0.1, memory_budget=64 << 20))
        with pytest.raises(SolverRefused, match="spacing") as error:
            client.set_epoch(epoch)
        assert error.value.code == "memory_budget"
        assert client.ping() < 1.0


@pytest.mark.parametrize("kerf", [0.01, 0.05, 0.2, 1.0])
def test_a_cut_separates_as_many_fragments_at_every_kerf_and_fine_ratio(kerf: float) -> None:
    across = Incision("across", 2.0, ((-13.0, -3.0, TOP), (1.0, 0.4, TOP), (13.0, 1.3, TOP)), kerf=kerf)
    outline = Incision("outline", 3.0, oval((4.0, 5.0, TOP), 5.0, 3.0, (1.0, 0.0, 0.0)), kerf=kerf, closed=True)
    slit = Incision("slit", 4.0, ((-9.0, 3.1, TOP), (-2.0, 5.3, TOP)), kerf=kerf)
    partial = Incision("partial", 5.0, ((-14.0, 6.3, TOP), (14.0, 2.0, TOP)), kerf=kerf, depth=0.5 * TOP)
    patch = flat_patch((24.0, 16.0, TOP), resolution=2.0, spacing=1.0)
    epochs = build_epochs(Procedure(patch, events=(across, outline, slit, partial), end_time=5.0))
    with SolverClient() as client:
        for ratio in (4, 6, 10):
            client.open(SolverSettings(spacing=1.0, fine_ratio=ratio, origin=(-12.0, -8.0, 0.0), threads=1))
            counted = [client.set_epoch(epoch).fragments for epoch in epochs]
            assert counted == [1, 2, 3, 3, 3], f"fine ratio {ratio}"
    assert [epoch.fragments for epoch in epochs] == [1, 2, 3, 3, 3]
