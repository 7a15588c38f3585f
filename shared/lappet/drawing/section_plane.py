"""A plane through the solved tissue: where it meets the surface, and what of lines lies before it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Radius = NDArray[np.floating] | float
Lines = list[NDArray[np.float64]]
_NEAR = 1e-5  # mm: a vertex is not nearer to the plane


@dataclass(frozen=True, eq=False)
class SectionPlane:
    """A plane through tissue.

    Parameters
    ----------
    point
        A point of it in mm, shape (3,).
    normal
        Its unit normal, shape (3,); what lies beyond the plane along it is taken away.
    """

    point: NDArray[np.float64]
    normal: NDArray[np.float64]

    @classmethod
    def of(cls, numbers: Sequence[float]) -> SectionPlane:
        """Make the plane of six numbers.

        Parameters
        ----------
        numbers
            A point in mm, and a normal of any length.

        Returns
        -------
        SectionPlane
            The plane.

        Raises
        ------
        ValueError
            If they are not six finite numbers, or the normal is zero.
        """
        point, normal = np.array(numbers[:3], np.float64), np.array(numbers[3:], np.float64)
        length = float(np.linalg.norm(normal))
        if len(numbers) != 6 or not np.isfinite(numbers).all() or length == 0.0:
            raise ValueError("a section is six numbers: a point in mm and a normal that is not zero")
        return cls(point, normal / length)

    @property
    def axes(self) -> NDArray[np.float64]:
        """Two directions (2, 3) in the plane; with the normal they are right-handed."""
        least = np.eye(3)[int(np.argmin(np.abs(self.normal)))]
        first = np.cross(least, self.normal)
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(self.normal, first)])

    def flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Find the coordinates of points in the plane.

        Parameters
        ----------
        points
            Points in mm, shape (..., 3).

        Returns
        -------
        NDArray[np.float64]
            Along `axes` in mm, shape (..., 2).
        """
        return np.asarray((points - self.point) @ self.axes.T)

    def beyond(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Measure how far points lie beyond the plane.

        Parameters
        ----------
        points
            Points in mm, shape (..., 3).

        Returns
        -------
        NDArray[np.float64]
            Distances in mm, shape (...,); negative before it.
        """
        return np.asarray((points - self.point) @ self.normal)

    def outline(
        self, points: NDArray[np.floating], triangles: NDArray[np.integer], values: NDArray[np.floating]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Find where a closed surface meets the plane.

        Parameters
        ----------
        points
            Vertices in mm, shape (n, 3).
        triangles
            Vertex indices, outward, shape (m, 3).
        values
            Values at the vertices, linear between them, shape (n, k).

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]]
            Edges in mm, turned alike, shape (e, 2, 3), and the values at their ends, shape (e, 2, k).
        """
        height = self.beyond(points)
        # Through a vertex, edges would have no length or lie twice upon each other.
        height[np.abs(height) < _NEAR] = -_NEAR
        over = height[triangles] > 0.0
        crossed = np.flatnonzero(over.any(axis=1) & ~over.all(axis=1))
        # Turned so that the corner that lies alone on its side comes first.
        lone = np.where(over[crossed].sum(axis=1) == 1, over[crossed].argmax(axis=1), (~over[crossed]).argmax(axis=1))
        t = triangles[crossed][np.arange(len(crossed))[:, None], (lone[:, None] + np.arange(3)) % 3]
        both = np.concatenate([points, values], axis=1).astype(np.float64)
        ends = []
        for k in (1, 2):
            # From the lower number to the higher, so that neighbors find the same point to the bit.
            a, b = np.minimum(t[:, 0], t[:, k]), np.maximum(t[:, 0], t[:, k])
            share = (height[a] / (height[a] - height[b]))[:, None]
            ends.append((1.0 - share) * both[a] + share * both[b])
        edges = np.stack(ends, axis=1)
        backwards = height[t[:, 0]] > 0.0
        edges[backwards] = edges[backwards, ::-1]
        return edges[..., :3], edges[..., 3:]

    def before(self, lines: Lines, radii: Sequence[Radius]) -> tuple[Lines, list[Radius]]:
        """Cut lines at the plane.

        Parameters
        ----------
        lines
            Lines in mm, each of shape (k, 3).
        radii
            Their radii in mm, one a line or one a point.

        Returns
        -------
        tuple[Lines, list[Radius]]
            What lies before the plane, and its radii.
        """
        kept: Lines = []
        thick: list[Radius] = []
        for line, radius in zip(lines, radii, strict=True):
            each = np.broadcast_to(np.asarray(radius, np.float64), len(line))
            rows = np.column_stack([line, each])
            height = self.beyond(line)
            run: list[NDArray[np.float64]] = [rows[0]] if height[0] <= 0.0 else []
            for k in range(len(line) - 1):
                if (height[k] <= 0.0) != (height[k + 1] <= 0.0):
                    share = height[k] / (height[k] - height[k + 1])
                    run.append((1.0 - share) * rows[k] + share * rows[k + 1])
                    if height[k] <= 0.0:
                        _take(run, kept, thick)
                        run = []
                if height[k + 1] <= 0.0:
                    run.append(rows[k + 1])
            _take(run, kept, thick)
        return kept, thick

    def pierced(self, lines: Lines) -> tuple[Lines, list[int]]:
        """Find where lines pierce the plane.

        Parameters
        ----------
        lines
            Lines in mm, each of shape (k, 3).

        Returns
        -------
        tuple[Lines, list[int]]
            The places in mm, each of shape (1, 3), and the numbers of their lines.
        """
        found, number = [], []
        for index, line in enumerate(lines):
            height = self.beyond(line)
            for k in np.flatnonzero((height[:-1] <= 0.0) != (height[1:] <= 0.0)):
                share = height[k] / (height[k] - height[k + 1])
                found.append(((1.0 - share) * line[k] + share * line[k + 1])[None])
                number.append(index)
        return found, number


def _take(run: list[NDArray[np.float64]], lines: Lines, radii: list[Radius]) -> None:
    if len(run) > 1:
        rows = np.stack(run)
        lines.append(rows[:, :3])
        radii.append(rows[:, 3])
