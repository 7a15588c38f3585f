"""The plane in which a design is drawn: its axes, and its points once they are placed on the skin."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.flap_design import Edge, Excised, Spot
from lappet.procedure import Point
from lappet.tissue.placement import Place


def skin_axes(direction: ArrayLike, normal: ArrayLike, what: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Find the unit vectors of a design: along its direction, made square to the normal, and across it, to its left.

    Parameters
    ----------
    direction
        Direction of the design along the skin, shape (3,).
    normal
        Outwards from the skin, shape (3,).
    what
        Name of the design, for the message of an error.

    Returns
    -------
    tuple[NDArray[np.float64], NDArray[np.float64]]
        Unit vectors along and across, each of shape (3,).

    Raises
    ------
    RefusedError
        If the direction stands upright on the skin or a vector has no length.
    """
    up = np.asarray(normal, np.float64)
    along = np.asarray(direction, np.float64)
    up = up / max(float(np.linalg.norm(up)), 1e-300)
    flat = along - np.dot(along, up) * up
    size = float(np.linalg.norm(flat))
    if not size > 1e-9 * float(np.linalg.norm(along)) or not np.isfinite(flat).all():
        raise refused(ProblemCode.DESIGN_DIRECTION, what, tuple(along.tolist()))
    flat = flat / size
    return flat, np.cross(up, flat)


def require_lengths(what: str, **lengths: float) -> None:
    """Refuse lengths of a design that are not positive.

    Parameters
    ----------
    what
        Name of the design, for the message of the error.
    **lengths
        Lengths in mm by their names.

    Raises
    ------
    RefusedError
        If one of them is not positive and finite.
    """
    for name, value in lengths.items():
        if not (np.isfinite(value) and value > 0.0):
            raise refused(ProblemCode.LENGTH_NOT_POSITIVE, what, f"{value:g}", name=name)


def placed_on(points: NDArray[np.float64], project: Place | None) -> tuple[Point, ...]:
    """Place a design's points on the skin.

    Parameters
    ----------
    points
        Points in mm, shape (k, 3).
    project
        Maps points (k, 3) onto the skin, or None to leave them.

    Returns
    -------
    tuple[Point, ...]
        K points in mm.
    """
    placed = points if project is None else project(points)
    return tuple((float(x), float(y), float(z)) for x, y, z in placed)


@dataclass(frozen=True, eq=False)
class DesignPlane:
    """The plane in which a design is drawn, and how it lies on the skin.

    Parameters
    ----------
    origin
        Where the middle of the design lies in mm, shape (3,).
    along
        Unit vector on the skin of the plane's x, shape (3,).
    across
        Unit vector on the skin of the plane's y, shape (3,).
    middle
        Middle of the design in the plane in mm, shape (2,).
    mirrored
        Whether `across` is mirrored, so that left and right change places.
    project
        Maps points (k, 3) onto the skin, or None to leave them.
    """

    origin: NDArray[np.float64]
    along: NDArray[np.float64]
    across: NDArray[np.float64]
    middle: NDArray[np.float64]
    mirrored: bool
    project: Place | None

    @classmethod
    def at(
        cls,
        center: ArrayLike,
        axes: tuple[NDArray[np.float64], NDArray[np.float64]],
        mirrored: bool,
        project: Place | None,
        middle: ArrayLike = (0.0, 0.0),
    ) -> DesignPlane:
        """Lay a design's plane on the skin.

        Parameters
        ----------
        center
            Where the middle of the design lies in mm, shape (3,).
        axes
            Unit vectors along and across the design, as `skin_axes` gives them.
        mirrored
            Whether the design is mirrored about the axis along it.
        project
            Maps points (k, 3) onto the skin, or None to leave them.
        middle
            Middle of the design in the plane in mm, shape (2,).

        Returns
        -------
        DesignPlane
            The plane.
        """
        along, across = axes
        origin, middle = np.asarray(center, np.float64), np.asarray(middle, np.float64)
        return cls(origin, along, -across if mirrored else across, middle, mirrored, project)

    def points(self, flat: NDArray[np.float64]) -> tuple[Point, ...]:
        """Place points of the plane on the skin.

        Parameters
        ----------
        flat
            Points of the plane in mm, shape (k, 2).

        Returns
        -------
        tuple[Point, ...]
            K points in mm.
        """
        xy = flat - self.middle
        return placed_on(self.origin + xy[:, :1] * self.along + xy[:, 1:] * self.across, self.project)

    def point(self, flat: ArrayLike) -> Point:
        """Place one point of the plane on the skin.

        Parameters
        ----------
        flat
            The point in mm, shape (2,).

        Returns
        -------
        Point
            The point in mm.
        """
        return self.points(np.asarray(flat, np.float64)[None])[0]

    def spot(self, corner: ArrayLike, towards: ArrayLike) -> Spot:
        """Place a corner of the cut skin.

        Parameters
        ----------
        corner
            The corner in the plane in mm, shape (2,).
        towards
            A point of the plane in mm towards which its tissue lies, shape (2,).

        Returns
        -------
        Spot
            The corner.
        """
        return Spot(self.point(corner), self.point(towards))

    def edge(self, flat: NDArray[np.float64], side: int) -> Edge:
        """Place an edge of a cut on the skin.

        Parameters
        ----------
        flat
            Points of the plane along the edge in mm, shape (k, 2).
        side
            1 where its tissue lies to the left in the plane, -1 to the right.

        Returns
        -------
        Edge
            The edge.
        """
        return Edge(self.points(flat), -side if self.mirrored else side)

    def edge_beside(self, flat: NDArray[np.float64], tissue: ArrayLike) -> Edge:
        """Place an edge of a cut on the skin, told where its tissue lies.

        Parameters
        ----------
        flat
            Points of the plane along the edge in mm, shape (k, 2).
        tissue
            A point of the plane in mm in the tissue beside the edge's middle, shape (2,).

        Returns
        -------
        Edge
            The edge.
        """
        k = min(len(flat) // 2, len(flat) - 2)
        run, beside = flat[k + 1] - flat[k], np.asarray(tissue, np.float64) - flat[k]
        return self.edge(flat, 1 if run[0] * beside[1] - run[1] * beside[0] > 0.0 else -1)

    def excised(self, name: str, flat: NDArray[np.float64], seed: ArrayLike, late: bool = False) -> Excised:
        """Place what is cut out on the skin.

        Parameters
        ----------
        name
            Name of the cut.
        flat
            Points of the plane around it in mm, in either sense, shape (k, 2).
        seed
            A point of the plane in its middle in mm, shape (2,).
        late
            Whether it is cut out after the seams of the donor site are closed.

        Returns
        -------
        Excised
            What is cut out.
        """
        turned = np.roll(flat, -1, axis=0)
        area = float(np.sum(flat[:, 0] * turned[:, 1] - flat[:, 1] * turned[:, 0]))
        outline = self.outline(flat if area > 0.0 else flat[::-1])
        return Excised(name, outline, self.point(seed), late)

    def outline(self, flat: NDArray[np.float64]) -> tuple[Point, ...]:
        """Place a closed curve on the skin, counter-clockwise about the normal.

        Parameters
        ----------
        flat
            Points of the plane in mm, counter-clockwise, shape (k, 2).

        Returns
        -------
        tuple[Point, ...]
            K points in mm.
        """
        placed = self.points(flat)
        return placed[::-1] if self.mirrored else placed
