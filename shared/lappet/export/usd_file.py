"""`lappet export CACHE.usdc -o X.usdc`: USD without the procedure, dressed, for programs that only show it.

What is planned and what is measured is not there, and threads and hooks are meshes: Blender's importer gives curves no
material. Beside the file lie the pictures of its looks, a layer with camera, lights and background, and, where that is
asked for, what moves, in a file for each step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError, SkinEpoch
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache, exported_frames
from lappet.export.moving_shape import MovingShape
from lappet.export.moving_skin import grid_scale
from lappet.export.moving_tubes import instrument_shapes
from lappet.export.usd_pictures import SkinPicture, check_picture, picture_files, show_picture, write_pictures
from lappet.export.usd_steps import StepFiles, lasting, refer_to_steps, write_steps
from lappet.export.usd_studio import write_studio
from lappet.geometry.vectors import bounds
from lappet.output.drawn_instruments import ROOT as INSTRUMENTS
from lappet.output.drawn_instruments import add_variants
from lappet.output.dressed_cache import MEASURED, PLANS, TABLES, is_tissue
from lappet.output.named_steps import operation_steps
from lappet.output.preview_materials import LOOK_ROOT, SKIN_ROOT, bind, full_strain, write_look_variants
from lappet.output.shown_frames import show_at
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr, save_layer

_NAMES = {"threads": "Threads", "hooks": "SkinHooks"}
_KEPT = ("Steps",)  # of the tables: they are what the operation is told by
_SCENE_FPS = 24.0  # of a new scene in Blender, whose importer takes a time code as a frame of the scene


def write_usd(request: ExportRequest) -> list[Path]:
    """Write a solved procedure as USD that needs no procedure.

    Parameters
    ----------
    request
        The cache, the file and the options `one_file`, `photo`, `fps` and `step_files`.

    Returns
    -------
    list[Path]
        The file, and unless it is to be alone its pictures, the layer of its studio and the files of its steps.

    Raises
    ------
    RefusedError
        If the cache cannot be read or shown, or is the file itself, the picture is none, or what moves is to be both in
        files of its own and not.
    OSError
        If a file cannot be written.
    """
    photo: Path | None = request.options.get("photo")
    alone = bool(request.options.get("one_file"))
    if alone and request.options.get("step_files"):
        raise refused(ProblemCode.EXPORT_STEP_FILES, request.target, "--one-file")
    if photo is not None:
        check_picture(photo)
    cache = exported_cache(request.caches[0], request.limits)
    if request.target.resolve() == cache.path.resolve():
        raise refused(ProblemCode.EXPORT_ITSELF, request.target, cache.path)
    frames = exported_frames(cache, request)
    try:
        shapes = instrument_shapes(cache, frames)
        steps = [step.frame for step in operation_steps(cache)]
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    pictures = [] if alone else write_pictures(request.target, grid_scale(cache), photo)
    rate = scene_rate(cache.fps) if request.options.get("fps") is None else float(request.options["fps"])
    divided = None
    if request.options.get("step_files"):
        frame_bytes = cache.path.stat().st_size / len(cache.frames)
        divided = StepFiles.of(request.target, cache.frames, steps, frame_bytes)
    layer = _layer(cache, shapes, pictures, rate, divided)
    studio = request.target.with_name(f"{request.target.stem}_studio.usda")
    if not alone:
        write_studio(cache, steps or cache.frames[-1:], studio)
        layer.subLayerPaths.insert(0, f"./{studio.name}")
    layer.comment = "Written by lappet export from a skin cache."
    save_layer(layer, request.target)
    beside = [] if alone else [studio, *picture_files(request.target, pictures)]
    return [request.target, *beside, *(divided.files if divided else ())]


def scene_rate(fps: float) -> float:
    """Choose the time codes in a second: those of a new scene in Blender, where frames fall on whole ones of them.

    Parameters
    ----------
    fps
        Frames in a second of the cache.

    Returns
    -------
    float
        24, or the cache's own.
    """
    times = _SCENE_FPS / fps
    return _SCENE_FPS if times >= 1.0 and math.isclose(times, round(times)) else fps


def _layer(
    cache: SkinCache, shapes: Sequence[MovingShape], pictures: list[SkinPicture], rate: float, steps: StepFiles | None
) -> Any:
    """The stage of one layer: flat, without what is planned and measured, with its looks; steps have what moves."""
    usd = pxr()
    layer = _flat(cache, rate, lasting(cache) if steps else cache.stage.GetRootLayer())
    stage = usd.Usd.Stage.Open(layer)
    for path in (*PLANS, *(f"{SKIN_ROOT}/{name}" for name in (*TABLES, *MEASURED) if name not in _KEPT)):
        stage.RemovePrim(path)
    times = rate / cache.fps
    for shape in shapes:
        _write_mesh(stage, shape, cache.frames, times)
    _retime_steps(stage, times)
    _names_as_tokens(layer)
    if stage.GetPrimAtPath(INSTRUMENTS):
        add_variants(stage)
    strain = _strain(cache, times) if stage.GetPrimAtPath(f"{LOOK_ROOT}/Skin") else {}
    full = full_strain(strain) if strain else None
    if stage.GetPrimAtPath(f"{LOOK_ROOT}/Skin"):
        shown = {each.look: _shows(stage, each, ".." if steps else ".") for each in pictures}
        _write_looks(stage, {name: {} for name in strain} if steps else strain, shown, full)
    if steps is None:
        return layer
    write_steps(cache, steps, times, full)
    save_layer(layer, steps.lasting)
    return refer_to_steps(layer, cache, steps, times)


def _flat(cache: SkinCache, rate: float, own: Any) -> Any:
    """The cache and its procedure as one layer; USD moves the samples where time codes are others."""
    usd = pxr()
    root = usd.Sdf.Layer.CreateAnonymous(".usda")
    root.subLayerPaths = [own.identifier]
    stage = usd.Usd.Stage.Open(root)
    own = cache.stage
    stage.SetTimeCodesPerSecond(rate)
    stage.SetFramesPerSecond(rate)
    times = rate / cache.fps
    stage.SetStartTimeCode(own.GetStartTimeCode() * times)
    stage.SetEndTimeCode(own.GetEndTimeCode() * times)
    usd.UsdGeom.SetStageMetersPerUnit(stage, usd.UsdGeom.GetStageMetersPerUnit(own))
    usd.UsdGeom.SetStageUpAxis(stage, usd.UsdGeom.GetStageUpAxis(own))
    root.defaultPrim = "Procedure"
    return stage.Flatten()


def _names_as_tokens(layer: Any) -> None:
    """Write names of things, arrays of strings in the cache, as arrays of tokens: not all readers know the others."""
    usd = pxr()
    types, named = usd.Sdf.ValueTypeNames, []

    def find(path: Any) -> None:
        spec = layer.GetAttributeAtPath(path) if path.IsPrimPropertyPath() else None
        if spec is not None and spec.typeName == types.StringArray:
            named.append(spec)

    layer.Traverse("/", find)
    for spec in named:
        prim, name, kept = spec.owner, spec.name, {key: spec.GetInfo(key) for key in spec.ListInfoKeys()}
        del prim.properties[name]
        fresh = usd.Sdf.AttributeSpec(prim, name, types.TokenArray, kept.get("variability", usd.Sdf.VariabilityVarying))
        for key in kept.keys() - {"typeName", "variability", "default", "timeSamples"}:
            fresh.SetInfo(key, kept[key])
        if "default" in kept:
            fresh.default = usd.Vt.TokenArray([str(each) for each in kept["default"]])


def _retime_steps(stage: Any, times: float) -> None:
    steps = stage.GetPrimAtPath(f"{SKIN_ROOT}/Steps")
    for step in steps.GetChildren() if steps and times != 1.0 else ():
        for name in ("lappet:start", "lappet:end"):
            step.GetAttribute(name).Set(step.GetAttribute(name).Get() * times)


class _EpochStrain(Mapping[float, NDArray[np.float32]]):
    """The strain of an epoch's frames by their time codes in the export, read when it is asked for."""

    def __init__(self, cache: SkinCache, epoch: SkinEpoch, times: float) -> None:
        self._cache, self._epoch = cache, epoch
        self._frames = {time * times: time for time in epoch.frames}

    def __getitem__(self, time: float) -> NDArray[np.float32]:
        values = self._cache.scalar(self._epoch, "strain", self._frames[time])
        return np.asarray(values, np.float32)

    def __iter__(self) -> Iterator[float]:
        return iter(self._frames)

    def __len__(self) -> int:
        return len(self._frames)


