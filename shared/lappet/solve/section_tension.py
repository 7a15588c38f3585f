"""The force across each section of the tissue, and that per length of the skin which the section crosses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lappet.daemon.solved_frame import SolvedFrame
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.program.program import Program


@dataclass(frozen=True)
class SectionTension:
    """The force across one section in one frame, a row of the table.

    Parameters
    ----------
    time
        Time code.
    section
        Label of the section.
    force_mn
        Length of the force in mN.
    force_x_mn, force_y_mn, force_z_mn
        The force of what lies beyond the section, where its normal points, on what lies before it in mN.
    across_mn
        Its part along the section's normal at rest in mN: positive where the tissue is pulled.
    skin_length_mm
        Length of the line in which the section crosses the skin, as it is now.
    tension_n_per_mm
        `across_mn` per that length in N/mm; None where the section crosses no skin.
    """

    time: float
    section: str
    force_mn: float
    force_x_mn: float
    force_y_mn: float
    force_z_mn: float
    across_mn: float
    skin_length_mm: float
    tension_n_per_mm: float | None


def section_tensions(program: Program, frames: Sequence[tuple[int, SolvedFrame]]) -> list[SectionTension]:
    """Measure the sections in some frames.

    Parameters
    ----------
    program
        The program.
    frames
        Frames of it, each with the index of its epoch.

    Returns
    -------
    list[SectionTension]
        A row for each section in each frame.
    """
    if not program.sections:
        return []
    lines = {
        epoch.index: [
            SkinLine.of(epoch.surface, point, normal)
            for point, normal in zip(epoch.boundary.section_points, epoch.boundary.section_normals, strict=True)
        ]
        for epoch in program.epochs
    }
    normals = {epoch.index: epoch.boundary.section_normals for epoch in program.epochs}
    rows = []
    for epoch, frame in frames:
        for k, (label, force) in enumerate(zip(program.sections, frame.section_forces, strict=True)):
            normal = normals[epoch][k] / np.linalg.norm(normals[epoch][k])
            across, length = float(force @ normal), lines[epoch][k].length(frame.points.astype(np.float64))
            tension = across / 1000.0 / length if length > 0.0 else None
            x, y, z = force.tolist()
            size = float(np.linalg.norm(force))
            rows.append(SectionTension(frame.time, label, size, x, y, z, across, length, tension))
    return rows


@dataclass(frozen=True, eq=False)
class SkinLine:
    """The line in which a plane at rest crosses the skin, piece by piece.

    Parameters
    ----------
    ends
        The surface's edges that both ends of each piece lie on, shape (p, 2, 2).
    share
        Where on the edges they lie, 0 to 1, shape (p, 2).
    """

    ends: NDArray[np.int64]
    share: NDArray[np.float64]

    @classmethod
    def of(cls, surface: Surface, point: NDArray[np.float64], normal: NDArray[np.float64]) -> SkinLine:
        """Find the line of a plane.

        Parameters
        ----------
        surface
            The surface at rest.
        point
            A point of the plane in mm, shape (3,).
        normal
            Its normal, shape (3,).

        Returns
        -------
        SkinLine
            The line.
        """
        beyond = (surface.points - point) @ normal >= 0.0
        height = (surface.points - point) @ normal
        triangles = surface.triangles[surface.origin == FaceOrigin.SKIN].astype(np.int64)
        edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)  # (m, 3, 2)
        crossed = beyond[edges[..., 0]] != beyond[edges[..., 1]]
        cut = crossed.sum(axis=1) == 2
        ends = edges[cut][crossed[cut]].reshape(-1, 2, 2)
        first, second = height[ends[..., 0]], height[ends[..., 1]]
        return cls(ends, first / (first - second))

    def length(self, points: NDArray[np.float64]) -> float:
        """Measure the line.

        Parameters
        ----------
        points
            Where the surface's points are now in mm, shape (n, 3).

        Returns
        -------
        float
            Its length in mm.
        """
        first, second = points[self.ends[..., 0]], points[self.ends[..., 1]]
        places = first + self.share[..., None] * (second - first)
        return float(np.linalg.norm(places[:, 1] - places[:, 0], axis=1).sum())
