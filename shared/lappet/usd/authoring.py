"""Author prims and values of a procedure's layer.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lappet.procedure import Bone, Point, Scenery, Tissue

LINE_WIDTH = 0.4  # mm, how thick other viewers draw curves and points


class Values:
    """An author of uniform attributes and relationships of one prim, in the namespace `lappet:`.

    Parameters
    ----------
    prim
        The prim.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    """

    def __init__(self, prim: Any, usd: Any) -> None:
        self._prim, self._usd = prim, usd

    def author(self, name: str, kind: Any, value: Any) -> None:
        """Author a value.

        Parameters
        ----------
        name
            Name of the attribute, without the namespace.
        kind
            Its type, of `Sdf.ValueTypeNames`.
        value
            Its value.
        """
        uniform = self._usd.Sdf.VariabilityUniform
        self._prim.CreateAttribute(f"lappet:{name}", kind, custom=False, variability=uniform).Set(value)

    def double(self, name: str, value: float) -> None:
        """Author a number.

        Times are numbers too: of the type timecode .usda files keep only six digits.

        Parameters
        ----------
        name
            Name of the attribute, without the namespace.
        value
            Its value.
        """
        self.author(name, self._usd.Sdf.ValueTypeNames.Double, float(value))

    def samples(self, name: str, samples: tuple[tuple[float, float], ...]) -> None:
        """Author a number that changes in time, or nothing if there are no samples.

        Parameters
        ----------
        name
            Name of the attribute, without the namespace.
        samples
            Pairs of time code and value.
        """
        if samples:
            kind = self._usd.Sdf.ValueTypeNames.Double
            attribute = self._prim.CreateAttribute(f"lappet:{name}", kind, custom=False)
            for time, value in samples:
                attribute.Set(float(value), float(time))

    def vector_samples(self, name: str, samples: tuple[tuple[float, Point], ...]) -> None:
        """Author a vector that changes in time, or nothing if there are no samples.

        Parameters
        ----------
        name
            Name of the attribute, without the namespace.
        samples
            Pairs of time code and vector.
        """
        if samples:
            kind = self._usd.Sdf.ValueTypeNames.Double3
            attribute = self._prim.CreateAttribute(f"lappet:{name}", kind, custom=False)
            for time, value in samples:
                attribute.Set(self._usd.Gf.Vec3d(*value), float(time))

    def relate(self, name: str, target: str) -> None:
        """Author a relationship.

        Parameters
        ----------
        name
            Name of the relationship, without the namespace.
        target
            Path of the prim that it points to.
        """
        self._prim.CreateRelationship(f"lappet:{name}", custom=False).SetTargets([target])


def mesh_prim(stage: Any, usd: Any, path: str, mesh: Tissue | Bone | Scenery) -> Any:
    """Define a Mesh.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    path
        Path of the prim.
    mesh
        Its geometry.

    Returns
    -------
    Any
        The prim.
    """
    prim = usd.UsdGeom.Mesh.Define(stage, path)
    prim.CreatePointsAttr(_vectors(usd, mesh.points))
    prim.CreateFaceVertexCountsAttr(usd.Vt.IntArray.FromNumpy(np.array(mesh.face_vertex_counts, np.int32)))
    prim.CreateFaceVertexIndicesAttr(usd.Vt.IntArray.FromNumpy(np.array(mesh.face_vertex_indices, np.int32)))
    prim.CreateSubdivisionSchemeAttr(usd.UsdGeom.Tokens.none)
    _extent(usd, prim, mesh.points, 0.0)
    return prim.GetPrim()


def curve_prim(stage: Any, usd: Any, path: str, points: ArrayLike, basis: str, closed: bool) -> Any:
    """Define a BasisCurves with one curve.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    path
        Path of the prim.
    points
        Its points, mm, shape (n, 3).
    basis
        USD's `basis`, or "linear".
    closed
        Whether it returns to its first point.

    Returns
    -------
    Any
        The prim.
    """
    tokens = usd.UsdGeom.Tokens
    prim = usd.UsdGeom.BasisCurves.Define(stage, path)
    vectors = _vectors(usd, points)
    prim.CreatePointsAttr(vectors)
    prim.CreateCurveVertexCountsAttr(usd.Vt.IntArray([len(vectors)]))
    prim.CreateTypeAttr(tokens.linear if basis == "linear" else tokens.cubic)
    if basis != "linear":
        prim.CreateBasisAttr(basis)
    prim.CreateWrapAttr(tokens.periodic if closed else tokens.nonperiodic)
    _widths(usd, prim)
    _extent(usd, prim, points, LINE_WIDTH / 2)
    return prim.GetPrim()


def lines_prim(stage: Any, usd: Any, path: str, lines: Sequence[Sequence[Point]]) -> Any:
    """Define a BasisCurves with several open polylines.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    path
        Path of the prim.
    lines
        Their points, mm, each of shape (n, 3).

    Returns
    -------
    Any
        The prim.
    """
    tokens = usd.UsdGeom.Tokens
    prim = usd.UsdGeom.BasisCurves.Define(stage, path)
    points = [point for line in lines for point in line]
    prim.CreatePointsAttr(_vectors(usd, points))
    prim.CreateCurveVertexCountsAttr(usd.Vt.IntArray([len(line) for line in lines]))
    prim.CreateTypeAttr(tokens.linear)
    prim.CreateWrapAttr(tokens.nonperiodic)
    _widths(usd, prim)
    _extent(usd, prim, points, LINE_WIDTH / 2)
    return prim.GetPrim()


def points_prim(stage: Any, usd: Any, path: str, points: ArrayLike) -> Any:
    """Define a Points.

    Parameters
    ----------
    stage
        The stage.
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    path
        Path of the prim.
    points
        Its points, mm, shape (n, 3).

    Returns
    -------
    Any
        The prim.
    """
    prim = usd.UsdGeom.Points.Define(stage, path)
    prim.CreatePointsAttr(_vectors(usd, points))
    _widths(usd, prim)
    _extent(usd, prim, points, LINE_WIDTH / 2)
    return prim.GetPrim()


def _widths(usd: Any, prim: Any) -> None:
    prim.CreateWidthsAttr(usd.Vt.FloatArray([LINE_WIDTH]))
    prim.SetWidthsInterpolation(usd.UsdGeom.Tokens.constant)


def _vectors(usd: Any, points: ArrayLike) -> Any:
    return usd.Vt.Vec3fArray.FromNumpy(np.array(points, np.float32).reshape(-1, 3))


def _extent(usd: Any, prim: Any, points: ArrayLike, margin: float) -> None:
    array = np.asarray(points, np.float32).reshape(-1, 3)
    if len(array):
        prim.CreateExtentAttr(_vectors(usd, [array.min(axis=0) - margin, array.max(axis=0) + margin]))
