"""Camera, lights and background of an exported USD file, in a layer of their own.

They stand beside the procedure, not below it: who refers to the file from a scene gets the procedure alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.framing import LENS, SENSOR, SurgicalField, half_angles, surgical_field, viewpoint
from lappet.drawing.skin_read import SkinCache
from lappet.export.moving_skin import bed_shape
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr, save_layer

STUDIO = "/Studio"
_SHAPE = (16.0, 9.0)
_PAPER = (0.86, 0.87, 0.88)  # linear
_GAP = 0.5  # mm between the tissue and the paper below it
_SHEET = 12.0  # times the extent of the field
# Where each light comes from, in the axes of the field (right, up, out of the skin), how strong it is, and its angle.
_LIGHTS = (
    ("Key", (-0.85, 0.55, 1.0), 0.85, 12.0),
    ("Fill", (1.0, -0.5, 0.8), 0.28, 30.0),
    ("Rim", (0.35, 1.2, 0.5), 0.3, 20.0),
)


def write_studio(cache: SkinCache, frames: Sequence[float], target: Path) -> None:
    """Write the layer.

    Parameters
    ----------
    cache
        The skin cache.
    frames
        Time codes of the frames that the camera should hold, at least one.
    target
        The file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    usd = pxr()
    layer = usd.Sdf.Layer.CreateAnonymous(".usda")
    stage = usd.Usd.Stage.Open(layer)
    usd.UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    usd.UsdGeom.SetStageUpAxis(stage, usd.UsdGeom.Tokens.z)
    stage.SetDefaultPrim(usd.UsdGeom.Xform.Define(stage, STUDIO).GetPrim())
    field = surgical_field(cache, tuple(frames))
    _write_camera(stage, field)
    _write_lights(stage, field)
    placed = [cache.positions(each, each.frames[0]) for each in cache.epochs]
    bed = bed_shape(cache, cache.frames)
    placed += [bed.positions.reshape(-1, 3)] if bed else []
    lowest = min(float((points @ field.normal).min()) for points in placed)
    if not cache.scenery:  # a body has no paper below it
        _write_sheet(stage, field, lowest - _GAP)
    layer.comment = "Camera, lights and background for a procedure. Leave the layer out to light it yourself."
    save_layer(layer, target)


def _placed(prim: Any, position: NDArray[np.float64], axes: NDArray[np.float64]) -> None:
    """Set a prim's axes (rows: right, up, backwards) and place."""
    usd = pxr()
    matrix = np.eye(4)
    matrix[:3, :3], matrix[3, :3] = axes, position
    prim.AddTransformOp().Set(usd.Gf.Matrix4d(*matrix.ravel().tolist()))


def _write_camera(stage: Any, field: SurgicalField) -> None:
    usd = pxr()
    view = viewpoint(field, "oblique", half_angles(_SHAPE))
    camera = usd.UsdGeom.Camera.Define(stage, f"{STUDIO}/Camera")
    # Lens and sensor are in tenths of a unit of the scene.
    camera.CreateFocalLengthAttr(LENS)
    camera.CreateHorizontalApertureAttr(SENSOR)
    camera.CreateVerticalApertureAttr(SENSOR * _SHAPE[1] / _SHAPE[0])
    camera.CreateClippingRangeAttr(usd.Gf.Vec2f(0.05 * view.distance, 40.0 * view.distance))
    camera.CreateFocusDistanceAttr(view.distance)
    _placed(camera, view.position, view.axes)


def _write_lights(stage: Any, field: SurgicalField) -> None:
    usd = pxr()
    axes = np.stack([field.right, field.up, field.normal])
    usd.UsdGeom.Xform.Define(stage, f"{STUDIO}/Lights")
    for name, towards, strength, angle in _LIGHTS:
        back = np.asarray(towards, float) @ axes
        back /= np.linalg.norm(back)
        right = np.cross(field.up, back)
        right /= np.linalg.norm(right)
        light = usd.UsdLux.DistantLight.Define(stage, f"{STUDIO}/Lights/{name}")
        light.CreateIntensityAttr(strength)
        light.CreateAngleAttr(angle)
        light.CreateNormalizeAttr(True)
        _placed(light, field.center, np.stack([right, np.cross(back, right), back]))


def _write_sheet(stage: Any, field: SurgicalField, height: float) -> None:
    """A wide sheet of paper below the tissue."""
    usd = pxr()
    types, tokens = usd.Sdf.ValueTypeNames, usd.UsdGeom.Tokens
    middle = field.center + (height - field.center @ field.normal) * field.normal
    half = _SHEET * field.extent
    corners = [middle + half * (x * field.right + y * field.up) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    mesh = usd.UsdGeom.Mesh.Define(stage, f"{STUDIO}/Background")
    mesh.CreateFaceVertexCountsAttr([4])
    mesh.CreateFaceVertexIndicesAttr([0, 1, 2, 3])
    mesh.CreateSubdivisionSchemeAttr(tokens.none)
    mesh.CreatePointsAttr(vectors(np.array(corners)))
    mesh.CreateExtentAttr(vectors(np.array([np.min(corners, axis=0), np.max(corners, axis=0)])))
    mesh.CreateNormalsAttr(vectors(np.repeat(field.normal[None], 4, axis=0)))
    mesh.SetNormalsInterpolation(tokens.vertex)
    shade = usd.UsdShade
    material = shade.Material.Define(stage, f"{STUDIO}/Paper")
    shader = shade.Shader.Define(stage, f"{STUDIO}/Paper/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", types.Color3f).Set(usd.Gf.Vec3f(*_PAPER))
    shader.CreateInput("roughness", types.Float).Set(0.9)
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", types.Token))
    shade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)
    primvars = usd.UsdGeom.PrimvarsAPI(mesh)
    primvars.CreatePrimvar("displayColor", types.Color3fArray, tokens.constant).Set([usd.Gf.Vec3f(*_PAPER)])
