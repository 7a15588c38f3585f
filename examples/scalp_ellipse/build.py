"""Builds scalp_ellipse.usda: an ellipse of 30 x 10 mm excised from the scalp of a real head and closed.

The tissue is the part of the outer skin of FreeSurfer's average head (which comes with the Python package MNE) inside a
sphere over the right parietal bone, thickened inwards to 5 mm.

Usage: pip install 'lappet[examples]', then python build.py [scalp_ellipse.usda]
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from lappet.designs import Fusiform, fusiform
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.triangulation import triangulate
from lappet.procedure import (
    Event,
    Excision,
    Hook,
    Incision,
    Landmark,
    Point,
    Procedure,
    Suture,
    Tissue,
    Undermine,
)
from lappet.tissue.presets import SKIN
from lappet.tissue.tissue_from_mesh import new_tissue
from lappet.usd.stage import write_procedure

LENGTH, WIDTH, THICKNESS = 30.0, 10.0, 5.0  # mm
ABOVE = (45.0, -35.0, 90.0)  # mm: the design lies on the skin closest to this point, on the right parietal scalp
REACH = 45.0  # mm: radius of the sphere around the design that cuts the tissue out of the head
SPACING, RESOLUTION = 1.25, 2.5  # mm: edges of the lattice's cells and of the skin's triangles
KERF = 0.05
BEYOND = 14.0  # mm that the scalp is undermined beyond the wound
INCISE, EXCISE, UNDERMINE, LIFT, PULL, END = 2, 4, 6, 7, 9, 26  # time codes
TIED, SPREAD = 22, 4  # when the middle is tied; the tips so many frames later
RELEASE = 15  # of the hooks
STITCHES, BURIED = 2.0, 1.5  # mm between the stitches on the skin and between the sutures of each buried row, or so
MEASURED = 19  # points of each edge to follow, besides the tips
EDGE = 0.15  # mm from the cut to a point on the skin
GALEA, DERMIS = 3.9, 1.5  # mm below the skin: the buried rows of sutures, on the wound wall


def point(xyz: NDArray[np.float64]) -> Point:
    """A tuple of floats, rounded so that every machine writes the same file."""
    return (round(float(xyz[0]), 4), round(float(xyz[1]), 4), round(float(xyz[2]), 4))


def head() -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The outer skin of the head: points (2033, 3) in mm and triangles (4062, 3). Raises ImportError without MNE."""
    import mne

    file = Path(mne.__file__).parent / "data" / "fsaverage" / "fsaverage-head.fif"
    surface = mne.read_bem_surfaces(file, verbose=False)[0]
    return 1000.0 * np.asarray(surface["rr"], np.float64), np.asarray(surface["tris"], np.int64)


def scalp(spacing: float) -> tuple[Tissue, list[str]]:
    """The tissue within REACH of the design, and what `lappet new` says about it."""
    points, triangles = head()
    middle = ClosestPoint(points, triangles).query([ABOVE])[1][0]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "fsaverage-head.ply"
        trimesh.Trimesh(points, triangles, process=False).export(file)
        tissue, found = new_tissue(
            file, THICKNESS, sphere=(point(middle), REACH), spacing=spacing, units="mm", resolution=RESOLUTION
        )
    rounded = np.round(tissue.points, 4)
    return replace(tissue, points=rounded, uv=None if tissue.uv is None else np.round(tissue.uv, 5)), found.lines


