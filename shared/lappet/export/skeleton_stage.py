"""Shapes that move by bones as USD: one skeleton with its animation, and a mesh for each shape, in metres with Y up.

Each set of bones hangs on a joint of its own that is scaled to nothing, nearly, while the set is hidden: animated
visibility does not play where skeletons are all that plays. Not to nothing, as normals need the scale's inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.surface_look import SKIN_LOOK, SurfaceLook
from lappet.export.play_times import Shown
from lappet.export.skin_tile import SQUARES
from lappet.export.skinned_shape import BoneSet, SkinnedShape
from lappet.geometry.vectors import bounds
from lappet.usd.arrays import vectors
from lappet.usd.stage import pxr

ROOT = "/Operation"
BODY = f"{ROOT}/Body"
METRES = 0.001
HIDDEN = 5e-4  # scale of what is hidden; readers decompose matrices of determinants above 1e-10
_JUST_BEFORE = 0.01  # time codes: how long appearing and disappearing take
TEXTURE = "skin.png"


def mesh_path(name: str) -> str:
    """Return the path of a shape's mesh.

    Parameters
    ----------
    name
        The shape's name.

    Returns
    -------
    str
        The path.
    """
    return f"{BODY}/{pxr().Tf.MakeValidIdentifier(name)}"


@dataclass(frozen=True, eq=False)
class _Joints:
    """The joints of one set: the switch first, then its bones; all values as the skeleton has them."""

    names: list[str]
    places: NDArray[np.float64]  # in the bind pose, in metres, shape (j, 3)
    rotations: NDArray[np.float64]  # of a joint at each of the times, shape (t, j, 4), real part first
    shifts: NDArray[np.float64]  # relative to the parent, in metres, shape (t, j, 3)
    shown: NDArray[np.bool_]  # shape (t,)


def write_stage(
    path: str, shapes: Sequence[SkinnedShape], still: Sequence[Any], times: list[Shown], fps: float
) -> None:
    """Write the stage to a file that is not there yet.

    Parameters
    ----------
    path
        The file.
    shapes
        The shapes that move.
    still
        The shapes that do not, with one frame each.
    times
        When each frame is shown.
    fps
        Time codes in a second.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    usd = pxr()
    stage = usd.Usd.Stage.CreateNew(path)
    usd.UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    usd.UsdGeom.SetStageUpAxis(stage, usd.UsdGeom.Tokens.y)
    stage.SetTimeCodesPerSecond(fps)
    stage.SetFramesPerSecond(fps)
    stage.SetStartTimeCode(0.0)
    stage.SetEndTimeCode(times[-1].end)
    root = usd.UsdGeom.Xform.Define(stage, ROOT)
    usd.Usd.ModelAPI(root).SetKind(usd.Kind.Tokens.component)
    stage.SetDefaultPrim(root.GetPrim())
    body = usd.UsdSkel.Root.Define(stage, BODY)
    joints = [[_joints(shape.shape.name, k, own, times) for k, own in enumerate(shape.sets)] for shape in shapes]
    skeleton = _write_skeleton(stage, [each for own in joints for each in own], times)
    looks = _Looks(stage)
    for shape, own in zip(shapes, joints, strict=True):
        mesh = _write_mesh(stage, mesh_path(shape.shape.name), shape.bind, shape.normals, shape.shape, looks)
        _bind(mesh, shape, own, skeleton)
    for each in still:
        name = usd.Tf.MakeValidIdentifier(each.name)
        _write_mesh(stage, f"{ROOT}/{name}", each.positions[0], each.normals[0], each, looks)
    low, high = (np.array(each) for each in _box(shapes))
    body.CreateExtentAttr(vectors(np.stack([low, high]) * METRES))
    stage.GetRootLayer().Save()


