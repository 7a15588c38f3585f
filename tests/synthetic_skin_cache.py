"""A small skin cache made without the solver: a flat patch, slit, pulled open by hooks and sutured.

The layout is that of docs/skin_cache.md. The deformation is a formula, so that a test knows where the
wound is and how far it gapes; frames are 1 to 12: whole (1-2), incised and lifted (3-7), sutured (8-12).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

LENGTH, WIDTH, THICKNESS = 100.0, 80.0, 4.0
HALF_SLIT = 20.0
FRAMES = tuple(range(1, 13))
INCISED, LIFTED, SUTURED = 3, 7, 10
SUTURES = (-12.0, -4.0, 4.0, 12.0)


def patch(step: float, slit: bool) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.uint8]]:
    """Rest points (n, 3) in mm, triangles (m, 3) and origin (m,) of the patch.

    The origin is 0 skin, 1 wound wall, 2 underside, 3 rim. step: edge of the grid, mm. slit: whether the patch is cut
    through along y = 0, |x| < HALF_SLIT.
    """
    nx, ny = round(LENGTH / step), round(WIDTH / step)
    x = np.linspace(-LENGTH / 2, LENGTH / 2, nx + 1)
    y = np.linspace(-WIDTH / 2, WIDTH / 2, ny + 1)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    ids = np.arange(len(grid)).reshape(nx + 1, ny + 1)
    above = ids.copy()  # the vertex that faces on the +y side of the slit use
    middle = ny // 2
    cut = np.flatnonzero(np.abs(x) < HALF_SLIT - 1e-9) if slit else np.zeros(0, int)
    above[cut, middle] = len(grid) + np.arange(len(cut))
    sheet = np.vstack([grid, grid[ids[cut, middle]]])
    count = len(sheet)
    top = np.column_stack([sheet, np.zeros(count)])
    bottom = np.column_stack([sheet, np.full(count, -THICKNESS)])
    side = np.zeros(count)
    side[len(grid) :] = 1.0
    quads, origin = [], []
    for j in range(ny):
        a = above if j >= middle else ids
        q = np.stack([a[:-1, j], a[1:, j], a[1:, j + 1], a[:-1, j + 1]], axis=-1)
        quads += [q, q[:, ::-1] + count]
        origin += [np.zeros(nx), np.full(nx, 2)]

    def wall(chain: NDArray[np.int64], label: int) -> None:
        quads.append(np.stack([chain[1:], chain[:-1], chain[:-1] + count, chain[1:] + count], axis=-1))
        origin.append(np.full(len(chain) - 1, label))

    if slit:
        ends = np.concatenate([[cut[0] - 1], cut, [cut[-1] + 1]])
        wall(ids[ends, middle][::-1], 1)
        wall(above[ends, middle], 1)
    for chain in (ids[:, 0], ids[-1, :], ids[::-1, -1], ids[0, ::-1]):
        wall(chain, 3)
    q = np.concatenate(quads)
    triangles = np.concatenate([q[:, [0, 1, 2]], q[:, [0, 2, 3]]]).astype(np.int32)
    labels = np.concatenate(origin).astype(np.uint8)
    points = np.vstack([top, bottom])
    points[:, 1] += np.where(np.concatenate([side, side]) > 0, 1e-9, 0.0)  # tells the two lips apart at rest
    return points, triangles, np.concatenate([labels, labels])


def opening(time: float) -> float:
    """Half the gape of the slit at its middle, mm."""
    return float(np.interp(time, (INCISED, LIFTED, SUTURED), (0.6, 7.0, 0.0)))


def lift(time: float) -> float:
    """Height to which the hooks lift the lips, mm."""
    return float(np.interp(time, (INCISED, LIFTED, SUTURED), (0.0, 5.0, 0.0)))


def deform(rest: NDArray[np.float64], time: float, slit: bool) -> NDArray[np.float32]:
    """Positions (n, 3) of material points at a frame."""
    if not slit:
        return rest.astype(np.float32)
    x, y = rest[:, 0], rest[:, 1]
    shape = np.clip(1.0 - (x / HALF_SLIT) ** 2, 0.0, None)
    away = np.exp(-np.abs(y) / 11.0)
    side = np.where(y > 0.0, 1.0, -1.0)
    moved = rest.copy()
    moved[:, 1] += side * opening(time) * shape * away
    moved[:, 2] += lift(time) * shape**2 * np.exp(-np.abs(y) / 6.0)
    return moved.astype(np.float32)


def lips_apart(rest: NDArray[np.float64], gape: float) -> NDArray[np.float32]:
    """The slit patch with its two lips `gape` mm apart."""
    moved = rest.copy()
    moved[:, 1] += np.where(rest[:, 1] > 0, gape / 2, -gape / 2)
    return moved.astype(np.float32)


def _normals(points: NDArray[np.float32], triangles: NDArray[np.int32]) -> NDArray[np.float32]:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    face = np.cross(b - a, c - a)
    total = np.zeros_like(points)
    for k in range(3):
        np.add.at(total, triangles[:, k], face)
    return (total / np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-12)).astype(np.float32)


def _event(stage: Any, name: str, kind: str, type_name: str, **values: Any) -> Any:
    from pxr import Sdf

    prim = stage.DefinePrim(f"/Procedure/Timeline/{name}", type_name)
    prim.SetMetadata("apiSchemas", Sdf.TokenListOp.CreateExplicit([f"Lappet{kind}API"]))
    for key, value in values.items():
        prim.CreateAttribute(f"lappet:{key}", Sdf.ValueTypeNames.Double).Set(float(value))
    return prim


def write_procedure(path: Path) -> None:
    """Write the procedure that the cache sublayers."""
    from pxr import Gf, Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetStartTimeCode(FRAMES[0])
    stage.SetEndTimeCode(FRAMES[-1])
    stage.SetTimeCodesPerSecond(24)
    root = UsdGeom.Xform.Define(stage, "/Procedure")
    stage.SetDefaultPrim(root.GetPrim())
    UsdGeom.Scope.Define(stage, "/Procedure/Timeline")
    points, triangles, _ = patch(10.0, False)
    tissue = UsdGeom.Mesh.Define(stage, "/Procedure/Tissue")
    tissue.CreatePointsAttr(points.astype(np.float32))
    tissue.CreateFaceVertexCountsAttr(np.full(len(triangles), 3, np.int32))
    tissue.CreateFaceVertexIndicesAttr(triangles.ravel())
    tissue.CreateSubdivisionSchemeAttr("none")
    cut = UsdGeom.BasisCurves(_event(stage, "central_limb", "Incision", "BasisCurves", time=INCISED))
    cut.CreatePointsAttr([Gf.Vec3f(-HALF_SLIT, 0, 0), Gf.Vec3f(HALF_SLIT, 0, 0)])
    cut.CreateCurveVertexCountsAttr([2])
    cut.CreateTypeAttr("linear")
    for side, name in ((-1, "lower_hook"), (1, "upper_hook")):
        hook = UsdGeom.Xform(_event(stage, name, "Hook", "Xform", start=INCISED + 1, release=SUTURED))
        translate = hook.AddTranslateOp()
        for t in (INCISED + 1, LIFTED, SUTURED):
            translate.Set(Gf.Vec3d(0, side * (1 + opening(t)), lift(t)), t)
    for k, x in enumerate(SUTURES):
        start = LIFTED + 1 + k // 2
        suture = _event(stage, f"suture_{k + 1}", "Suture", "BasisCurves", start=start, duration=2)
        curves = UsdGeom.BasisCurves(suture)
        curves.CreatePointsAttr([Gf.Vec3f(x, -0.5, 0), Gf.Vec3f(x, 0.5, 0)])
        curves.CreateCurveVertexCountsAttr([2])
        curves.CreateTypeAttr("linear")
    stage.GetRootLayer().Save()


def _write_epoch(stage: Any, index: int, step: float, slit: bool, frames: tuple[int, ...]) -> None:
    from pxr import Sdf, UsdGeom, Vt

    rest, triangles, origin = patch(step, slit)
    mesh = UsdGeom.Mesh.Define(stage, f"/Procedure/Skin/epoch_{index:02d}")
    mesh.CreateFaceVertexCountsAttr(np.full(len(triangles), 3, np.int32))
    mesh.CreateFaceVertexIndicesAttr(triangles.ravel())
    mesh.CreateSubdivisionSchemeAttr("none")
    for label, name in enumerate(("skin", "woundWall", "underside", "rim")):
        faces = np.flatnonzero(origin == label).astype(np.int32)
        UsdGeom.Subset.CreateGeomSubset(mesh, name, UsdGeom.Tokens.face, Vt.IntArray.FromNumpy(faces), "lappet")
    variable = UsdGeom.PrimvarsAPI(mesh)
    types = Sdf.ValueTypeNames
    st = variable.CreatePrimvar("st", types.TexCoord2fArray, UsdGeom.Tokens.faceVarying)
    st.Set(((rest[triangles.ravel(), :2] + (LENGTH / 2, WIDTH / 2)) / (LENGTH, WIDTH)).astype(np.float32))
    points, normals = mesh.CreatePointsAttr(), mesh.CreateNormalsAttr()
    mesh.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
    extent, visibility = mesh.CreateExtentAttr(), mesh.CreateVisibilityAttr()
    scalars = [
        variable.CreatePrimvar(n, types.FloatArray, UsdGeom.Tokens.vertex) for n in ("strain", "stress", "tension")
    ]
    for t in FRAMES:
        visibility.Set("inherited" if t in frames else "invisible", t)
    for t in frames:
        moved = deform(rest, t, slit)
        points.Set(moved, t)
        normals.Set(_normals(moved, triangles), t)
        extent.Set(np.array([moved.min(0), moved.max(0)], np.float32), t)
        strain = np.linalg.norm(moved - rest, axis=1).astype(np.float32) / 20
        for k, primvar in enumerate(scalars):
            primvar.Set(strain * (1.0, 50.0, 40.0)[k], t)


def write_cache(folder: Path, step: float = 2.0) -> Path:
    """Write `procedure.usda` and `cache.usdc` into the folder and return the cache's path. step: grid edge, mm."""
    from pxr import Sdf, Usd, UsdGeom

    write_procedure(folder / "procedure.usda")
    path = folder / "cache.usdc"
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append("./procedure.usda")
    UsdGeom.SetStageMetersPerUnit(stage, 0.001)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetStartTimeCode(FRAMES[0])
    stage.SetEndTimeCode(FRAMES[-1])
    stage.SetTimeCodesPerSecond(24)
    stage.SetDefaultPrim(stage.GetPrimAtPath("/Procedure"))
    UsdGeom.Imageable(stage.OverridePrim("/Procedure/Tissue")).CreateVisibilityAttr("invisible")
    UsdGeom.Xform.Define(stage, "/Procedure/Skin")
    _write_epoch(stage, 0, step, False, tuple(t for t in FRAMES if t < INCISED))
    _write_epoch(stage, 1, step, True, tuple(t for t in FRAMES if t >= INCISED))
    types = Sdf.ValueTypeNames
    sutures = UsdGeom.BasisCurves.Define(stage, "/Procedure/Skin/Sutures")
    hooks = UsdGeom.BasisCurves.Define(stage, "/Procedure/Skin/Hooks")
    landmarks = UsdGeom.Points.Define(stage, "/Procedure/Skin/Landmarks")
    for curves, count in ((sutures, len(SUTURES)), (hooks, 2)):
        curves.CreateTypeAttr("linear")
        curves.CreateCurveVertexCountsAttr(np.full(count, 2, np.int32))
    active = [
        UsdGeom.PrimvarsAPI(c).CreatePrimvar("active", types.IntArray, UsdGeom.Tokens.uniform) for c in (sutures, hooks)
    ]
    labels = UsdGeom.PrimvarsAPI(landmarks).CreatePrimvar("label", types.StringArray, UsdGeom.Tokens.uniform)
    labels.Set(["left apex", "right apex"])
    ends = np.array([[x, s * 0.5, 0.0] for x in SUTURES for s in (-1, 1)])
    lips = np.array([[0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    apexes = np.array([[-HALF_SLIT, 0.0, 0.0], [HALF_SLIT, 0.0, 0.0]])
    for t in FRAMES:
        cut = t >= INCISED
        sutures.CreatePointsAttr().Set(deform(ends, t, cut), t)
        active[0].Set([int(t >= LIFTED + 1 + k // 2) for k in range(len(SUTURES))], t)
        anchor = deform(lips, t, cut)
        target = anchor + np.array([[0, -0.4, 0.3], [0, 0.4, 0.3]], np.float32)
        hooks.CreatePointsAttr().Set(np.stack([anchor, target], axis=1).reshape(-1, 3), t)
        active[1].Set([int(INCISED + 1 <= t < SUTURED)] * 2, t)
        landmarks.CreatePointsAttr().Set(deform(apexes, t, cut), t)
    stage.GetRootLayer().Save()
    return path
