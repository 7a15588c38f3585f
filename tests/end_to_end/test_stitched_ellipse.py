"""What the usual stitches do to a wound: an ellipse of 30 x 2.4 mm in undermined skin of 3 mm.

Wider ones in skin this soft are drawn together with forces that bury the bites: there the lips follow the lattice.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.solved_frame import SolvedFrame
from lappet.designs.fusiform_design import fusiform
from lappet.procedure import Excision, Incision, Landmark, Material, Procedure, Suture, Undermine
from lappet.procedure.stitches import Station, Stitch, running, simple, vertical_mattress
from lappet.program.compile import compile_program
from lappet.program.settings import SolverSettings
from lappet.solve.bite_forces import bite_forces, bite_points
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

pytestmark = pytest.mark.slow

TOP = 3.0
BESIDE = 0.2  # mm from the edge, where the lips are looked at
ELLIPSE = fusiform((0.0, 0.0, TOP), 30.0, 2.4, (1.0, 0.0, 0.0), sutures=6)
PAIRS = np.array(ELLIPSE.pairs)  # (6, 2, 3)
STATIONS = [
    Station(tuple(pair.mean(axis=0).tolist()), tuple((pair[1] - pair[0]).tolist()), gap=float(np.ptp(pair[:, 1])))
    for pair in PAIRS
]


def closed(sutures: Sequence[Suture], folder: Path, spacing: float = 1.0) -> SolvedFrame:
    """The ellipse with these sutures; landmarks on both lips where it is sewn."""
    corners = [(-22.0, -14.0, TOP), (22.0, -14.0, TOP), (22.0, 14.0, TOP), (-22.0, 14.0, TOP)]
    lips = PAIRS + BESIDE * np.sign(PAIRS - PAIRS.mean(axis=1, keepdims=True)) * (0.0, 1.0, 0.0)
    events = (
        Incision("ellipse", 1, ELLIPSE.curve, closed=True),
        Excision("piece", 1, (ELLIPSE.seed,)),
        Undermine("undermining", 1, tuple(corners)),
        Landmark("lips", tuple(map(tuple, lips.reshape(-1, 3).tolist())), "lips"),
        *sutures,
    )
    tissue = flat_patch((60.0, 40.0, TOP), resolution=2.0, gravity=0.0, bed_stiffness=10.0, bed_shear=10.0)
    procedure = Procedure(tissue, (Material("skin"),), events=events, start_time=1, end_time=2)
    program = compile_program(procedure, settings=SolverSettings(spacing=spacing))
    found = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert found.reason is None
    return found.frames[-1].solved


def rise(frame: SolvedFrame) -> float:
    """How far the lips stand above the plane of the skin in the mean, mm."""
    return float((frame.landmarks[:, 2] - TOP).mean())


def gaps(frame: SolvedFrame) -> NDArray[np.float64]:
    """How far the lips are apart at each place, mm."""
    lips = frame.landmarks.reshape(-1, 2, 3)
    return np.asarray(lips[:, 0, 1] - lips[:, 1, 1] - 2.0 * BESIDE)


def each(make: Callable[[Station], Stitch], drawn: float) -> list[Suture]:
    """A stitch of its own at each place, drawn to a share of its length."""
    return [make(at).suture(f"stitch_{k}", 1, drawn, thread="nylon 4-0") for k, at in enumerate(STATIONS)]


def test_a_vertical_mattress_everts_the_lips_and_a_simple_stitch_as_deep_does_not(tmp_path: Path) -> None:
    sewn = {
        "simple": each(lambda at: simple(at, depth=2.0), 0.95),
        "skin": each(simple, 0.85),
        "mattress": each(lambda at: vertical_mattress(at, depth=2.0), 0.9),
    }
    heights = {}
    for name, sutures in sewn.items():
        frames = [closed(sutures, tmp_path, spacing) for spacing in (1.0, 0.75)]
        for frame in frames:
            assert np.abs(gaps(frame)).max() < 0.4  # of 1.2 to 2.4 mm
        heights[name] = [rise(frame) for frame in frames]
        assert heights[name][0] == pytest.approx(heights[name][1], abs=0.02)
    # A thread on the skin bends the lips into the wound; one that passes deep and comes back over the skin less so.
    assert max(heights["skin"]) < min(heights["simple"]) - 0.1
    assert max(heights["simple"]) < 0.0
    assert min(heights["mattress"]) > 0.3


def test_a_running_suture_closes_an_ellipse_with_one_tension_where_separate_threads_have_many(tmp_path: Path) -> None:
    drawn = 0.95
    separate = closed(each(lambda at: simple(at, depth=2.0), drawn), tmp_path)
    thread = running(STATIONS, depth=2.0).suture("running", 1, drawn, thread="nylon 4-0")
    frame = closed([thread], tmp_path)
    assert np.abs(gaps(frame)).max() < 0.5
    assert separate.suture_forces.max() > 1.2 * separate.suture_forces.min()
    tension, points, forces = float(frame.suture_forces[0]), bite_points(frame)[0], bite_forces(frame)[0]
    assert separate.suture_forces.min() < tension < 1.2 * separate.suture_forces.max()
    assert points.shape == (24, 3)
    # Stretched by the tension beyond the length to which it is drawn; 1e-3 mm is lost at each piece.
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert length == pytest.approx(thread.length + tension / thread.axial_stiffness + 0.023, abs=0.003)
    # At its ends it pulls with its tension, where it turns with up to twice that.
    assert forces[[0, -1]] == pytest.approx(tension, rel=1e-3)
    assert forces.max() < 2.0 * tension
    assert forces[1:-1].min() > 0.5 * tension


def test_a_tension_that_is_given_draws_every_place_together_as_far_as_its_skin_gives_way(tmp_path: Path) -> None:
    thread = running(STATIONS, depth=2.0).suture("running", 1, 0.4, thread="nylon 4-0", tension=20.0)
    frame = closed([thread], tmp_path)
    assert frame.suture_forces[0] == pytest.approx(20.0, rel=1e-3)
    wide, still = np.array([at.gap for at in STATIONS]), gaps(frame)
    assert (still[1:-1] > 0.1).all()
    assert (wide - still > 0.3 * wide).all()
