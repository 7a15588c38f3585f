"""Forces do not depend on how the lattice is turned, or what comes to the same, on how the tissue lies in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from advancement_scene import advancement, shifted, turned
from lappet.daemon.solved_frame import SolvedFrame
from lappet.designs import Row, Schedule, Technique, flap_operation, limberg
from lappet.procedure import Material, Procedure
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.suture_forces import suture_forces
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_sheet import SkinSheet

pytestmark = pytest.mark.slow

SPACING = 1.0
TURNS = [(15.0, 0.0, 0.0), (30.0, 0.0, 0.0), (45.0, 0.0, 0.0), (0.0, 10.0, 0.0), (0.0, 20.0, 90.0), (30.0, 15.0, 20.0),
         (45.0, 35.0, 0.0), (0.0, 45.0, 0.0)]  # fmt: skip


def rotation(degrees: float, axis: tuple[float, float, float]) -> NDArray[np.float64]:
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across


def orientation(yaw: float, tilt: float, about: float) -> NDArray[np.float64]:
    """Turned about the vertical, then tilted about a horizontal axis in this direction; degrees."""
    along = np.radians(about)
    return rotation(tilt, (np.cos(along), np.sin(along), 0.0)) @ rotation(yaw, (0.0, 0.0, 1.0))


def rhomboid(depth: float) -> Procedure:
    """Limberg's flap with sides of 8 mm in skin of 3 mm, sutures in this depth."""
    top = 3.0
    tissue = flat_patch((44.0, 40.0, top), resolution=2.0, gravity=0.0, bed_stiffness=10.0, bed_shear=10.0)
    how = Technique(beyond=7.0, apart=2.5, margin=1.5, rows=(Row("skin", depth),), height=4.0, inside=1.5)
    when = Schedule(2, 2, 2, 2, 6, 6, 7, 6, 8, 8, 8)
    design = limberg((0.0, 0.0, top), (1.0, 0.0, 0.0), 8.0)
    events = tuple(each for each in flap_operation(design, SkinSheet.of(tissue), when, how) if each.kind != "Landmark")
    return Procedure(tissue, (Material("skin"),), events=events, start_time=2, end_time=8)


def frame_of(procedure: Procedure, folder: Path) -> tuple[Program, SolvedFrame]:
    program = compile_program(procedure, settings=SolverSettings(spacing=SPACING))
    return program, shifted(program, folder, SPACING)


def forces_of(procedure: Procedure, folder: Path) -> dict[str, float]:
    """The forces (mN) of the sutures that the lattice resolves."""
    rows = suture_forces(*frame_of(procedure, folder))
    return {row.suture: row.force_mn for row in rows if row.resolved}


@pytest.mark.parametrize("depth", [0.0, 1.5])
def test_an_advancement_pulls_alike_in_every_orientation(tmp_path: Path, depth: float) -> None:
    aligned = forces_of(advancement(depth), tmp_path)
    assert sum(aligned.values()) > 500.0
    for turn in TURNS:
        found = forces_of(turned(advancement(depth), orientation(*turn)), tmp_path)
        assert set(found) == set(aligned)
        assert sum(found.values()) == pytest.approx(sum(aligned.values()), rel=0.03), turn
        assert max(found.values()) == pytest.approx(max(aligned.values()), rel=0.05), turn


def test_a_rhomboid_flap_pulls_alike_in_every_orientation(tmp_path: Path) -> None:
    """All its sutures: one beside the end of a cut that a lattice does not part bears what its neighbors do not."""
    aligned = frame_of(rhomboid(1.5), tmp_path)[1].suture_forces.sum()
    assert aligned > 300.0
    for turn in TURNS:
        found = frame_of(turned(rhomboid(1.5), orientation(*turn)), tmp_path)[1].suture_forces.sum()
        assert found == pytest.approx(aligned, rel=0.05), turn
