"""The mesh prim of one epoch in the skin cache: its topology once, its places, normals and fields frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import LayerSearch
from lappet.cutting.epoch import Epoch
from lappet.daemon.solved_frame import SCALARS, SolvedFrame
from lappet.drawing.surface_look import face_looks
from lappet.geometry.labeled_surface import LINING, FaceOrigin, Surface
from lappet.geometry.shading_normals import ShadingNormals
from lappet.geometry.unique_rows import unique_rows
from lappet.geometry.vectors import bounds
from lappet.output.preview_materials import bind_faces
from lappet.output.shown_frames import show_at
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

SUBSETS = {
    FaceOrigin.SKIN: "skin",
    FaceOrigin.WOUND_WALL: "woundWall",
    FaceOrigin.UNDERSIDE: "underside",
    FaceOrigin.RIM: "rim",
}
_SKIN_COLOR = (0.80, 0.58, 0.48)  # what viewers show of the skin without materials; cut faces show their layer


def write_epoch(
    stage: Any,
    epoch: Epoch,
    layers: LayerSearch,
    frames: Sequence[SolvedFrame],
    times: Sequence[float],
    fps: float,
    free_rim: bool = False,
) -> None:
    """Write the skin of an epoch, shown at its own frames alone.

    Parameters
    ----------
    stage
        The stage of the cache.
    epoch
        The epoch.
    layers
        The layers of the tissue.
    frames
        Its solved frames, one after the other.
    times
        Time codes of all frames of the cache.
    fps
        Frames a second.
    free_rim
        Whether the rim of the tissue is a free border of the body and no cut.
    """
    mesh = _define(stage, epoch, layers, free_rim)
    _animate(mesh, ShadingNormals(epoch.surface), frames, fps)
    show_at(mesh, {frame.time for frame in frames}, times)


def _define(stage: Any, epoch: Epoch, layers: LayerSearch, free_rim: bool) -> Any:
    """The mesh at rest, with what does not change: topology, subsets, texture coordinates, colors and materials."""
    usd = pxr()
    surface: Surface = epoch.surface
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    mesh = usd.UsdGeom.Mesh.Define(stage, f"/Procedure/Skin/epoch_{epoch.index:02d}")
    mesh.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(surface.triangles), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(
        usd.Vt.IntArray.FromNumpy(np.ascontiguousarray(surface.triangles.ravel(), np.int32))
    )
    mesh.CreateSubdivisionSchemeAttr(tokens.none)
    for origin, name in SUBSETS.items():
        faces = usd.Vt.IntArray.FromNumpy(np.flatnonzero(surface.origin == origin).astype(np.int32))
        usd.UsdGeom.Subset.CreateGeomSubset(mesh, name, tokens.face, faces, "lappet", tokens.partition)
    if LINING in surface.grips:
        lined = usd.Vt.IntArray.FromNumpy(np.flatnonzero(surface.grips[LINING]).astype(np.int32))
        usd.UsdGeom.Subset.CreateGeomSubset(mesh, LINING, tokens.face, lined, "lappetLining", tokens.nonOverlapping)
    primvars = usd.UsdGeom.PrimvarsAPI(mesh)
    st = primvars.CreatePrimvar("st", types.TexCoord2fArray, tokens.faceVarying)
    st.Set(usd.Vt.Vec2fArray.FromNumpy(np.require(surface.uv.reshape(-1, 2), np.float32, ["C", "A"])))
    color = primvars.CreatePrimvar("displayColor", types.Color3fArray, tokens.uniform)
    found = layers.of(surface)
    depths = found.depth[surface.triangles].mean(axis=1)
    own = layers.layers.colors_at(found.column, depths)
    own[surface.origin == FaceOrigin.SKIN] = _SKIN_COLOR
    palette, index = unique_rows(own)
    color.Set(vectors(palette))
    color.SetIndices(usd.Vt.IntArray.FromNumpy(index.astype(np.int32)))
    depth = primvars.CreatePrimvar("depth", types.FloatArray, tokens.vertex)
    depth.Set(usd.Vt.FloatArray.FromNumpy(found.depth))
    column = primvars.CreatePrimvar("layerColumn", types.IntArray, tokens.uniform)
    column.Set(usd.Vt.IntArray.FromNumpy(found.column))
    bind_faces(stage, mesh, *face_looks(layers.layers, surface.origin, found.column, depths, free_rim))
    # At no time: at rest, which taut tissue leaves as soon as it is cut.
    mesh.CreatePointsAttr().Set(vectors(surface.points))
    return mesh


def _animate(mesh: Any, shading: ShadingNormals, frames: Sequence[SolvedFrame], fps: float) -> None:
    usd = pxr()
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    primvars = usd.UsdGeom.PrimvarsAPI(mesh)
    normals = primvars.CreatePrimvar("normals", types.Normal3fArray, tokens.faceVarying)
    normals.SetIndices(usd.Vt.IntArray.FromNumpy(shading.indices))
    # With --no-strain there are none.
    measured = [name for name in SCALARS if all(frame.scalar(name) is not None for frame in frames)]
    scalars = {name: primvars.CreatePrimvar(name, types.FloatArray, tokens.vertex) for name in measured}
    points, velocities, extent = mesh.GetPointsAttr(), mesh.CreateVelocitiesAttr(), mesh.CreateExtentAttr()
    moved = [np.asarray(frame.points, np.float32) for frame in frames]
    for i, frame in enumerate(frames):
        time = frame.time
        points.Set(vectors(moved[i]), time)
        normals.Set(vectors(shading.at(moved[i])), time)
        velocities.Set(vectors(_velocity(moved, i, fps)), time)
        extent.Set(vectors(bounds(moved[i])), time)
        for name, primvar in scalars.items():
            primvar.Set(usd.Vt.FloatArray.FromNumpy(np.require(frame.scalar(name), np.float32, ["C", "A"])), time)


def _velocity(points: Sequence[NDArray[np.float32]], i: int, fps: float) -> NDArray[np.float32]:
    """Velocity (n, 3) in mm/s at frame i of an epoch.

    Central differences, one-sided at the ends of the epoch, 0 for a single frame.
    """
    before, after = max(i - 1, 0), min(i + 1, len(points) - 1)
    if before == after:
        return np.zeros_like(points[i])
    return ((points[after] - points[before]) * np.float32(fps / (after - before))).astype(np.float32)
