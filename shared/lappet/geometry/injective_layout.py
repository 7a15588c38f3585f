"""Lay a patch of skin out in the plane so that no triangle turns over, whatever its shape.

Notation: U, the layout, (n, 2); J, the 2 x 2 gradient of U over a triangle laid flat; A, the triangle's area. The start
is Tutte's embedding (1963): the longest border becomes a circle, holes are closed by a vertex each, and every other
vertex is a mean of its neighbors, which turns none over. From there the symmetric Dirichlet energy

    E = sum of A (‖J‖² + ‖J⁻¹‖²)

is lowered. It is least where lengths are kept and infinite where a triangle is turned over; steps end before the first
one is (Smith and Schaefer 2015). The steps are those of L-BFGS with the patch's Laplacian as the first Hessian.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.surface_check import directed_edges, unique_edges

_MOST_STEPS = 200
_DONE = 1e-4  # relative decrease of the energy over _PATIENCE steps at which it is low enough
_PATIENCE = 5
_MEMORY = 8  # steps that L-BFGS remembers
_SHORT = 0.9  # of the way to where a triangle would have no area
_SOLVED, _MOST_ROUNDS = 1e-2, 200  # relative residual and rounds of a solve with the Laplacian
_CLUSTERS = 250  # that its preconditioner has, about
_ENOUGH = 1e-4  # of the decrease that the gradient promises (Armijo)

Layout = NDArray[np.float64]


def signed_areas(layout: Layout, triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Compute areas of triangles in the plane, negative where they are turned over.

    Parameters
    ----------
    layout
        Plane coordinates, shape (n, 2).
    triangles
        Vertex indices, shape (m, 3).

    Returns
    -------
    NDArray[np.float64]
        Areas, shape (m,).
    """
    a, b, c = (layout[triangles[:, k]] for k in range(3))
    u, v = b - a, c - a
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))


def injective_layout(
    points: NDArray[np.float64], triangles: NDArray[np.int64], weights: NDArray[np.float64] | None = None
) -> Layout:
    """Lay a patch out in the plane without turning a triangle over, and with little distortion.

    Parameters
    ----------
    points
        Vertices, shape (n, 3).
    triangles
        Vertex indices of one connected manifold surface with a border and no handle, shape (m, 3).
    weights
        How much the lengths of each triangle matter, shape (m,); all alike when None.

    Returns
    -------
    NDArray[np.float64]
        Plane coordinates in the unit of the points, shape (n, 2).
    """
    layout = _tutte(points, triangles)
    size = float(np.abs(signed_areas(layout, triangles)).sum())
    corners = points[triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    layout = layout * np.sqrt(float(area.sum()) / max(size, 1e-300))
    energy = _Energy.of(points, triangles, np.ones(len(triangles)) if weights is None else weights)
    value, gradient = energy.at(layout)
    if not np.isfinite(value):  # a handle, or an edge across that Tutte's embedding makes flat
        return layout
    steps: deque[tuple[Layout, Layout]] = deque(maxlen=_MEMORY)
    values = [value]
    for _ in range(_MOST_STEPS):
        direction = -_product(energy, steps, gradient)
        slope = float((direction * gradient).sum())
        if slope >= 0.0:
            steps.clear()
            direction = -energy.laplacian.solve(gradient)
            slope = float((direction * gradient).sum())
        length = min(1.0, _SHORT * _room(layout, direction, triangles))
        while True:
            following = layout + length * direction
            lower, ahead = energy.at(following)
            if lower <= value + _ENOUGH * length * slope or length < 1e-12:
                break
            length *= 0.5
        if not lower < value:
            break
        steps.append((following - layout, ahead - gradient))
        layout, value, gradient = following, lower, ahead
        values.append(value)
        if len(values) > _PATIENCE and values[-_PATIENCE - 1] - value < _DONE * value:
            break
    return layout


def _product(energy: _Energy, steps: deque[tuple[Layout, Layout]], gradient: Layout) -> Layout:
    """The approximate inverse Hessian times the gradient, by the two loops of L-BFGS."""
    vector = gradient.copy()
    shares = []
    for step, change in reversed(steps):
        share = float((step * vector).sum()) / max(float((step * change).sum()), 1e-300)
        shares.append(share)
        vector -= share * change
    vector = energy.laplacian.solve(vector)
    for (step, change), share in zip(steps, reversed(shares), strict=True):
        vector += (share - float((change * vector).sum()) / max(float((step * change).sum()), 1e-300)) * step
    return vector


def _room(layout: Layout, direction: Layout, triangles: NDArray[np.int64]) -> float:
    """How far one may go until the first triangle has no area: the least positive root of a quadratic for each."""
    u, v, du, dv = (each[triangles[:, k]] - each[triangles[:, 0]] for each in (layout, direction) for k in (1, 2))
    cross = _cross
    a, b, c = cross(du, dv), cross(u, dv) + cross(du, v), cross(u, v)
    root = np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))
    q = -0.5 * (b + np.where(b >= 0.0, root, -root))
    with np.errstate(divide="ignore", invalid="ignore"):
        roots = np.stack([q / a, c / q])
    roots[:, b * b - 4.0 * a * c < 0.0] = np.inf
    positive = roots[np.isfinite(roots) & (roots > 0.0)]
    return float(positive.min(initial=np.inf))