@dataclass(frozen=True)
class Skin:
    """The outer surface of the tissue, to place the design on."""

    surface: ClosestPoint
    normals: NDArray[np.float64]

    @classmethod
    def of(cls, tissue: Tissue) -> Skin:
        """The faces that are neither rim nor underside."""
        outer = np.ones(len(tissue.face_vertex_counts), bool)
        for name in ("fixed", "bed"):
            outer[tissue.subsets[name]] = False
        counts, indices = tissue.face_vertex_counts.astype(np.int64), tissue.face_vertex_indices.astype(np.int64)
        triangles, _, faces = triangulate(tissue.points, counts, indices)
        triangles = triangles[outer[faces]]
        a, b, c = (tissue.points[triangles[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        return cls(ClosestPoint(tissue.points, triangles), normals / np.linalg.norm(normals, axis=1, keepdims=True))

    def place(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """The closest points (k, 3) of the skin."""
        return self.surface.query(points)[1]

    def beside(self, edge: Point, opposite: Point, distance: float, depth: float) -> Point:
        """The point so far from the wound's edge, away from the opposite point, and so deep below the skin, mm."""
        away = np.array(edge) - np.array(opposite)
        face, on_skin, _ = self.surface.query([np.array(edge) + distance * away / np.linalg.norm(away)])
        return point(on_skin[0] - depth * self.normals[face[0]])

    def design(self, pairs: int) -> Fusiform:
        """The fusiform, its long axis from front to back, with so many pairs of facing points."""
        face, middle, _ = self.surface.query([ABOVE])
        return fusiform(
            middle[0],
            LENGTH,
            WIDTH,
            (0.0, 1.0, 0.0),
            normal=self.normals[face[0]],
            sutures=pairs,
            project=self.place,
        )


def sutures(skin: Skin, spacing: float) -> list[Event]:
    """Two buried rows on the wound wall and stitches on the skin; the middle is drawn together first, the tips last.

    They keep apart by 1.2 cells at least: sutures that share a cell's edge contradict each other.
    """
    events: list[Event] = []
    rows = [("galea", BURIED, KERF / 2, GALEA), ("dermis", BURIED, KERF / 2, DERMIS), ("skin", STITCHES, EDGE, 0.0)]
    for row, apart, distance, depth in rows:
        count = round(LENGTH / max(apart, 1.2 * spacing)) - 1
        for i, (left, right) in enumerate(skin.design(count).pairs):
            late = round(SPREAD * abs(2 * i / (count - 1) - 1))  # frames after the middle
            start, tied = PULL + late, TIED + late
            anchors = (skin.beside(left, right, distance, depth), skin.beside(right, left, distance, depth))
            events.append(Suture(f"{row}_{i + 1}", anchors, start=start, duration=tied - start))
    return events


def hooks(skin: Skin) -> list[Event]:
    """Two skin hooks that lift the edges to undermine them, and let go when the sutures have begun to pull."""
    events: list[Event] = []
    left, right = skin.design(1).pairs[0]
    face, middle, _ = skin.surface.query([ABOVE])
    up = skin.normals[face[0]]
    for name, here, there in (("left", left, right), ("right", right, left)):
        anchor = np.array(skin.beside(here, there, 1.5, 0.0))
        inwards = (middle[0] - anchor) / np.linalg.norm(middle[0] - anchor)
        lifted, low = anchor + 6.0 * up + 1.5 * inwards, anchor + 1.0 * up + 2.5 * inwards
        half = 0.3 * anchor + 0.7 * lifted
        path = [(LIFT, anchor), (LIFT + 1, half), (LIFT + 3, lifted), (LIFT + 5, lifted), (RELEASE, low)]
        targets = tuple((time, point(target)) for time, target in path)
        events.append(Hook(f"hook_{name}", point(anchor), targets, start=LIFT, release=RELEASE, stiffness=200.0))
    return events


def landmarks(skin: Skin) -> list[Event]:
    """The two edges as chains of points on the skin from tip to tip, to measure the scar and what still gapes."""
    design = skin.design(MEASURED)
    first, last = design.tips
    ends = skin.beside(first, last, EDGE, 0.0), skin.beside(last, first, EDGE, 0.0)
    left = tuple(skin.beside(a, b, EDGE, 0.0) for a, b in design.pairs)
    right = tuple(skin.beside(b, a, EDGE, 0.0) for a, b in design.pairs)
    return [
        Landmark("left_edge", (ends[0], *left, ends[1]), "left edge"),
        Landmark("right_edge", (ends[0], *right, ends[1]), "right edge"),
    ]


def area(skin: Skin) -> tuple[Point, ...]:
    """The outline of the undermining: an ellipse on the skin, BEYOND outside the wound."""
    face, middle, _ = skin.surface.query([ABOVE])
    along = np.cross(np.cross(skin.normals[face[0]], (0.0, 1.0, 0.0)), skin.normals[face[0]])
    across = np.cross(skin.normals[face[0]], along)
    turn = np.linspace(0.0, 2 * np.pi, 48, endpoint=False)[:, None]
    ellipse = (LENGTH / 2 + BEYOND) * np.cos(turn) * along + (WIDTH / 2 + BEYOND) * np.sin(turn) * across
    return tuple(point(p) for p in skin.place(middle[0] + ellipse))


def build(spacing: float = SPACING) -> Procedure:
    """The whole procedure; spacing: of the lattice, mm. Raises ImportError without MNE."""
    tissue, _ = scalp(spacing)
    skin = Skin.of(tissue)
    design = skin.design(0)
    events: list[Event] = [
        Incision("incision", INCISE, tuple(point(np.array(p)) for p in design.curve), kerf=KERF, closed=True),
        Excision("excision", EXCISE, (point(np.array(design.seed)),)),
        Undermine("undermining", UNDERMINE, area(skin)),
        *hooks(skin),
        *sutures(skin, spacing),
        *landmarks(skin),
    ]
    return Procedure(
        tissue=tissue,
        materials=(SKIN.material,),
        events=tuple(events),
        start_time=1,
        end_time=END,
        fps=12,
    )


if __name__ == "__main__":
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).with_name("scalp_ellipse.usda")
    write_procedure(build(), path)
    print(f"wrote {path}")
