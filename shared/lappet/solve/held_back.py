"""Hooks that end short of their targets where tissue touches tissue: with self-contact it may be in their way."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.geometry.axis_rays import AxisRays
from lappet.geometry.normals import vertex_normals
from lappet.geometry.self_overlap import winding_numbers
from lappet.geometry.surface_check import place
from lappet.program.program import Program
from lappet.solve.contact_reach import contact_reach
from lappet.solve.solve_frames import FrameResult

SHORT = 1.0
"""Chosen: a hook is short where it ends farther than this many lattice spacings from its target."""
AROUND = 5.0
"""Chosen: tissue touches near a hook within this many lattice spacings of it."""


class _Short(NamedTuple):
    missing: float
    frame: FrameResult
    at: NDArray[np.float64]


def held_back_notes(program: Program, frames: Sequence[FrameResult]) -> list[Problem]:
    """Find the hooks that tissue may hold back.

    Parameters
    ----------
    program
        The program.
    frames
        Its solved frames.

    Returns
    -------
    list[Problem]
        With self-contact a note for each hook that ends short of its target while tissue touches tissue near it, in the
        frame in which it is shortest: by how much, and the touching place nearest to it at rest and in the frame.
    """
    if not program.settings.self_contact:
        return []
    found = ((name, _touching(program, short)) for name, short in _shortest(program, frames).items())
    return [_note(program, name, *each) for name, each in found if each is not None]


def _shortest(program: Program, frames: Sequence[FrameResult]) -> dict[str, _Short]:
    """By hook, the frame in which it ends farthest from its target while tissue touches."""
    found: dict[str, _Short] = {}
    for frame in frames:
        if not frame.solved.diagnostics.self_contacts:
            continue
        targets = dict(zip(frame.constraints.hook_index.tolist(), frame.constraints.hook_targets, strict=True))
        for index, at in zip(frame.solved.hook_index.tolist(), frame.solved.hook_points, strict=True):
            name, missing = program.hooks[index], float(np.linalg.norm(targets[index] - at))
            if missing > SHORT * program.settings.spacing and missing > found.get(name, _Short(0.0, frame, at)).missing:
                found[name] = _Short(missing, frame, at)
    return found


def _touching(program: Program, short: _Short) -> tuple[_Short, int] | None:
    """The vertex nearest to the hook that touches tissue and did not at rest; None where there is none near it."""
    epoch = next(each for each in program.epochs if each.index == short.frame.constraints.epoch)
    points, triangles = np.asarray(short.frame.solved.points, np.float64), epoch.surface.triangles
    away = np.linalg.norm(points - short.at, axis=1)
    near = np.flatnonzero(away < AROUND * program.settings.spacing)
    ahead = contact_reach(program.settings.spacing)
    for surface, wanted in ((points, True), (np.asarray(epoch.surface.points, np.float64), False)):
        beyond = surface[near] + ahead * vertex_normals(surface, triangles)[near]
        near = near[(winding_numbers(AxisRays(surface, triangles, 2), beyond) > 0) == wanted]
    return (short, int(near[np.argmin(away[near])])) if len(near) else None


def _note(program: Program, name: str, short: _Short, vertex: int) -> Problem:
    epoch = next(each for each in program.epochs if each.index == short.frame.constraints.epoch)
    rest, now = (np.asarray(points[vertex], float) for points in (epoch.surface.points, short.frame.solved.points))
    return problem(
        ProblemCode.HOOK_HELD_BACK,
        f"/Procedure/Timeline/{name}",
        f"{short.missing:.2g}",
        place=Place.at(rest),
        time=short.frame.constraints.time,
        where=place(np.round(rest, 2)),
        now=place(np.round(now, 2)),
    )
