"""A Z-plasty of 90° in skins from slack to taut: it converges like one of 60°."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from test_examples import script

from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.solved_frame import SolvedFrame
from lappet.designs import oval
from lappet.procedure import Material, Procedure, Undermine
from lappet.program.compile import compile_program
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.presets.skin import FACE, SCALP, SKIN

SKINS = (SKIN.material, FACE.material, SCALP.material, Material("slack", youngs_modulus=50.0, poissons_ratio=0.45))
SPACING = 2.0  # mm: its limbs of 90° lie along the lattice, which hardly tells their three rows of sutures apart
BEYOND = (40.0, 56.0)  # mm, length and width of the area that is undermined


def z_plasty(angle: float, skin: Material) -> Procedure:
    """The example with flaps of another angle in another skin, undermined around the wider of the two designs."""
    example = script("z_plasty")
    example.ANGLE = angle
    made: Procedure = example.build()
    area = oval((0.0, 0.0, example.THICKNESS), *BEYOND, (1.0, 0.0, 0.0))
    freed = Undermine("undermining", example.UNDERMINE, area)
    events = tuple(freed if isinstance(event, Undermine) else event for event in made.events)
    return replace(made, tissue=replace(made.tissue, material=skin.name), materials=(skin,), events=events)


def solved(procedure: Procedure, folder: Path) -> list[SolvedFrame]:
    """All its frames; none of them may fail."""
    program = compile_program(procedure, settings=SolverSettings(spacing=SPACING))
    found = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert found.reason is None, found.reason
    return [frame.solved for frame in found.frames]


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_flaps_of_90_degrees_converge_in_at_most_twice_the_iterations_of_60(skin: Material, tmp_path: Path) -> None:
    newton = {}
    for angle in (60.0, 90.0):
        frames = solved(z_plasty(angle, skin), tmp_path)
        assert all(frame.diagnostics.converged for frame in frames)
        assert frames[-1].diagnostics.largest_gap <= 1e-3 * SPACING
        assert frames[-1].diagnostics.minimum_j > 0.5
        newton[angle] = sum(frame.diagnostics.newton for frame in frames)
    assert newton[90.0] <= 2 * newton[60.0], newton
