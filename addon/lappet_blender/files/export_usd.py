"""Write the procedure of a scene, and the frames that are solved of it, as USD files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.skin_cache import write_skin_cache
from lappet.procedure import Procedure, Scenery
from lappet.program.keys import frame_keys
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
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


@dataclass(frozen=True, eq=False)
class CacheRequest:
    """What a skin cache is written from: values without Blender, so that a thread may write it."""

    procedure: Procedure
    settings: SolverSettings
    identity: str
    store: FrameStore
    scenery: tuple[Scenery, ...]


def cache_request(scene: bpy.types.Scene) -> CacheRequest:
    """Gather what the skin cache of a scene is written from; raises RefusedError where it holds no procedure."""
    procedure = procedure_of(scene)
    return CacheRequest(
        procedure, solve_settings(scene), reconcile.identity(), frame_store(scene), scenery_values(scene)
    )


def write_cache(scene: bpy.types.Scene, path: Path) -> Path:
    """Write the solved frames of a scene as a skin cache, and its procedure beside it; return the procedure's file.

    Nothing is solved: raises RefusedError where a frame is not, as for a file that cannot be written. OSError where the
    file system refuses.
    """
    bundled_pxr()
    return write_request(cache_request(scene), path)


def write_request(request: CacheRequest, path: Path) -> Path:
    """Write a skin cache as `write_cache` does; Blender's USD must be loaded already."""
    from lappet.program.compile import compile_program

    if path.suffix not in SUFFIXES:
        raise refused(ProblemCode.USD_SUFFIX, path, path.suffix, known=", ".join(SUFFIXES))
    program = compile_program(request.procedure, settings=replace(request.settings, spacing=0.0))
    keys = frame_keys(program, request.identity)
    frames = _stored(program, keys, request.store)
    beside = path.with_suffix(".procedure.usda")
    write_procedure(replace(request.procedure, scenery=request.scenery), beside)
    write_skin_cache(path, beside, request.procedure, program, frames, keys[-1])
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
