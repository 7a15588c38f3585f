"""What undermining takes off the force that closes a wound, as it was measured."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from test_examples import script

from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.procedure import Material, Undermine
from lappet.program.compile import compile_program
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.presets.skin import FACE, SKIN

# Shares of the closing force: 13.6 % in piglets (Plast Reconstr Surg 107:1201, 2001) to about 30 %.
LEAST, MOST = 0.136, 0.30
SPACING = 1.5  # mm; at 2 mm the shares are a quarter larger


def closing_force(skin: Material, undermined: bool, folder: Path) -> float:
    """The sum of the suture forces of the closed ellipse, mN."""
    made = script("ellipse").build()
    events = tuple(event for event in made.events if undermined or not isinstance(event, Undermine))
    procedure = replace(made, tissue=replace(made.tissue, material=skin.name), materials=(skin,), events=events)
    program = compile_program(procedure, settings=SolverSettings(spacing=SPACING))
    found = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert found.reason is None, found.reason
    return float(found.frames[-1].solved.suture_forces.sum())


@pytest.mark.slow
@pytest.mark.timeout(300)
@pytest.mark.parametrize(
    "skin",
    [
        SKIN.material,
        # 11.6 % here and 13.4 % at 2 mm: less than was measured, so that the bed under it is not right yet.
        pytest.param(FACE.material, marks=pytest.mark.xfail(strict=True, reason="less than was measured")),
    ],
    ids=lambda skin: skin.name,
)
def test_undermining_takes_off_as_much_of_the_closing_force_as_was_measured(skin: Material, tmp_path: Path) -> None:
    held, freed = (closing_force(skin, undermined, tmp_path) for undermined in (False, True))
    assert LEAST <= 1.0 - freed / held <= MOST
