"""Write the procedure of a scene, and the frames that are solved of it, as USD files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.skin_cache import write_skin_cache
from lappet.procedure import Procedure
from lappet.program.keys import frame_keys
from lappet.program.program import Program
from lappet.solve.store import FrameStore
from lappet.usd.stage import SUFFIXES, write_procedure

from ..model.scene_procedure import read_scene
from ..model.scenery_values import scenery_values
from ..solving import reconcile
from ..solving.solve_settings import frame_store, solve_settings
from .bundled_pxr import bundled_pxr


def procedure_of(scene: bpy.types.Scene) -> Procedure:
    """The procedure that a scene holds; raises RefusedError with what stands in the way."""
    reading = read_scene(scene)
    if reading.procedure is None:
        raise RefusedError([each for each in reading.problems if each.severity == "error"])
    return reading.procedure


def write_scene(scene: bpy.types.Scene, path: Path) -> None:
    """Write the procedure of a scene to a .usda, .usdc or .usd file; events that are off are left out.

    Raises RefusedError where it cannot be written as USD, OSError where the file system refuses.
    """
    bundled_pxr()
    write_procedure(replace(procedure_of(scene), scenery=scenery_values(scene)), path)


def write_cache(scene: bpy.types.Scene, path: Path) -> Path:
    """Write the solved frames of a scene as a skin cache, and its procedure beside it; return the procedure's file.

    Nothing is solved: raises RefusedError where a frame is not, as for a file that cannot be written. OSError where the
    file system refuses.
    """
    bundled_pxr()

    if path.suffix not in SUFFIXES:
        raise refused(ProblemCode.USD_SUFFIX, path, path.suffix, name=path.name, known=", ".join(SUFFIXES))
    procedure = procedure_of(scene)
    program = compiled(scene, procedure)
    keys = frame_keys(program, reconcile.identity())
    frames = _stored(program, keys, frame_store(scene))
    beside = path.with_suffix(".procedure.usda")
    write_procedure(replace(procedure, scenery=scenery_values(scene)), beside)
    write_skin_cache(path, beside, procedure, program, frames, keys[-1])
    return beside


def compiled(scene: bpy.types.Scene, procedure: Procedure, spacing: float | None = None) -> Program:
    """The program of a procedure with the settings of a scene's Solve panel."""
    from lappet.program.compile import compile_program

    return compile_program(procedure, settings=replace(solve_settings(scene), spacing=spacing or 0.0))


def _stored(program: Program, keys: tuple[str, ...], store: FrameStore) -> list[SolvedFrame]:
    found, missing = [], []
    for constraints, key in zip(program.frames, keys, strict=True):
        stored = store.get(key, SolvedFrame)
        if stored is None:
            missing.append(round(constraints.time))
        else:
            found.append(stored)
    if missing:
        raise refused(ProblemCode.FRAMES_NOT_SOLVED, "", missing[0], count=len(missing))
    return found
