"""A box that is fixed below and pulled above, as a session is told of it; and a solve of one that lasts."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Epoch
from lappet.daemon.client import SolverClient
from lappet.daemon.frame_solver import Iteration
from lappet.geometry.labeled_surface import Surface
from lappet.program.program import FrameConstraints
from lappet.program.settings import SolverSettings


def box(size: tuple[float, float, float] = (4.0, 4.0, 2.0)) -> Surface:
    """A closed box, fixed below."""
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float) * size
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    m = len(triangles)
    below = np.isin(np.arange(m), (8, 9))
    return Surface(
        points, triangles, np.zeros((m, 3, 2), np.float32), np.zeros(m, np.uint8), below, np.zeros(m, np.bool_)
    )


def pull(time_code: float = 1.0, by: float = 0.2) -> FrameConstraints:
    """A hook on the upper face of the box, drawn upwards."""
    return FrameConstraints(
        time_code,
        0,
        hook_index=np.zeros(1, np.int32),
        hook_anchors=np.array([[2.0, 1.0, 2.0]]),
        hook_triangles=np.array([10], np.int32),
        hook_targets=np.array([[2.0, 1.0, 2.0 + by]]),
        hook_stiffness=np.array([10.0]),
    )


def epoch_arrays(**changes: Any) -> dict[str, NDArray[Any]]:
    surface = box()
    m = len(surface.triangles)
    arrays = {
        "points": surface.points,
        "triangles": surface.triangles,
        "fixed": surface.fixed.astype(np.uint8),
        "support": surface.bed.astype(np.uint8),
        "grip": np.full(m, -1, np.int32),
        "landmarks": np.zeros((0, 3)),
        "landmark_triangles": np.zeros(0, np.int32),
        **changes,
    }
    return {name: array for name, array in arrays.items() if array is not None}


def open_fields(**changes: Any) -> dict[str, Any]:
    settings = {
        "spacing": 1.0, "fine_ratio": 4, "origin": [0.0, 0.0, 0.0], "quadrature": 1, "precision": "float",
        "tolerance": 1e-3, "gap_tolerance": 1e-3, "max_newton": 100,
        "bed_stiffness": 10.0, "bed_shear": 10.0, "gravity": [0.0, 0.0, 0.0],
        "time_budget": 0.0, "memory_budget": 1 << 30, "threads": 1, "sutures": 2, "retractors": 0,
    }  # fmt: skip
    material = {"model": "neoHookean", "youngs_modulus": 50.0, "poissons_ratio": 0.45, "density": 1100.0}
    return {"settings": {**settings, **changes}, "materials": [material]}


@contextlib.contextmanager
def long_solve(client: SolverClient) -> Iterator[FrameConstraints]:
    """Prepares a solve that lasts for many seconds: a tolerance that no arithmetic reaches, on 8 000 cells."""
    size = (24.0, 24.0, 6.0)
    client.open(SolverSettings(spacing=0.75, precision="double", tolerance=1e-12, max_newton=1000, threads=1))
    client.set_epoch(Epoch(0, 1.0, box(size), 1))
    yield FrameConstraints(
        1.0,
        0,
        hook_index=np.zeros(1, np.int32),
        hook_anchors=np.array([[12.0, 6.0, 6.0]]),
        hook_triangles=np.array([10], np.int32),
        hook_targets=np.array([[20.0, 12.0, 14.0]]),
        hook_stiffness=np.array([500.0]),
    )


class Started:
    """Runs an action once the solve has reported progress, from another thread."""

    def __init__(self, action: Callable[[], object]) -> None:
        self.action = action
        self.at = 0.0
        self.iterations: list[Iteration] = []

    def __call__(self, iteration: Iteration) -> None:
        self.iterations.append(iteration)
        if len(self.iterations) == 1:
            self.at = time.monotonic()
            threading.Thread(target=self.action).start()
