"""Solve scenes at the default settings and to 1e-8 in double precision, and compare the frames.

Both run from frame to frame on their own, as a user's solve does.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lappet.daemon.client import SolverClient
from lappet.daemon.solved_frame import SolvedFrame
from lappet.program.program import Program
from lappet.reports.convergence.scenes import ConvergenceScene, FlapScene

EXACT: dict[str, Any] = {"tolerance": 1e-8, "precision": "double", "max_newton": 400}
NEAR = 0.05  # mm, or spacings of a coarser lattice


@dataclass(frozen=True)
class ConvergenceRow:
    """A frame at the default settings beside the exact one.

    Parameters
    ----------
    kind
        What happens in the scene.
    scene
        Name of the scene.
    frame
        Time code.
    spacing_mm
        Lattice spacing.
    converged
        Whether it converged, and the exact one did.
    reason
        Why not, a sentence.
    moved_mm
        Largest displacement of the exact frame.
    error_mm
        Largest distance between the two.
    allowed_mm
        What it may be.
    to_come_mm
        What the frame itself says is still to come.
    newton
        Newton iterations.
    newton_exact
        Newton iterations of the exact frame.
    seconds
        Time of the frame at the default settings.
    ok
        Whether it converged and the error is allowed.
    """

    kind: str
    scene: str
    frame: float
    spacing_mm: float
    converged: bool
    reason: str
    moved_mm: float
    error_mm: float
    allowed_mm: float
    to_come_mm: float
    newton: int
    newton_exact: int
    seconds: float
    ok: bool


def solve_all(program: Program) -> list[tuple[SolvedFrame, float]]:
    """Solve every frame of a program, also after one that does not converge.

    Parameters
    ----------
    program
        The program.

    Returns
    -------
    list[tuple[SolvedFrame, float]]
        The frames and their seconds.
    """
    solved = []
    at = None
    with SolverClient() as client:
        client.open(program.settings, program.bones)
        for frame in program.frames:
            if frame.epoch != at:
                at = frame.epoch
                index = next(i for i, epoch in enumerate(program.epochs) if epoch.index == at)
                client.set_epoch(program.epochs[index], program.grips[index], program.landmarks_at[index])
            begun = time.perf_counter()
            solved.append((client.solve(frame), time.perf_counter() - begun))
    return solved


def compare(scene: ConvergenceScene, **settings: Any) -> list[ConvergenceRow]:
    """Compare the frames of a scene with the exact ones.

    Parameters
    ----------
    scene
        The scene.
    **settings
        Fields of `SolverSettings` that are not the default, for both.

    Returns
    -------
    list[ConvergenceRow]
        A row for each frame.
    """
    program = scene.program(**settings)
    found = solve_all(program)
    right = solve_all(replace(program, settings=replace(program.settings, **EXACT)))
    allowed = NEAR * max(1.0, scene.spacing)
    rows = []
    for constraints, (frame, seconds), (exact, _) in zip(program.frames, found, right, strict=True):
        rest = next(epoch for epoch in program.epochs if epoch.index == constraints.epoch).surface.points
        error = _largest(frame.points.astype(np.float64) - exact.points)
        converged = frame.converged and exact.converged
        rows.append(
            ConvergenceRow(
                kind=scene.kind,
                scene=scene.name,
                frame=frame.time,
                spacing_mm=scene.spacing,
                converged=converged,
                reason=frame.reason or exact.reason,
                moved_mm=_largest(exact.points - rest),
                error_mm=error,
                allowed_mm=allowed,
                to_come_mm=frame.diagnostics.displacement_to_come,
                newton=frame.diagnostics.newton,
                newton_exact=exact.diagnostics.newton,
                seconds=seconds,
                ok=converged and error <= allowed,
            )
        )
    return rows


def compare_twins(one: FlapScene, two: FlapScene, **settings: Any) -> list[ConvergenceRow]:
    """Compare the tips of the flaps of two scenes, the second of which has more of the same flaps.

    Parameters
    ----------
    one
        A scene of a flap alone.
    two
        The same with more flaps, in the same patch.
    **settings
        Fields of `SolverSettings` that are not the default.

    Returns
    -------
    list[ConvergenceRow]
        A row for each frame; what is called exact is the flap alone.
    """
    rows = []
    for (alone, _), (frame, seconds) in zip(
        solve_all(one.program(**settings)), solve_all(two.program(**settings)), strict=True
    ):
        moved = alone.landmarks - np.array((*one.flaps[0], 0.0))
        middles = np.column_stack([np.array(two.flaps), np.zeros(len(two.flaps))])
        error = _largest(frame.landmarks - middles - moved)
        allowed = NEAR * max(1.0, two.spacing)
        converged = frame.converged and alone.converged
        rows.append(
            ConvergenceRow(
                kind="twins",
                scene=two.name,
                frame=frame.time,
                spacing_mm=two.spacing,
                converged=converged,
                reason=frame.reason or alone.reason,
                moved_mm=float("nan"),
                error_mm=error,
                allowed_mm=allowed,
                to_come_mm=frame.diagnostics.displacement_to_come,
                newton=frame.diagnostics.newton,
                newton_exact=alone.diagnostics.newton,
                seconds=seconds,
                ok=converged and error <= allowed,
            )
        )
    return rows


def run_scenes(
    scenes: Iterable[ConvergenceScene], say: Callable[[str], None] = lambda _: None
) -> Iterator[ConvergenceRow]:
    """Compare scene after scene.

    Parameters
    ----------
    scenes
        The scenes.
    say
        Is told of every scene.

    Yields
    ------
    ConvergenceRow
        The rows of each.
    """
    for scene in scenes:
        rows = compare(scene)
        worst = max(row.error_mm for row in rows)
        reasons = " ".join(row.reason for row in rows if row.reason)
        right = all(row.ok for row in rows)
        say(f"{'ok ' if right else 'NOT'} {scene.name}: {worst:.3g} mm off at most. {reasons}".rstrip())
        yield from rows


def _largest(vectors: Any) -> float:
    return float(np.linalg.norm(vectors, axis=-1).max(initial=0.0))