def _cross(u: Layout, v: Layout) -> NDArray[np.float64]:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


@dataclass(frozen=True, eq=False)
class _Energy:
    """The symmetric Dirichlet energy of layouts of one patch."""

    triangles: NDArray[np.int64]
    corner: NDArray[np.int64]  # (3, m)
    area: NDArray[np.float64]
    across: NDArray[np.float64]  # (3, 2, m): J = sum over corners of U ⊗ across
    laplacian: _Laplacian

    @staticmethod
    def of(points: NDArray[np.float64], triangles: NDArray[np.int64], importance: NDArray[np.float64]) -> _Energy:
        corners = points[triangles]
        u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        length = np.maximum(np.linalg.norm(u, axis=1), 1e-300)
        x = np.einsum("ij,ij->i", u, v) / length
        y = np.maximum(np.linalg.norm(np.cross(u, v), axis=1) / length, 1e-9 * length)
        zero = np.zeros_like(x)
        # The inverse of the edges (length, 0) and (x, y) as rows, (m, 2, 2): columns of the gradient by the two. It is
        # written out: numpy hands each of them to LAPACK, whose threads wait for each other, minutes beside a solve.
        inverse = np.stack([np.stack([1.0 / length, zero], 1), np.stack([-x / (length * y), 1.0 / y], 1)], axis=1)
        across = np.concatenate([-inverse.sum(axis=2)[:, None], inverse.swapaxes(1, 2)], axis=1)
        area = 0.5 * length * y * importance
        weights = -np.stack([np.einsum("ij,ij->i", across[:, k], across[:, (k + 1) % 3]) for k in range(3)])
        corner, columns = np.ascontiguousarray(triangles.T), np.ascontiguousarray(across.transpose(1, 2, 0))
        return _Energy(triangles, corner, area, columns, _Laplacian.of(triangles, weights * area, points))

    def at(self, layout: Layout) -> tuple[float, Layout]:
        """The energy, infinite where a triangle is turned over, and its gradient (n, 2)."""
        # Written out by components: einsum takes several times as long over matrices as small as these.
        corner = self.corner
        x, y = (np.ascontiguousarray(column) for column in layout.T)
        (xa, xb, xc), (ya, yb, yc) = ([each[c] for c in corner] for each in (x, y))
        (ax, ay), (bx, by), (cx, cy) = self.across
        xx, xy = xa * ax + xb * bx + xc * cx, xa * ay + xb * by + xc * cy  # J by rows
        yx, yy = ya * ax + yb * bx + yc * cx, ya * ay + yb * by + yc * cy
        determinant = xx * yy - xy * yx
        if not (determinant > 0.0).all():
            return np.inf, np.zeros_like(layout)
        squared = (xx * xx + xy * xy) + (yx * yx + yy * yy)
        # ‖J⁻¹‖² = ‖J‖² / det², whose derivative follows by that of det, the cofactors.
        inverse = 1.0 / (determinant * determinant)
        value = float((self.area * squared * (1.0 + inverse)).sum())
        of_length, of_area = 2.0 * (1.0 + inverse), 2.0 * squared * inverse / determinant
        slope_xx, slope_xy = of_length * xx - of_area * yy, of_length * xy - of_area * -yx
        slope_yx, slope_yy = of_length * yx - of_area * -xy, of_length * yy - of_area * xx
        gradient: Layout = np.zeros_like(layout)
        flat = self.triangles.reshape(-1)
        for k, (one, two) in enumerate(((slope_xx, slope_xy), (slope_yx, slope_yy))):
            one, two = self.area * one, self.area * two
            each = np.stack([one * across_x + two * across_y for across_x, across_y in self.across], axis=1)
            gradient[:, k] = np.bincount(flat, each.reshape(-1), len(layout))
        return value, gradient