def _box(shapes: Sequence[SkinnedShape]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Between which coordinates the shapes are in all frames, in mm."""
    boxes = [np.array(bounds(each.shape.positions.reshape(-1, 3)), np.float64) for each in shapes]
    return np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)


def _joints(shape: str, number: int, own: BoneSet, times: list[Shown]) -> _Joints:
    skinning = own.skinning
    count = skinning.rotation.shape[1]
    total = np.bincount(skinning.bones.ravel(), skinning.weights.ravel(), count)
    places = (
        np.stack(
            [
                np.bincount(skinning.bones.ravel(), (skinning.weights * own.bind[:, axis, None]).ravel(), count)
                for axis in range(3)
            ],
            axis=1,
        )
        / np.maximum(total, 1e-9)[:, None]
    )
    # Where the set is hidden, it stays as it is shown next to that time.
    frames = np.array(own.frames)
    rows = np.array([int(np.abs(frames - each.frame).argmin()) for each in times])
    switch = 0.5 * (own.bind.min(axis=0) + own.bind.max(axis=0))
    moved = np.einsum("fbij,bj->fbi", skinning.rotation, places) + skinning.shift
    rotations = np.zeros((len(times), count + 1, 4))
    rotations[:, 0, 0] = 1.0
    rotations[:, 1:] = _continuous(quaternions(skinning.rotation))[rows]
    shifts = np.concatenate([np.zeros((len(times), 1, 3)) + switch, moved[rows] - switch], axis=1)
    top = f"{pxr().Tf.MakeValidIdentifier(shape)}_{number:03d}"
    # Blender knows bones by the last part of their path.
    names = [top, *(f"{top}/{top}_{k:03d}" for k in range(count))]
    shown = np.array([each.frame in own.frames for each in times])
    return _Joints(names, np.concatenate([switch[None], places]) * METRES, rotations, shifts * METRES, shown)


def quaternions(rotation: NDArray[np.float64]) -> NDArray[np.float64]:
    """Convert rotations: the quaternion is an eigenvector (Bar-Itzhack 2000).

    Parameters
    ----------
    rotation
        Rotation matrices, shape (..., 3, 3).

    Returns
    -------
    NDArray[np.float64]
        Unit quaternions, real part first, shape (..., 4).
    """
    m = rotation
    rows = [
        [m[..., 0, 0] - m[..., 1, 1] - m[..., 2, 2]] * 4,
        [m[..., 0, 1] + m[..., 1, 0], m[..., 1, 1] - m[..., 0, 0] - m[..., 2, 2]] * 2,
        [m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1], m[..., 2, 2] - m[..., 0, 0] - m[..., 1, 1]],
        [m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]],
    ]
    lower = np.zeros((*m.shape[:-2], 4, 4))
    for i, row in enumerate(rows):
        for j in range(min(i + 1, len(row))):
            lower[..., i, j] = row[j]
    lower[..., 3, 3] = np.trace(m, axis1=-2, axis2=-1)
    vector = np.linalg.eigh(lower / 3.0, UPLO="L")[1][..., :, 3]
    found = vector[..., [3, 0, 1, 2]]
    return np.where(found[..., :1] < 0.0, -found, found)


def _continuous(found: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of the two quaternions of each rotation, that nearer to the one of the frame before."""
    turns = np.sign((found[1:] * found[:-1]).sum(axis=-1, keepdims=True))
    signs = np.cumprod(np.where(turns < 0.0, -1.0, 1.0), axis=0)
    return np.concatenate([found[:1], found[1:] * signs])


def _write_skeleton(stage: Any, joints: list[_Joints], times: list[Shown]) -> Any:
    usd = pxr()
    names = [name for each in joints for name in each.names]
    places = np.concatenate([each.places for each in joints])
    switches = np.array([k for each in joints for k in [True, *[False] * (len(each.names) - 1)]])
    skeleton = usd.UsdSkel.Skeleton.Define(stage, f"{BODY}/Skeleton")
    skeleton.CreateJointsAttr(names)
    matrix = usd.Gf.Matrix4d
    skeleton.CreateBindTransformsAttr([matrix(1.0).SetTranslate(usd.Gf.Vec3d(*map(float, at))) for at in places])
    motion = usd.UsdSkel.Animation.Define(stage, f"{BODY}/Skeleton/Motion")
    motion.CreateJointsAttr(names)
    rotations = np.concatenate([each.rotations for each in joints], axis=1)
    shifts = np.concatenate([each.shifts for each in joints], axis=1)
    shown = np.stack([each.shown for each in joints], axis=1)
    scale = np.ones((len(times), len(names)))
    scale[:, switches] = np.where(shown, 1.0, HIDDEN)
    for k, each in enumerate(times):
        moments = dict.fromkeys((each.begin, each.end))
        for moment in moments:
            motion.CreateTranslationsAttr().Set(vectors(shifts[k]), moment)
            motion.CreateRotationsAttr().Set(_quaternion_array(rotations[k]), moment)
        if k == 0 or (scale[k] != scale[k - 1]).any():
            if k:
                motion.CreateScalesAttr().Set(_halves(scale[k - 1]), each.begin - _JUST_BEFORE)
            motion.CreateScalesAttr().Set(_halves(scale[k]), each.begin)
    # Without animation all is as it ends.
    skeleton.CreateRestTransformsAttr(
        [
            matrix(1.0).SetScale(float(size))
            * matrix(1.0).SetRotate(usd.Gf.Quatd(*map(float, turn)))
            * matrix(1.0).SetTranslate(usd.Gf.Vec3d(*map(float, shift)))
            for size, turn, shift in zip(scale[-1], rotations[-1], shifts[-1], strict=True)
        ]
    )
    binding = usd.UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
    binding.CreateAnimationSourceRel().SetTargets([motion.GetPath()])
    return skeleton


def _quaternion_array(values: NDArray[np.float64]) -> Any:
    """USD's arrays hold the real part last."""
    return pxr().Vt.QuatfArray.FromNumpy(np.ascontiguousarray(values[:, [1, 2, 3, 0]], np.float32))


def _halves(scale: NDArray[np.float64]) -> Any:
    return pxr().Vt.Vec3hArray.FromNumpy(np.repeat(scale[:, None], 3, axis=1).astype(np.float16))


def _write_mesh(stage: Any, path: str, points: NDArray[Any], normals: NDArray[Any], shape: Any, looks: _Looks) -> Any:
    usd = pxr()
    mesh, tokens, types = usd.UsdGeom.Mesh.Define(stage, path), usd.UsdGeom.Tokens, usd.Sdf.ValueTypeNames
    parts = [(look, triangles) for look, triangles in shape.parts if len(triangles)]
    corners = np.concatenate([triangles for _, triangles in parts]).astype(np.int32)
    mesh.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.full(len(corners), 3, np.int32)))
    mesh.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(np.ascontiguousarray(corners.ravel())))
    mesh.CreateSubdivisionSchemeAttr(tokens.none)
    mesh.CreatePointsAttr(vectors(points * METRES))
    mesh.CreateExtentAttr(vectors(bounds(points) * METRES))
    mesh.CreateNormalsAttr(vectors(normals))
    mesh.SetNormalsInterpolation(tokens.vertex)
    if shape.grid is not None:
        st = usd.UsdGeom.PrimvarsAPI(mesh).CreatePrimvar("st", types.TexCoord2fArray, tokens.vertex)
        st.Set(usd.Vt.Vec2fArray.FromNumpy(np.ascontiguousarray(shape.grid / SQUARES, np.float32)))
    begin = 0
    for look, triangles in parts:
        material = looks.material(look, look is SKIN_LOOK and shape.grid is not None)
        whole = len(parts) == 1
        prim = mesh
        if not whole:
            faces = usd.Vt.IntArray.FromNumpy(np.arange(begin, begin + len(triangles), dtype=np.int32))
            family = usd.UsdShade.Tokens.materialBind
            prim = usd.UsdGeom.Subset.CreateGeomSubset(mesh, look.name, tokens.face, faces, family, tokens.partition)
        usd.UsdShade.MaterialBindingAPI.Apply(prim.GetPrim()).Bind(material)
        begin += len(triangles)
    return mesh


