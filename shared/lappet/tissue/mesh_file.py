"""Read a triangle mesh from a file of one of `KINDS`, in mm with Z up; trimesh and USD read them."""

from __future__ import annotations

import errno
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.foreign.regular_file import refuse_irregular, refuse_kind
from lappet.geometry.triangulation import triangulate
from lappet.tissue.gltf_file import GltfFile
from lappet.tissue.mesh_report import MeshReport, Note, found
from lappet.tissue.ply_sizes import refuse_ply_sizes
from lappet.usd.stage import open_stage, pxr

UNITS = {"m": 1000.0, "dm": 100.0, "cm": 10.0, "mm": 1.0, "in": 25.4}
# The unit of a file without one, by its largest extent: most are a head or a face, about 250 mm, or a part of one.
_GUESSES = (("m", 2.0), ("cm", 6.0), ("in", 14.0), ("cm", 35.0))
_GLTF = (".glb", ".gltf")
_USD = (".usd", ".usda", ".usdc", ".usdz")
KINDS = (".obj", ".stl", ".ply", ".off", *_GLTF, *_USD)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles as a file has them.

    Parameters
    ----------
    points
        Vertices in mm, shape (n, 3).
    triangles
        Vertex indices, shape (m, 3).
    uv
        Texture coordinates of the corners, shape (m, 3, 2), or None.
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    uv: NDArray[np.float64] | None = None

    def part(self, triangles: NDArray[Any]) -> Mesh:
        """Take some of the triangles, and the vertices that they use.

        Parameters
        ----------
        triangles
            Which ones: a mask or indices.

        Returns
        -------
        Mesh
            The part.
        """
        used, compact = np.unique(self.triangles[triangles], return_inverse=True)
        return Mesh(self.points[used], compact.reshape(-1, 3), None if self.uv is None else self.uv[triangles])


@dataclass(frozen=True, eq=False)
class MeshRead:
    """A mesh, and what was found while it was read.

    Parameters
    ----------
    mesh
        The mesh, in mm with Z up.
    report
        What was found.
    """

    mesh: Mesh
    report: MeshReport


def read_mesh(
    path: str | Path, units: str | None = None, limits: ReadLimits = DEFAULT_LIMITS
) -> tuple[Mesh, MeshReport]:
    """Read the mesh of a file, in mm with Z up.

    A child process reads it, with limits on memory, time and size. Several meshes in one file become one. What states
    that Y is up (glTF, USD) is turned. Materials and pictures are not read.

    Parameters
    ----------
    path
        A file of one of `KINDS`.
    units
        "m", "dm", "cm", "mm" or "in"; None for those that the file states (USD, glTF), or else a guess from its size.
    limits
        What reading may take.

    Returns
    -------
    tuple[Mesh, MeshReport]
        The mesh, and what was found.

    Raises
    ------
    RefusedError
        If the file is missing, unreadable or of another kind, takes more than it may, holds no triangles or points that
        are not finite, or the units are unknown.
    """
    with ReadingProcess("lappet.tissue.mesh_child", "mesh", Path(path), limits, units or "") as process:
        read: MeshRead = process.result(MeshRead)
    return read.mesh, read.report


def read_mesh_here(path: Path, limits: ReadLimits, units: str | None = None) -> MeshRead:
    """Read the mesh of a file in this process, which is a child: memory and time are not limited here.

    Parameters
    ----------
    path
        As of `read_mesh`.
    limits
        How large files may be, and whether those outside the file's folder are followed.
    units
        As of `read_mesh`.

    Returns
    -------
    MeshRead
        The mesh and what was found.

    Raises
    ------
    RefusedError
        As `read_mesh` does.
    """
    if units is not None and units not in UNITS:
        raise refused(ProblemCode.FILE_UNKNOWN_UNITS, path, units, known=", ".join(UNITS))
    refuse_kind(path, KINDS)
    if not path.exists() or path.is_dir():
        raise refused(ProblemCode.FILE_MISSING, path, what="a mesh")
    refuse_irregular(path, limits)
    if path.suffix.lower() in _USD:
        mesh, corners, scale, turn, says = _read_usd(path, limits)
        silent = "cm by USD's default, as the stage says none; --units says otherwise"
        stated = f"the stage says {scale / 1000.0:g} m per unit" if says else silent
    else:
        mesh, corners = _read_trimesh(path, limits), _obj_corners(path)
        turn = path.suffix.lower() in _GLTF
        scale, stated = (1000.0, "glTF is in metres") if turn else (0.0, "")
    if len(mesh.triangles) == 0:
        raise refused(ProblemCode.FILE_NO_TRIANGLES, path)
    bad = np.flatnonzero(~np.isfinite(mesh.points).all(axis=1))
    if len(bad):
        raise refused(ProblemCode.FILE_POINTS_NOT_FINITE, path, mesh.points[bad[0]].tolist(), first=bad[0])
    extent = float(np.ptp(mesh.points[np.unique(mesh.triangles)], axis=0).max())
    if units is not None:
        scale, stated = UNITS[units], f"{units}, as given"
    elif scale == 0.0:
        guess = next((unit for unit, limit in _GUESSES if extent < limit), "mm")
        scale, stated = UNITS[guess], f"{guess}, guessed from a size of {extent:.4g}; --units says otherwise"
    points = mesh.points * scale
    if turn:
        points = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
    size = np.ptp(points[np.unique(mesh.triangles)], axis=0)
    notes = [
        found("file", path.name),
        found("mesh", f"{len(points)} points, {len(mesh.triangles)} triangles"),
        *_polygons(corners),
        found("units", stated),
        found("size", f"{size[0]:.4g} x {size[1]:.4g} x {size[2]:.4g} mm"),
    ]
    if turn:
        notes.append(found("axes", "turned from Y up to Z up: (x, y, z) is now (x, -z, y)"))
    return MeshRead(Mesh(points, mesh.triangles, mesh.uv), MeshReport(tuple(notes)))