@dataclass(frozen=True, eq=False)
class _Laplacian:
    """A weighted Laplacian of the edges; solved by conjugate gradients, up to a constant.

    The preconditioner adds what single vertices give and what clusters of them give that move as one.
    """

    ends: NDArray[np.int64]  # of the edges, (2, e)
    weights: NDArray[np.float64]
    diagonal: NDArray[np.float64]
    cluster: NDArray[np.int64]
    coarse: NDArray[np.float64]  # the inverse of the clusters' Laplacian

    @staticmethod
    def of(triangles: NDArray[np.int64], weights: NDArray[np.float64], points: NDArray[np.float64]) -> _Laplacian:
        """Of weights (3, m) of the triangles' edges 01, 12 and 20, each at least a little above 0."""
        edges, inverse, _ = unique_edges(directed_edges(triangles))
        total: NDArray[np.float64] = np.bincount(inverse, 2.0 * weights.reshape(-1), len(edges)).astype(np.float64)
        total = np.maximum(total, 0.05 * float(np.median(np.abs(total))))
        cluster = _clusters(points)
        count = int(cluster.max()) + 1
        one, two = cluster[edges].T
        matrix = np.zeros((count, count))
        np.add.at(matrix, (one, two), -total)
        np.add.at(matrix, (two, one), -total)
        np.fill_diagonal(matrix, 0.0)
        np.fill_diagonal(matrix, -matrix.sum(axis=1))
        coarse = np.linalg.pinv(matrix, rcond=1e-10, hermitian=True)
        return _Laplacian(np.ascontiguousarray(edges.T), total, _degree(edges, total, len(points)), cluster, coarse)

    def _conditioned(self, rest: Layout) -> Layout:
        sums = np.stack([np.bincount(self.cluster, each, len(self.coarse)) for each in rest.T], axis=1)
        return np.asarray(
            rest / np.maximum(self.diagonal, 1e-300)[:, None] + np.take(self.coarse @ sums, self.cluster, axis=0)
        )

    def times(self, values: Layout) -> Layout:
        a, b = self.ends
        product = np.empty_like(values)
        for k, column in enumerate(values.T):
            column = np.ascontiguousarray(column)
            flow = self.weights * (column[a] - column[b])
            product[:, k] = np.bincount(a, flow, len(values)) - np.bincount(b, flow, len(values))
        return product

    def solve(self, right: Layout) -> Layout:
        right = right - right.mean(axis=0)
        found, rest = np.zeros_like(right), right.copy()
        enough = _SOLVED * float(np.linalg.norm(right))
        ahead = self._conditioned(rest)
        size = float((rest * ahead).sum())
        way = ahead
        for _ in range(_MOST_ROUNDS):
            if float(np.linalg.norm(rest)) <= enough:
                break
            product = self.times(way)
            step = size / max(float((way * product).sum()), 1e-300)
            found += step * way
            rest -= step * product
            ahead = self._conditioned(rest)
            before, size = size, float((rest * ahead).sum())
            way = ahead + size / max(before, 1e-300) * way
        return found - found.mean(axis=0)


def _clusters(points: NDArray[np.float64]) -> NDArray[np.int64]:
    """The cluster of each vertex: those in one cell of a grid."""
    low = points.min(axis=0)
    size = float(np.ptp(points, axis=0).max())
    for parts in range(8, 1000, 4):
        place = np.floor((points - low) * (parts / size)).astype(np.int64)
        key = (place[:, 0] * (parts + 1) + place[:, 1]) * (parts + 1) + place[:, 2]
        names, cluster = np.unique(key, return_inverse=True)
        if len(names) >= min(_CLUSTERS, len(points) // 2):
            break
    return cluster.reshape(-1)


def _degree(edges: NDArray[np.int64], weights: NDArray[np.float64], size: int) -> NDArray[np.float64]:
    return np.asarray(np.bincount(edges[:, 0], weights, size) + np.bincount(edges[:, 1], weights, size))


def _tutte(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> Layout:
    """Tutte's embedding with the longest border on the unit circle, by its lengths."""
    loops = sorted(border_loops(triangles), key=lambda loop: -perimeter(points, loop))
    rim = loops[0]
    lengths = np.linalg.norm(points[np.roll(rim, -1)] - points[rim], axis=1)
    turn = 2.0 * np.pi * (np.cumsum(lengths) - lengths) / lengths.sum()
    size = len(points)
    fans = [np.stack([np.roll(loop, -1), loop, np.full(len(loop), size + k)], 1) for k, loop in enumerate(loops[1:])]
    whole = np.concatenate([triangles, *fans])
    edges = unique_edges(directed_edges(whole))[0]
    count = size + len(fans)
    held = np.zeros(count, bool)
    held[rim] = True
    layout = np.zeros((count, 2))
    layout[rim] = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    weights = np.ones(len(edges))
    degree = _degree(edges, weights, count)
    free = ~held
    a, b = edges.T

    def times(values: Layout) -> Layout:
        flow = values[a] - values[b]
        product = np.stack([np.bincount(a, f, count) - np.bincount(b, f, count) for f in flow.T], axis=1)
        product[held] = 0.0
        return product

    rest = -times(layout)
    way = ahead = rest / degree[:, None]
    energy = float((rest * ahead).sum())
    enough = 1e-20 * max(energy, 1e-300)
    for _ in range(20 * int(np.sqrt(count)) + 200):
        product = times(way)
        step = energy / max(float((way * product).sum()), 1e-300)
        layout[free] += step * way[free]
        rest -= step * product
        ahead = rest / degree[:, None]
        before, energy = energy, float((rest * ahead).sum())
        if energy <= enough:
            break
        way = ahead + energy / before * way
    return layout[:size]
