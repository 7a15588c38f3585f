"""The deep tissue under an open wound, in the skin cache as it is seen."""

from __future__ import annotations

from typing import Any

import numpy as np

from lappet.drawing.deep_bed import DeepBed
from lappet.drawing.skin_fields import WOUND_WALL
from lappet.drawing.skin_source import SkinSource
from lappet.drawing.surface_look import BED_LOOK
from lappet.geometry.vectors import bounds
from lappet.output.preview_materials import SKIN_ROOT, bind
from lappet.output.shown_frames import show_at
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

# Not directly below the skin, where meshes are epochs.
ROOT = f"{SKIN_ROOT}/Wound"


def write_bed(stage: Any, source: SkinSource) -> None:
    """Write the bed as a mesh, shown once the tissue is cut; nothing where nothing is cut or nothing lies below.

    Parameters
    ----------
    stage
        The stage of the cache.
    source
        The same, to be read.
    """
    cut = {time for epoch in source.epochs if (epoch.origin == WOUND_WALL).any() for time in epoch.frames}
    bed = DeepBed(source) if cut else ()
    if not isinstance(bed, DeepBed) or not len(bed):
        return
    usd = pxr()
    usd.UsdGeom.Xform.Define(stage, ROOT)
    mesh = usd.UsdGeom.Mesh.Define(stage, f"{ROOT}/Bed")
    mesh.GetPrim().SetDisplayName(BED_LOOK.title)
    mesh.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(bed.triangles), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(bed.triangles.ravel()))
    mesh.CreateSubdivisionSchemeAttr(usd.UsdGeom.Tokens.none)
    color = usd.UsdGeom.PrimvarsAPI(mesh).CreatePrimvar(
        "displayColor", usd.Sdf.ValueTypeNames.Color3fArray, usd.UsdGeom.Tokens.constant
    )
    color.Set([BED_LOOK.color])
    bind(stage, mesh, BED_LOOK)
    points, extent = mesh.CreatePointsAttr(), mesh.CreateExtentAttr()
    for time in sorted(cut):
        placed = bed.positions(time)
        points.Set(vectors(placed), time)
        extent.Set(vectors(bounds(placed)), time)
    show_at(mesh, cut, source.frames)
