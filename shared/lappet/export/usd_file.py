"""`lappet export CACHE.usdc -o X.usdc`: USD in one file without the procedure, for programs that only show it.

What is planned and what is measured is not there, and threads and hooks are meshes: Blender's importer gives curves no
material.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_source import FigureError
from lappet.export.export_request import ExportRequest
from lappet.export.exported_cache import exported_cache
from lappet.export.moving_shape import MovingShape
from lappet.export.moving_tubes import instrument_shapes
from lappet.geometry.vectors import bounds
from lappet.output.drawn_instruments import ROOT as INSTRUMENTS
from lappet.output.dressed_cache import MEASURED, PLANS, TABLES
from lappet.output.preview_materials import SKIN_ROOT, bind
from lappet.output.shown_frames import show_at
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr, save_layer

_NAMES = {"threads": "Threads", "hooks": "SkinHooks"}
_KEPT = ("Steps",)  # of the tables: they are what the operation is told by


def write_usd(request: ExportRequest) -> list[Path]:
    """Write a solved procedure as USD that needs no other file.

    Parameters
    ----------
    request
        The cache and the file.

    Returns
    -------
    list[Path]
        The file.

    Raises
    ------
    RefusedError
        If the cache cannot be read or shown, or is the file itself.
    OSError
        If the file cannot be written.
    """
    cache = exported_cache(request.caches[0], request.limits)
    if request.target.resolve() == cache.path.resolve():
        raise refused(ProblemCode.EXPORT_ITSELF, request.target, cache.path)
    try:
        shapes = instrument_shapes(cache, cache.frames)
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    usd = pxr()
    layer = usd.Usd.Stage.Open(str(cache.path)).Flatten()
    stage = usd.Usd.Stage.Open(layer)
    for path in (*PLANS, *(f"{SKIN_ROOT}/{name}" for name in (*TABLES, *MEASURED) if name not in _KEPT)):
        stage.RemovePrim(path)
    for shape in shapes:
        _write_mesh(stage, shape, cache.frames)
    layer.comment = "Written by lappet export from a skin cache."
    save_layer(layer, request.target)
    return [request.target]


def _write_mesh(stage: Any, shape: MovingShape, frames: tuple[float, ...]) -> None:
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
        points.Set(vectors(placed), time)
        normals.Set(vectors(shading), time)
        extent.Set(vectors(bounds(placed)), time)
    show_at(mesh, set(shape.frames), frames)
