"""An advancement flap whose forces are measured, 10 x 18 mm for a defect of 10 x 8 mm; and tissue that is turned."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Event, Excision, Hook, Incision, Material, Point, Procedure, Suture, Undermine
from lappet.program.program import Program
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.patch import flat_patch

TOP = 3.0  # thickness of the skin in mm


def advancement(depth: float, top: float = TOP, **changes: Any) -> Procedure:
    """Sutures in this depth, 0.6 mm beside the edges, in skin so thick."""
    corners = [(-14.0, -5.0, top), (-6.0, -5.0, top), (-6.0, 5.0, top), (-14.0, 5.0, top)]
    around = [(-20.0, -12.0, top), (16.0, -12.0, top), (16.0, 12.0, top), (-20.0, 12.0, top)]
    events: list[Any] = [
        Incision("defect", 2, tuple(corners), closed=True),
        *(Incision(f"limb_{k}", 2, ((-6.0, y, top), (12.0, y, top))) for k, y in enumerate((5.0, -5.0))),
        Excision("excision", 2, ((-10.0, 0.0, top),)),
        Undermine("undermining", 2, tuple(around)),
    ]
    z = top - depth
    for k, y in enumerate((-4.0, -4.0 / 3.0, 4.0 / 3.0, 4.0)):
        events.append(Suture(f"front_{k}", ((-5.4, y, z), (-14.6, y, z)), 2, 2, **changes))
    for k, along in enumerate((3.0, 6.0, 9.0, 12.0, 15.0)):
        for side, y in (("left", 1.0), ("right", -1.0)):
            ends = ((-6.0 + along, 4.4 * y, z), (-14.0 + along * 26 / 18, 5.6 * y, z))
            events.append(Suture(f"{side}_{k}", ends, 2, 2, **changes))
    tissue = flat_patch((56.0, 40.0, top), resolution=2.0, gravity=0.0, bed_stiffness=10.0, bed_shear=10.0)
    return Procedure(tissue, (Material("skin"),), events=tuple(events), start_time=2, end_time=4)


def turned(procedure: Procedure, turn: NDArray[np.float64]) -> Procedure:
    """The procedure with everything in it turned, (3, 3), while the lattice stays along the axes."""

    def at(point: Sequence[float]) -> Point:
        x, y, z = turn @ np.asarray(point, np.float64)
        return (float(x), float(y), float(z))

    points = (np.asarray(procedure.tissue.points) @ turn.T).astype(np.float32).astype(np.float64)
    tissue = replace(procedure.tissue, points=points, gravity_direction=at(procedure.tissue.gravity_direction))
    materials = tuple(replace(each, fiber_direction=at(each.fiber_direction)) for each in procedure.materials)
    events = tuple(_turned(event, at) for event in procedure.events)
    return replace(procedure, tissue=tissue, materials=materials, events=events)


def _turned(event: Event, at: Callable[[Sequence[float]], Point]) -> Event:
    match event:
        case Incision() | Undermine():
            return replace(event, points=tuple(map(at, event.points)))
        case Excision():
            return replace(event, seeds=tuple(map(at, event.seeds)))
        case Suture():
            return replace(event, anchors=tuple(map(at, event.anchors)))
        case Hook():
            targets = tuple((time, at(target)) for time, target in event.targets)
            return replace(event, anchor=at(event.anchor), targets=targets)
    raise TypeError(event.kind)


def last_frame(program: Program, folder: Path, **settings: Any) -> SolvedFrame:
    """The last frame of a program with other settings."""
    program = replace(program, settings=replace(program.settings, **settings))
    found = solve_program(program, FrameStore(folder), connect_to(None), solver_identity(None), SolveObserver())
    assert found.reason is None
    return found.frames[-1].solved


def shifted(program: Program, folder: Path, spacing: float, shift: Sequence[float] = (0.0, 0.0, 0.0)) -> SolvedFrame:
    """The last frame on a lattice that is shifted by so many cells."""
    place = np.array(program.settings.origin) + spacing * np.asarray(shift)
    return last_frame(program, folder, spacing=spacing, origin=tuple(place.tolist()))
