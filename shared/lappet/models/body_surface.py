"""The skin of a shaped body around a model: divided finely, and with the neutral body beside it.

Regions, landmarks and lines are given on the neutral body. Every vertex has its place there and its place on the shaped
body, so what is found on one is known on the other, and a region holds the same skin whatever the shape.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.geometry.catmull_clark import catmull_clark
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.connected_parts import parts_of
from lappet.models.body_mesh import BODY, body_mesh
from lappet.models.body_shape import NEUTRAL, BodyShape, shaped
from lappet.models.cleft import Cleft
from lappet.models.openings import without_openings
from lappet.models.region import Ellipsoid
from lappet.procedure import Point
from lappet.tissue.crop_mesh import box_levels, crop
from lappet.tissue.mesh_file import Mesh

_MOUTH = ((-21.0, 138.0, 667.6), (21.0, 138.0, 667.6))  # its corners, mm
_MARGIN = 25.0  # mm around what is asked for, so that its border is as smooth as the rest


@dataclass(frozen=True, eq=False)
class BodySurface:
    """Skin of a body as triangles.

    Parameters
    ----------
    neutral
        Vertices on the neutral body in mm, shape (n, 3).
    points
        Vertices on the shaped body in mm, shape (n, 3).
    triangles
        Vertex indices, oriented outwards, shape (m, 3).
    """

    neutral: NDArray[np.float64]
    points: NDArray[np.float64]
    triangles: NDArray[np.int64]

    def carried(self, places: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Take places of the neutral body to the shaped one.

        Parameters
        ----------
        places
            Points on the neutral body or near it in mm, shape (k, 3).

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]]
            The closest points of its skin as they lie on the shaped body in mm, shape (k, 3), and how far each was from
            the skin in mm, shape (k,).
        """
        given = np.asarray(places, np.float64).reshape(-1, 3)
        faces, closest, _ = ClosestPoint(self.neutral, self.triangles).query(given)
        weights = _barycentric(closest, self.neutral[self.triangles[faces]])
        carried = np.einsum("kc,kci->ki", weights, self.points[self.triangles[faces]])
        return carried, np.linalg.norm(closest - given, axis=1)

    def cleft(self, cleft: Cleft, points: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        """Move points with a cleft of the lip.

        Parameters
        ----------
        cleft
            The cleft; on a shaped body it is as large as the mouth is there.
        points
            Points in or on the shaped body in mm, shape (k, 3); None for the vertices.

        Returns
        -------
        NDArray[np.float64]
            Where they are with the cleft in mm, shape (k, 3).
        """
        corners, _ = self.carried(_MOUTH)
        scale = float(np.linalg.norm(corners[1] - corners[0]) / np.linalg.norm(np.subtract(*_MOUTH)))
        if points is None:
            return np.asarray(self.points + scale * cleft.moved(self.neutral))
        return np.asarray(points + scale * cleft.moved(self.on_neutral(points)))

    def on_neutral(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Take points of the shaped body to the neutral one, each with the skin that it is nearest to.

        Parameters
        ----------
        points
            Points in or on the shaped body in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.float64]
            Points of the neutral body in mm, shape (k, 3).
        """
        faces, closest, _ = ClosestPoint(self.points, self.triangles).query(points)
        weights = _barycentric(closest, self.points[self.triangles[faces]])
        return np.asarray(np.einsum("kc,kci->ki", weights, self.neutral[self.triangles[faces]]) + points - closest)

    def inside(self, region: Ellipsoid) -> BodySurface:
        """Cut out the part that contains the center of a region.

        Parameters
        ----------
        region
            The region.

        Returns
        -------
        BodySurface
            The connected part of the skin in the region that is nearest to its center.
        """
        cut = crop(Mesh(np.hstack([self.neutral, self.points]), self.triangles), [region.level])
        both, triangles = cut.points, cut.triangles
        part = parts_of(triangles, len(both))
        center = np.array([region.center])
        away = [
            float(np.linalg.norm(ClosestPoint(both[:, :3], triangles[part == each]).query(center)[1][0] - center[0]))
            for each in np.unique(part)
        ]
        return _compact(both, triangles[part == np.unique(part)[int(np.argmin(away))]])

    def outside(self, region: Ellipsoid) -> BodySurface:
        """Cut a region out.

        Parameters
        ----------
        region
            The region.

        Returns
        -------
        BodySurface
            The skin that is not in it.
        """
        both = np.hstack([self.neutral, self.points])
        cut = crop(Mesh(both, self.triangles), [lambda points: -region.level(points)])
        return _compact(cut.points, cut.triangles)

    def within(self, box: tuple[Point, Point]) -> BodySurface:
        """Cut off what lies outside a box.

        Parameters
        ----------
        box
            Its lowest and highest corner on the neutral body in mm.

        Returns
        -------
        BodySurface
            The skin in the box, with a clean border.
        """
        cut = crop(Mesh(np.hstack([self.neutral, self.points]), self.triangles), box_levels(*box))
        return _compact(cut.points, cut.triangles)


def body_surface(
    shape: BodyShape, box: tuple[Point, Point], subdivision: int, cleft: Cleft | None = None
) -> BodySurface:
    """Make the skin of a body in a box.

    Parameters
    ----------
    shape
        The shape of the body.
    box
        Lowest and highest corner on the neutral body in mm; faces reach a margin beyond.
    subdivision
        How often the faces of the base mesh are divided.
    cleft
        The cleft for which skin of the lip is taken out, not moved yet; None for none.

    Returns
    -------
    BodySurface
        The skin.

    Raises
    ------
    RefusedError
        If the shape is refused, or the package is not there.
    """
    mesh = body_mesh()
    neutral = shaped(NEUTRAL)
    both = np.hstack([neutral, shaped(shape)])
    quads = without_openings(mesh, mesh.faces_of(BODY))
    middle = neutral[quads].mean(axis=1)
    low, high = np.array(box[0]) - _MARGIN, np.array(box[1]) + _MARGIN
    values, quads = _compact_quads(both, quads[((middle > low) & (middle < high)).all(axis=1)])
    for _ in range(subdivision):
        values, quads = catmull_clark(values, quads)
    corners = values[quads][:, :, :3]
    first = np.linalg.norm(corners[:, 0] - corners[:, 2], axis=1) <= np.linalg.norm(
        corners[:, 1] - corners[:, 3], axis=1
    )
    split = np.where(first[:, None], quads[:, [0, 1, 2, 0, 2, 3]], quads[:, [1, 2, 3, 1, 3, 0]])
    triangles = split.reshape(-1, 3)
    if cleft is not None and cleft.taken_out is not None:
        cut = crop(Mesh(values, triangles), [cleft.taken_out])
        return _compact(cut.points, cut.triangles)
    return BodySurface(values[:, :3], values[:, 3:], triangles)


def _compact_quads(
    values: NDArray[np.float64], quads: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    used, compact = np.unique(quads, return_inverse=True)
    return values[used], compact.reshape(-1, 4).astype(np.int64)


def _compact(both: NDArray[np.float64], triangles: NDArray[np.int64]) -> BodySurface:
    used, compact = np.unique(triangles, return_inverse=True)
    return BodySurface(both[used, :3], both[used, 3:6], compact.reshape(-1, 3).astype(np.int64))


def _barycentric(points: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The weights (k, 3) of points (k, 3) in their triangles (k, 3, 3)."""
    a, b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    aa, ab, bb = (np.einsum("ki,ki->k", u, v) for u, v in ((a, a), (a, b), (b, b)))
    ac, bc = (np.einsum("ki,ki->k", u, c) for u in (a, b))
    scale = np.maximum(aa * bb - ab * ab, 1e-300)
    v, w = (bb * ac - ab * bc) / scale, (aa * bc - ab * ac) / scale
    return np.stack([1.0 - v - w, v, w], axis=1)
