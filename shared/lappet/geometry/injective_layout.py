"""Lay a patch of skin out in the plane so that no triangle turns over, whatever its shape.

Notation: U, the layout, (n, 2); J, the 2 x 2 gradient of U over a triangle laid flat; A, the triangle's area; d, the
determinant of J; C, its cofactors, the derivative of d. The start is Tutte's embedding (1963): the longest border
becomes a circle, holes are closed by a vertex each, and every other vertex is a mean of its neighbors, which turns none
over. From there the symmetric Dirichlet energy

    E = sum of A (‖J‖² + ‖J⁻¹‖²),    ‖J⁻¹‖² = ‖J‖² / d²

is lowered. It is least where lengths are kept and infinite where a triangle is turned over; steps end before the first
one is (Smith and Schaefer 2015). They are Newton's. Where E is not convex, its Hessian is made so triangle by triangle:
of its four eigenvalues only that of the twist can be negative (Smith, de Goes and Kim 2019). The last steps are taken
with the Hessian as it is, until the layout stands still: how a processor rounds sums then makes no difference to it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.geometry.border_loops import border_loops, perimeter
from lappet.geometry.sparse_cholesky import Elimination
from lappet.geometry.surface_check import directed_edges, unique_edges

_MOST_STEPS = 100
_STILL = 1e-9  # of the patch's size: a step of Newton's that moves no vertex farther is the last
_CONVEX = (0.0, 0.01, 0.1, 1.0)  # shares of what makes the Hessian convex; tried from one below the last that did
_SHORT = 0.9  # of the way to where a triangle would have no area
_ENOUGH = 1e-4  # of the decrease that the gradient promises (Armijo)
_ROUNDED = 1e-13  # of the energy: what adding it up loses

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
    elimination = Elimination.of(points, energy.pairs)
    still = _STILL * float(np.ptp(points, axis=0).max())
    value, gradient = energy.at(layout)
    level = len(_CONVEX)
    for _ in range(_MOST_STEPS):
        if not np.isfinite(value):  # a handle, or an edge across that Tutte's embedding makes flat
            break
        direction, level = _newton_step(energy, elimination, layout, gradient, max(level - 1, 0))
        slope = float((direction * gradient).sum())
        length = min(1.0, _SHORT * _room(layout, direction, triangles))
        allowed = _ROUNDED * value
        while True:
            following = layout + length * direction
            lower, ahead = energy.at(following)
            if lower <= value + _ENOUGH * length * slope + allowed or length < 1e-12:
                break
            length *= 0.5
        if not lower <= value + allowed:
            break
        layout, value, gradient = following, lower, ahead
        if level == 0 and length == 1.0 and float(np.abs(direction).max()) <= still:
            break
    return layout


def _newton_step(
    energy: _Energy, elimination: Elimination, layout: Layout, gradient: Layout, level: int
) -> tuple[Layout, int]:
    """The step, and at which of the levels of convexity from this one on the Hessian is positive definite.

    A layout may be moved and turned at no cost: springs hold one vertex, and keep the farthest from turning about it.
    They change nothing of the step but that.
    """
    curvature, twist = energy.curvature(layout)
    away = layout - layout[0]
    far = int(np.linalg.norm(away, axis=1).argmax())
    across = np.array([-away[far, 1], away[far, 0]]) / max(float(np.linalg.norm(away[far])), 1e-300)
    for share in _CONVEX[level:]:
        blocks = energy.assembled(curvature + share * twist if share else curvature)
        stiff = float(np.abs(blocks).mean())
        blocks[energy.diagonal[0]] += stiff * np.eye(2)
        blocks[energy.diagonal[far]] += stiff * np.outer(across, across)
        factor = elimination.factor(blocks)
        if factor is not None:
            return -factor.solve(gradient), level
        level += 1
    return -gradient, level


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
    pairs: NDArray[np.int64]  # vertices that share a triangle, in both orders, and each with itself, (k, 2)
    of_corners: NDArray[np.int64]  # which of the pairs those of each triangle's corners are, (9 m,)
    diagonal: NDArray[np.int64]  # which pair each vertex is with itself, (n,)

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
        corner, columns = np.ascontiguousarray(triangles.T), np.ascontiguousarray(across.transpose(1, 2, 0))
        size = len(points)
        key = (corner[:, None] * size + corner[None, :]).reshape(-1)
        names, of_corners = np.unique(np.concatenate([key, np.arange(size) * (size + 1)]), return_inverse=True)
        pairs = np.stack([names // size, names % size], axis=1)
        of_corners = of_corners.reshape(-1)
        return _Energy(triangles, corner, area, columns, pairs, of_corners[: len(key)], of_corners[len(key) :])

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

    def curvature(self, layout: Layout) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The Hessian by J of each triangle, (2, 2, 2, 2, m), and what makes it positive semidefinite."""
        jacobian = np.zeros((2, 2, len(self.area)))
        for c, a in zip(self.corner, self.across, strict=True):
            jacobian += layout[c].T[:, None] * a[None]
        (xx, xy), (yx, yy) = jacobian
        cofactors = np.array([[yy, -yx], [-xy, xx]])
        d, s = xx * yy - xy * yx, (jacobian * jacobian).sum(axis=(0, 1))
        mixed = jacobian[:, :, None, None] * cofactors
        found = -4.0 / d**3 * (mixed + mixed.transpose(2, 3, 0, 1, 4))
        found += 6.0 * s / d**4 * cofactors[:, :, None, None] * cofactors
        for i, j in np.ndindex(2, 2):
            found[i, j, i, j] += 2.0 + 2.0 / d**2
            found[i, j, 1 - i, 1 - j] -= (1.0 if i == j else -1.0) * 2.0 * s / d**3
        # The twist turns the rotation that J holds by a right angle; its eigenvalue is 2 - 2 (s - d) / d³.
        cosine, sine = xx + yy, yx - xy
        size = np.maximum(np.sqrt(2.0 * (cosine * cosine + sine * sine)), 1e-300)
        twist = np.array([[-sine, -cosine], [cosine, -sine]]) / size
        lacking = np.maximum(2.0 * (s - d) / d**3 - 2.0, 0.0)
        return self.area * found, self.area * lacking * twist[:, :, None, None] * twist

    def assembled(self, curvature: NDArray[np.float64]) -> NDArray[np.float64]:
        """The Hessian by the layout: a block (2, 2) for each of the pairs."""
        a = self.across
        rows = [curvature[None, :, p] * a[:, p, None, None, None] for p in (0, 1)]
        half = rows[0] + rows[1]  # (3, 2, 2, 2, m)
        columns = [half[:, None, :, :, q] * a[None, :, q, None, None] for q in (0, 1)]
        whole = columns[0] + columns[1]  # (3, 3, 2, 2, m)
        size = len(self.pairs)
        each = [np.bincount(self.of_corners, whole[:, :, i, j].reshape(-1), size) for i, j in np.ndindex(2, 2)]
        return np.stack(each, axis=1).reshape(size, 2, 2).astype(np.float64)


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
