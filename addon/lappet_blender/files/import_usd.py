"""Read a procedure, or a skin cache with its frames, into a scene."""

from __future__ import annotations

import hashlib
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from lappet.anatomy.tissue_layers import layer_search
from lappet.background.make_manifest import epoch_shapes, make_manifest
from lappet.background.manifest import Manifest
from lappet.background.manifest_store import put_manifest
from lappet.core.problem import Problem, RefusedError, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.solved_frame import SolvedFrame
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import SCALARS, FigureError
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.procedure import Procedure
from lappet.program.keys import frame_keys
from lappet.usd.procedure_file import CHILD
from lappet.usd.stage_contents import StageContents
from lappet.usd.stage_procedure import StageProcedure

from ..model.scene_filling import fill_scene
from ..solving import reconcile
from ..solving.controller import controller_of, frame_cache
from .bundled_pxr import bundled_pxr
from .export_usd import compiled


@dataclass(frozen=True, eq=False)
class FoundFile:
    """A USD file as a child process read it: the procedure, and the skin cache over it if that is what was given."""

    path: Path
    read: StageProcedure
    cache: Path | None = None
    spacing: float | None = None
    last_key: str = ""


@dataclass(frozen=True, eq=False)
class CacheFrames:
    """The frames of a skin cache. exact: they are what this solver would give for the file's procedure."""

    manifest: Manifest
    frames: dict[str, SolvedFrame]
    exact: bool


def look_into(path: Path, limits: ReadLimits = DEFAULT_LIMITS) -> FoundFile:
    """What a USD file holds. Raises RefusedError where it cannot be opened, or takes more than it may.

    A child process reads it, and all values of a skin cache too; only then Blender's own process opens the cache.
    """
    bundled_pxr()  # so that the child finds it where this process does
    with ReadingProcess(CHILD, "contents", path, limits) as process:
        contents: StageContents = process.result(StageContents)
    if contents.skin is None:
        return FoundFile(path, contents.read)
    spacing = contents.skin.spacing
    return FoundFile(path, contents.read, path, spacing if math.isfinite(spacing) else None, contents.skin.last_key)


def read_into(scene: bpy.types.Scene, found: FoundFile) -> list[Problem]:
    """Put the procedure of a USD file into a scene in place of what it had; of a skin cache the frames as well.

    Returns a note of everything that was converted or left aside. Raises RefusedError, with the
    scene as it was.
    """
    procedure = found.read.procedure
    if procedure is None or found.read.problems:
        raise RefusedError(found.read.problems)
    notes = list(found.read.notes)
    notes += fill_scene(scene, procedure, _collection(scene, found.path.stem))
    if found.cache is not None:
        notes.append(_show(scene, procedure, found))
    return notes


def _collection(scene: bpy.types.Scene, name: str) -> bpy.types.Collection:
    collection = bpy.data.collections.new(name)
    scene.collection.children.link(collection)
    return collection


def _show(scene: bpy.types.Scene, procedure: Procedure, found: FoundFile) -> Problem:
    """Give the frames of a cache to the solving side, and say which they are."""
    try:
        read = cache_frames(scene, procedure, found)
    except RefusedError as refused:
        return problem(ProblemCode.CACHE_NOT_SHOWN, "", " ".join(str(each) for each in refused.problems))
    except (FigureError, OSError) as error:
        return problem(ProblemCode.CACHE_NOT_SHOWN, "", error)
    controller = controller_of(scene)
    for key, frame in read.frames.items():
        frame_cache.put(key, frame)
        if not read.exact:  # under keys of their own: what lies under a solver's key must hold its state too
            controller.store.put(key, frame)
    if not read.exact:
        put_manifest(controller.store, read.manifest)
    controller.past.append(read.manifest)
    controller.recheck_frames(read.manifest)
    controller.mark_dirty()
    times = [frame.time for frame in read.manifest.frames if frame.key in read.frames]
    code = ProblemCode.CACHE_SHOWN if read.exact else ProblemCode.CACHE_SHOWN_ONLY
    return problem(code, "", f"{times[0]} to {times[-1]}")


def cache_frames(scene: bpy.types.Scene, procedure: Procedure, found: FoundFile) -> CacheFrames:
    """The frames of a skin cache as they are shown.

    Raises RefusedError where its surfaces are not those that this Lappet cuts, FigureError for a damaged cache.
    """
    assert found.cache is not None
    cache = SkinCache(found.cache)
    program = compiled(scene, procedure, found.spacing)
    search = layer_search(procedure.tissue, procedure.materials)
    shapes = epoch_shapes(program.epochs, procedure.tissue, search)
    shape_at = {epoch.index: shape for epoch, shape in zip(program.epochs, shapes, strict=True)}
    times = {round(frame.time): i for i, frame in enumerate(program.frames)}
    indices = {time: times[round(time)] for time in cache.frames if round(time) in times}
    if not indices:
        raise refused(ProblemCode.CACHE_NO_FRAME)
    for epoch in cache.epochs:
        shape = shape_at.get(int(epoch.name.rpartition("_")[2]))
        if shape is None or not np.array_equal(shape.triangles, epoch.triangles):
            raise refused(ProblemCode.CACHE_OTHER_CUT)
    last = max(indices)
    try:
        keys = frame_keys(program, reconcile.identity())
    except RefusedError:
        keys = ()
    exact = bool(keys) and keys[indices[last]] == found.last_key
    if not exact:
        own = hashlib.blake2b(f"{found.last_key} {last:g}".encode() + found.cache.read_bytes(), digest_size=16)
        keys = tuple(f"{own.hexdigest()}{i:08x}" for i in range(len(program.frames)))
    manifest_key = hashlib.blake2b("imported".join(keys).encode(), digest_size=32).hexdigest()
    manifest = make_manifest(manifest_key, program, keys, shapes, search.layers)
    frames: dict[str, SolvedFrame] = {}
    for time, index in indices.items():
        epoch, listed = cache.epoch_at(time), manifest.frames[index]
        scalars: dict[str, Any] = {
            name: values for name in SCALARS if (values := cache.scalar(epoch, name, time)) is not None
        }
        hooks, sutures = np.array(listed.hooks, np.int32), np.array(listed.sutures, np.int32)
        threads = cache.threads(time)
        inner = [threads[i][1:-1] if i in threads else np.zeros((0, 3)) for i in listed.sutures]
        landmarks = np.array(manifest.landmarks_at[listed.epoch], np.int32)
        frames[listed.key] = SolvedFrame(
            float(time),
            np.ascontiguousarray(cache.positions(epoch, time), np.float32),
            **scalars,
            landmark_index=landmarks,
            landmarks=cache.landmarks(time)[landmarks].astype(np.float64),
            vessel_points=cache.vessel_points(time),
            hook_index=hooks,
            hook_points=cache.hooks(time).ends[hooks, 0].astype(np.float64),
            suture_index=sutures,
            suture_points=cache.sutures(time).ends[sutures].astype(np.float64),
            suture_inner_bites=np.array([len(each) for each in inner] if threads else [], np.int32),
            inner_bite_points=np.concatenate([np.zeros((0, 3)), *inner]),
        )
    return CacheFrames(manifest, frames, exact)
