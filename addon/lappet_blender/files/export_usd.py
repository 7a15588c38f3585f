"""Writes the procedure of a scene, and the frames that are solved of it, as USD files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from lappet.core.problem import RefusedError

from ..model.scene_procedure import read_scene
from ..solving import reconcile
from ..solving.solve_settings import frame_store, solve_settings
from .bundled_pxr import bundled_pxr

if TYPE_CHECKING:
    from lappet.procedure import Procedure
    from lappet.program.program import Program
    from lappet.solve.store import FrameStore, StoredFrame


def procedure_of(scene: bpy.types.Scene) -> Procedure:
    """The procedure that a scene holds; raises RefusedError with what stands in the way."""
    reading = read_scene(scene)
    if reading.procedure is None:
        first = next((each for each in reading.problems if each.severity == "error"), None)
        raise RefusedError("The scene holds no procedure." if first is None else f"{first.message} {first.remedy}")
    return reading.procedure


def write_scene(scene: bpy.types.Scene, path: Path) -> None:
    """Writes the procedure of a scene to a .usda, .usdc or .usd file; events that are off are left out.

    Raises RefusedError where it cannot be written as USD, OSError where the file system refuses.
    """
    bundled_pxr()
    from lappet.usd.stage import write_procedure

    write_procedure(procedure_of(scene), path)


def write_cache(scene: bpy.types.Scene, path: Path) -> Path:
    """Writes the solved frames of a scene as a skin cache, and its procedure beside it; returns the procedure's file.

    Nothing is solved: raises RefusedError where a frame is not, as for a file that cannot be written. OSError where the
    file system refuses.
    """
    bundled_pxr()
    from lappet.output.skin_cache import write_skin_cache
    from lappet.program.keys import frame_keys
    from lappet.solve.solve_frames import FrameResult
    from lappet.usd.stage import SUFFIXES, write_procedure

    if path.suffix not in SUFFIXES:
        raise RefusedError(f"{path.name} does not end in a USD suffix; name it {', '.join(SUFFIXES)}.")
    procedure = procedure_of(scene)
    program = compiled(scene, procedure)
    found = _stored(program, frame_keys(program, reconcile.identity()), frame_store(scene))
    frames = [
        FrameResult(constraints, key, stored.header, dict(stored.arrays), True, 0.0)
        for constraints, (key, stored) in zip(program.frames, found, strict=True)
    ]
    beside = path.with_suffix(".procedure.usda")
    write_procedure(procedure, beside)
    write_skin_cache(path, beside, procedure, program, frames)
    return beside


def compiled(scene: bpy.types.Scene, procedure: Procedure, spacing: float | None = None) -> Program:
    """The program of a procedure with the settings of a scene's Solve panel."""
    from lappet.program.compile import compile_program

    settings = solve_settings(scene)
    return compile_program(
        procedure,
        spacing=settings.spacing if spacing is None else spacing,
        tolerance=settings.tolerance,
        quadrature=settings.quadrature,
        precision=settings.precision,
    )


def _stored(program: Program, keys: tuple[str, ...], store: FrameStore) -> list[tuple[str, StoredFrame]]:
    found, missing = [], []
    for constraints, key in zip(program.frames, keys, strict=True):
        stored = store.get(key)
        if stored is None:
            missing.append(round(constraints.time))
        else:
            found.append((key, stored))
    if missing:
        which = f"Frame {missing[0]} is" if len(missing) == 1 else f"{len(missing)} frames, from {missing[0]} on, are"
        raise RefusedError(f"{which} not solved as the procedure is now; press Solve, then export again.")
    return found
