"""A fine lattice in bending at the default settings: what stopping early leaves does not grow as cells become smaller.

Conjugate gradients find bending last, and the residual of a slender beam says little about how far its end still has to
go; in single precision its forces are the small differences of large numbers.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from lappet.daemon.daemon_solver import connect_to
from lappet.program.settings import MaterialParameters
from lappet.reports.box_scenes import CANTILEVER, BoxScene
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore

pytestmark = pytest.mark.slow

SPACING = 1.25  # mm
EXACT = {"precision": "double", "tolerance": 1e-8}
SLENDER = BoxScene(
    "slender",
    "a beam of 50 x 10 x 5 mm, held at one end, under its own weight",
    (50.0, 10.0, 5.0),
    (20, 4, 2),
    fixed=(0,),
    gravity=9.81,
    material=MaterialParameters(youngs_modulus=100.0, poissons_ratio=0.45),
)


@pytest.mark.parametrize("scene", [CANTILEVER, SLENDER], ids=lambda scene: scene.name)
def test_a_cantilever_on_a_fine_lattice_bends_as_far_as_it_does_in_double_precision(
    tmp_path: Path, scene: BoxScene
) -> None:
    plain, exact = (
        solve_program(
            scene.program(SPACING, **settings), FrameStore(tmp_path / name), connect_to(None), "test", SolveObserver()
        )
        for name, settings in (("plain", {}), ("exact", EXACT))
    )
    assert plain.reason is None
    assert exact.reason is None
    rest = scene.program(SPACING).epochs[0].surface.points
    ends = [found.frames[-1].solved.points.astype(np.float64) for found in (plain, exact)]
    assert np.linalg.norm(ends[1] - rest, axis=1).max() > 5.0
    assert np.linalg.norm(ends[0] - ends[1], axis=1).max() < 0.02
