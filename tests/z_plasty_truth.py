"""The Z-plasty solved on a fine lattice, which the tests of its error judge coarser ones by: `z_plasty_truth.py`.

The solve takes about eight minutes on two cores, a third of the whole suite, and its result hardly ever changes: so it
is a command of its own, and its last result is kept beside it with the key of the program that was solved. Where that
program changes, the tests say so; then run this again.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.daemon_solver import connect_to
from lappet.program.keys import frame_keys
from lappet.program.program import Program
from lappet.reports.error_time.measurement import DEFAULT, skin_of
from lappet.reports.error_time.procedure_scenes import ProcedureScene, z_plasty_scene
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore

FILE = Path(__file__).resolve().parent / "end_to_end/z_plasty_truth.npz"
# Of 0.8 mm, 0.02 mm from this one, it would be as uncertain as what is to be judged is wrong at 4/3 mm.
SPACING = 0.6


def fine_program(scene: ProcedureScene) -> Program:
    """The program whose result is kept."""
    return scene.program(SPACING, **DEFAULT)


def kept_truth(scene: ProcedureScene) -> NDArray[np.float64]:
    """The skin's points (n, 3) in the last frame, mm. Fails where another program was solved."""
    with np.load(FILE) as kept:
        key, points = str(kept["key"]), kept["points"].astype(np.float64)
    assert key == frame_keys(fine_program(scene), "")[-1], "the Z-plasty is another one: run tests/z_plasty_truth.py"
    return points


def main() -> int:
    """Solve and keep."""
    scene = z_plasty_scene()
    program = fine_program(scene)
    with tempfile.TemporaryDirectory() as folder:
        found = solve_program(program, FrameStore(Path(folder)), connect_to(None), "test", SolveObserver())
    if found.reason is not None:
        print(found.reason, file=sys.stderr)
        return 1
    points = found.frames[-1].solved.points[skin_of(scene.program(2.0))].astype(np.float32)
    np.savez_compressed(FILE, key=frame_keys(program, "")[-1], points=points)
    return 0


if __name__ == "__main__":
    sys.exit(main())