class _NoFiles:
    """What trimesh opens files through that a mesh names, materials and pictures: none are."""

    def get(self, name: str) -> bytes:
        """Open none."""
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), name)

    __getitem__ = get


def _read_trimesh(path: Path, limits: ReadLimits) -> Mesh:
    import trimesh

    try:
        if path.suffix.lower() in _GLTF:
            file = GltfFile(path, limits)
            scene = trimesh.load_scene(file.stream(), file_type="gltf", resolver=file, process=False)
        else:
            with path.open("rb") as stream:
                if path.suffix.lower() == ".ply":
                    refuse_ply_sizes(path, stream)
                kind = path.suffix[1:].lower()
                options = {"skip_materials": True} if kind in ("obj", "ply") else {}
                scene = trimesh.load_scene(stream, file_type=kind, resolver=_NoFiles(), process=False, **options)
        geometry = scene.to_mesh()
    except (RefusedError, MemoryError):
        raise
    except Exception as error:  # trimesh's readers raise anything on broken files
        raise refused(ProblemCode.FILE_NO_MESH, path, error) from error
    triangles = np.asarray(geometry.faces, np.int64).reshape(-1, 3)
    uv = getattr(geometry.visual, "uv", None)
    corner_uv = np.asarray(uv, np.float64)[triangles] if uv is not None and len(uv) == len(geometry.vertices) else None
    return Mesh(np.asarray(geometry.vertices, np.float64).reshape(-1, 3), triangles, corner_uv)


def _obj_corners(path: Path) -> NDArray[np.int64]:
    """The number of corners of each face of an OBJ; empty for other files, whose readers do not tell it."""
    if path.suffix.lower() != ".obj":
        return np.zeros(0, np.int64)
    with path.open("rb") as stream:
        return np.array([len(line.split()) - 1 for line in stream if line.lstrip()[:2] in (b"f ", b"f\t")], np.int64)


def _polygons(corners: NDArray[np.int64]) -> list[Note]:
    if not (corners > 3).any():
        return []
    larger = int((corners > 4).sum())
    more = f" and {larger} faces of up to {corners.max()} corners" if larger else ""
    return [found("polygons", f"{int((corners == 4).sum())} quads{more}, split into triangles")]


def _read_usd(path: Path, limits: ReadLimits) -> tuple[Mesh, NDArray[np.int64], float, bool, bool]:
    """The meshes of a stage at its default time, the corners of their faces, mm per unit, whether Y is up.

    The last says whether the stage says its unit.
    """
    usd = pxr()
    stage = open_stage(path, limits)
    cache = usd.UsdGeom.XformCache()
    points, triangles, corners, uvs, count = [], [], [], [], 0
    for prim in stage.Traverse():
        if not prim.IsA(usd.UsdGeom.Mesh):
            continue
        mesh = usd.UsdGeom.Mesh(prim)
        local = np.asarray(mesh.GetPointsAttr().Get() or np.zeros((0, 3)), np.float64).reshape(-1, 3)
        counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get() or [], np.int64)
        indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get() or [], np.int64)
        if len(local) == 0 or len(counts) == 0:
            continue
        if counts.sum() != len(indices) or indices.min() < 0 or indices.max() >= len(local):
            raise refused(ProblemCode.FILE_FACES_DO_NOT_FIT, path, prim.GetPath())
        faces, face_corners, _ = triangulate(local, counts, indices)
        uv = _usd_uv(usd, prim, indices)
        if mesh.GetOrientationAttr().Get() == "leftHanded":
            faces, face_corners = faces[:, ::-1], face_corners[:, ::-1]
        matrix = np.asarray(cache.GetLocalToWorldTransform(prim), np.float64).reshape(4, 4)
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            faces, face_corners = faces[:, ::-1], face_corners[:, ::-1]
        uvs.append(None if uv is None else uv[face_corners])
        points.append(local @ matrix[:3, :3] + matrix[3, :3])
        triangles.append(faces + count)
        corners.append(counts)
        count += len(local)
    scale = 1000.0 * float(usd.UsdGeom.GetStageMetersPerUnit(stage))
    y_up = str(usd.UsdGeom.GetStageUpAxis(stage)) == "Y"
    says = bool(usd.UsdGeom.StageHasAuthoredMetersPerUnit(stage))
    if not points:
        return Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int64)), np.zeros(0, np.int64), scale, y_up, says
    textured = None if any(each is None for each in uvs) else np.concatenate([each for each in uvs if each is not None])
    return Mesh(np.concatenate(points), np.concatenate(triangles), textured), np.concatenate(corners), scale, y_up, says


def _usd_uv(usd: Any, prim: Any, indices: NDArray[np.int64]) -> NDArray[np.float64] | None:
    """The texture coordinates of a mesh's corners (k, 2), or None where it has none that fit."""
    for primvar in usd.UsdGeom.PrimvarsAPI(prim).GetPrimvars():
        if primvar.GetTypeName() not in (usd.Sdf.ValueTypeNames.TexCoord2fArray, usd.Sdf.ValueTypeNames.Float2Array):
            continue
        values = np.asarray(primvar.ComputeFlattened(usd.Usd.TimeCode.EarliestTime()) or (), np.float64).reshape(-1, 2)
        kind = str(primvar.GetInterpolation())
        if kind == "faceVarying" and len(values) == len(indices):
            return values
        if kind in ("vertex", "varying") and len(values) > indices.max():
            return np.asarray(values[indices])
    return None
