"""Whether the daemon starts, and whether it solves."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

from lappet.core.problem import ProblemsError
from lappet.daemon.client import SolverClient
from lappet.daemon.daemon_solver import connect_to
from lappet.daemon.process import daemon_identity, find_daemon
from lappet.installation.finding import Finding, broken
from lappet.procedure import Hook, Procedure
from lappet.program.compile import compile_program
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

_LIFT = 1.0  # mm


def check_solver() -> list[Finding]:
    """Find whether the daemon is there and starts, and have it solve a small patch of skin that a hook lifts.

    Returns
    -------
    list[Finding]
        One of the daemon; where that is well, one of the solve.
    """
    try:
        program = find_daemon()
        with SolverClient() as client:
            said = client.welcome
    except (ProblemsError, OSError) as error:
        return [broken("daemon", error)]
    told = f"{program}, version {said['version']}, {said['isa']} instructions, {said['threads']} threads"
    return [Finding("daemon", "ok", told), _solve()]


def _solve() -> Finding:
    try:
        hook = Hook("hook", (0.0, 0.0, 2.0), ((1.0, (0.0, 0.0, 2.0)), (2.0, (0.0, 0.0, 2.0 + _LIFT))), 1.0, 3.0)
        patch = flat_patch((16.0, 16.0, 2.0), resolution=2.0, spacing=1.0)
        solved = compile_program(Procedure(patch, events=(hook,), start_time=1.0, end_time=2.0))
        with tempfile.TemporaryDirectory(prefix="lappet-doctor-") as folder:
            begun = time.perf_counter()
            store = FrameStore(Path(folder) / "frames")
            result = solve_program(solved, store, connect_to(None), daemon_identity(), SolveObserver())
            seconds = time.perf_counter() - begun
    except (ProblemsError, OSError) as error:
        return broken("solve", error)
    if result.reason is not None:
        return Finding("solve", "broken", result.reason.message, result.reason.remedy)
    last = result.frames[-1].solved
    lifted = float(last.hook_points[0][2]) - 2.0
    cells = last.lattice.cells if last.lattice is not None else 0
    value = f"a hook lifts a patch of {cells} cells by {lifted:.2f} mm in {seconds:.1f} s"
    if not 0.5 * _LIFT < lifted < 1.01 * _LIFT:  # a hook yields like a spring
        return Finding(
            "solve", "broken", f"{value}; it pulls by {_LIFT:g} mm", "install Lappet or build the daemon anew"
        )
    return Finding("solve", "ok", value)