def _bind(mesh: Any, shape: SkinnedShape, joints: list[_Joints], skeleton: Any) -> None:
    """Bind a mesh to its bones; switches move no vertex themselves."""
    usd = pxr()
    bones, weights, begin = [], [], 0
    for own, each in zip(shape.sets, joints, strict=True):
        bones.append(own.skinning.bones + begin)
        weights.append(own.skinning.weights)
        begin += len(each.names) - 1
    binding = usd.UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateJointsAttr([name for each in joints for name in each.names[1:]])
    count = bones[0].shape[1]
    flat = np.concatenate(bones).astype(np.int32).ravel()
    shares = np.concatenate(weights).astype(np.float32).ravel()
    binding.CreateJointIndicesPrimvar(False, count).Set(usd.Vt.IntArray.FromNumpy(np.ascontiguousarray(flat)))
    binding.CreateJointWeightsPrimvar(False, count).Set(usd.Vt.FloatArray.FromNumpy(np.ascontiguousarray(shares)))
    binding.CreateGeomBindTransformAttr(usd.Gf.Matrix4d(1.0))


class _Looks:
    """The materials of a stage."""

    def __init__(self, stage: Any) -> None:
        self._stage = stage

    def material(self, look: SurfaceLook, textured: bool) -> Any:
        usd = pxr()
        shade, types = usd.UsdShade, usd.Sdf.ValueTypeNames
        path = f"{ROOT}/Looks/{look.name}{'Textured' if textured else ''}"
        if self._stage.GetPrimAtPath(path):
            return shade.Material(self._stage.GetPrimAtPath(path))
        usd.UsdGeom.Scope.Define(self._stage, f"{ROOT}/Looks")
        material = shade.Material.Define(self._stage, path)
        surface = shade.Shader.Define(self._stage, f"{path}/Surface")
        surface.CreateIdAttr("UsdPreviewSurface")
        surface.CreateInput("roughness", types.Float).Set(look.roughness)
        surface.CreateInput("metallic", types.Float).Set(look.metallic)
        color = surface.CreateInput("diffuseColor", types.Color3f)
        if textured:
            color.ConnectToSource(self._texture(path))
        else:
            color.Set(usd.Gf.Vec3f(*look.color))
        material.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
        return material

    def _texture(self, path: str) -> Any:
        usd = pxr()
        types = usd.Sdf.ValueTypeNames
        reader = usd.UsdShade.Shader.Define(self._stage, f"{path}/Coordinates")
        reader.CreateIdAttr("UsdPrimvarReader_float2")
        reader.CreateInput("varname", types.String).Set("st")
        picture = usd.UsdShade.Shader.Define(self._stage, f"{path}/Picture")
        picture.CreateIdAttr("UsdUVTexture")
        picture.CreateInput("file", types.Asset).Set(usd.Sdf.AssetPath(TEXTURE))
        picture.CreateInput("sourceColorSpace", types.Token).Set("sRGB")
        for axis in ("wrapS", "wrapT"):
            picture.CreateInput(axis, types.Token).Set("repeat")
        result = reader.CreateOutput("result", types.Float2)
        picture.CreateInput("st", types.Float2).ConnectToSource(result)
        return picture.CreateOutput("rgb", types.Float3)
