"""What a frame's changes do not reach stays at rest, from the shell to the cache."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from numpy.typing import NDArray
from pxr import Usd, UsdGeom

from lappet.commands.cli import cli
from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Hook, Incision, Material, Procedure
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import write_procedure

pytestmark = pytest.mark.slow

SPACING, TOLERANCE, END = 3.0, 1e-3, 7
STILL = {"gravity": 0.0, "bed_stiffness": 10.0, "bed_shear": 10.0}  # nothing acts before the hook, whose pull ends near
LEFT_OPEN = 2.0 * TOLERANCE * SPACING  # mm, what the tolerance of the residual leaves open in a whole solve too


def wide_patch() -> Procedure:
    """A cut in the middle of a patch of 150 x 150 x 6 mm on its bed; a hook pulls one of its edges up and away."""
    hook = Hook(
        name="hook",
        anchor=(0.0, 1.0, 6.0),
        targets=((3.0, (0.0, 1.0, 6.0)), (6.0, (0.0, 4.0, 8.0))),
        start=3,
        release=END,
        stiffness=200.0,
    )
    return Procedure(
        tissue=flat_patch((150.0, 150.0, 6.0), resolution=5.0, spacing=SPACING, **STILL),
        materials=(Material("skin", model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45),),
        events=(Incision("incision", 2, ((-9.0, 0.0, 6.0), (9.0, 0.0, 6.0)), kerf=0.05), hook),
        start_time=1,
        end_time=END,
    )


def solved_from_shell(procedure: Path, folder: Path, *options: str) -> tuple[dict[str, Any], list[NDArray[Any]]]:
    """The report, and the skin's points of every frame after the cut."""
    folder.mkdir()
    cache, report = folder / "cache.usdc", folder / "report.json"
    arguments = ["solve", str(procedure), "-o", str(cache), "--report", str(report), "--store", str(folder / "store")]
    done = CliRunner().invoke(cli, [*arguments, "--no-error-estimate", *options])
    assert done.exit_code == 0, done.output
    stage = Usd.Stage.Open(str(cache))
    skin = UsdGeom.Mesh(stage.GetPrimAtPath("/Procedure/Skin/epoch_01"))
    points = [np.asarray(skin.GetPointsAttr().Get(float(time))) for time in range(2, END + 1)]
    return json.loads(report.read_text(encoding="utf-8")), points


def test_a_wide_patch_is_solved_in_part_and_its_skin_is_where_solving_all_of_it_puts_it(tmp_path: Path) -> None:
    procedure = tmp_path / "patch.usda"
    write_procedure(wide_patch(), procedure)
    in_part, found = solved_from_shell(procedure, tmp_path / "auto")
    whole, expected = solved_from_shell(procedure, tmp_path / "whole", "--whole")
    cells = whole["lattice"]["cells"]
    active = {int(frame["time_code"]): frame["active_cells"] for frame in in_part["frames"]}
    assert in_part["settings"]["region"] == "auto"
    assert whole["settings"]["region"] == "whole"
    # Nothing acts before the hook; then its reach, and once it lets go as well. The first pull may reach further.
    assert [active[time] for time in (1, 2, 3)] == [0, 0, 0]
    assert all(0 < active[time] < cells / 2 for time in (5, 6, 7)), active
    assert {frame["active_cells"] for frame in whole["frames"]} == {0, cells}
    assert np.abs(expected[-2] - expected[0]).max() > 1.0
    for one, other in zip(found, expected, strict=True):
        assert np.linalg.norm(one - other, axis=1).max() < LEFT_OPEN


def nodes(program: Program, store: FrameStore) -> list[NDArray[Any]]:
    """The states of the program's frames."""
    solver = solver_identity(None)
    result = solve_program(program, store, connect_to(None), solver, SolveObserver())
    assert result.reason is None
    stored = [store.get(frame.key, SolvedFrame) for frame in result.frames]
    return [frame.state.nodes for frame in stored if frame is not None]


def test_a_solve_that_was_interrupted_goes_on_bit_for_bit(tmp_path: Path) -> None:
    program = compile_program(wide_patch())
    through = nodes(program, FrameStore(tmp_path / "through"))
    store = FrameStore(tmp_path / "interrupted")
    nodes(replace(program, frames=program.frames[:5]), store)
    resumed = nodes(program, store)
    assert len(resumed) == len(through) == END
    for one, other in zip(resumed, through, strict=True):
        np.testing.assert_array_equal(one, other)