def _strain(cache: SkinCache, times: float) -> dict[str, _EpochStrain]:
    """The strain of each epoch; nothing where it is not known."""
    known = [each for each in cache.epochs if cache.scalar(each, "strain", each.frames[0]) is not None]
    return {each.name: _EpochStrain(cache, each, times) for each in known}


def _write_looks(
    stage: Any,
    strain: Mapping[str, Mapping[float, NDArray[np.float32]]],
    shown: Mapping[str, Callable[[str], None]],
    full: float | None,
) -> None:
    tissue = [prim.GetName() for prim in stage.GetPrimAtPath(LOOK_ROOT).GetChildren() if is_tissue(prim.GetName())]
    write_look_variants(stage, tissue, strain, shown, full)


def _shows(stage: Any, picture: SkinPicture, folder: str) -> Callable[[str], None]:
    return lambda material: show_picture(stage, material, picture, folder)


def _write_mesh(stage: Any, shape: MovingShape, frames: tuple[float, ...], times: float) -> None:
    """Write tubes in place of the curves that they are drawn along."""
    usd = pxr()
    path = f"{INSTRUMENTS}/{_NAMES[shape.name]}"
    stage.RemovePrim(path)
    usd.UsdGeom.Xform.Define(stage, INSTRUMENTS)
    mesh = usd.UsdGeom.Mesh.Define(stage, path)
    (look, triangles), tokens = shape.parts[0], usd.UsdGeom.Tokens
    mesh.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(triangles), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(np.ascontiguousarray(triangles.ravel())))
    mesh.CreateSubdivisionSchemeAttr(tokens.none)
    primvars = usd.UsdGeom.PrimvarsAPI(mesh)
    primvars.CreatePrimvar("displayColor", usd.Sdf.ValueTypeNames.Color3fArray, tokens.constant).Set([look.color])
    normals = primvars.CreatePrimvar("normals", usd.Sdf.ValueTypeNames.Normal3fArray, tokens.vertex)
    points, extent = mesh.CreatePointsAttr(), mesh.CreateExtentAttr()
    bind(stage, mesh, look)
    for time, placed, shading in zip(shape.frames, shape.positions, shape.normals, strict=True):
        points.Set(vectors(placed), time * times)
        normals.Set(vectors(shading), time * times)
        extent.Set(vectors(bounds(placed)), time * times)
    show_at(mesh, {time * times for time in shape.frames}, [time * times for time in frames])
