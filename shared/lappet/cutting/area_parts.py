"""The tissue below an area: the parts of the uncut tissue inside and outside of a closed curve on its skin.

The curve is swept through the whole thickness of the uncut tissue, along the skin's normals, as for a cut; the parts
that this would make are inside where the curve winds around the skin beside their walls (winding number other than 0,
seen along the curve's mean normal).
"""

from __future__ import annotations

import manifold3d
import numpy as np
from numpy.typing import NDArray

from lappet.cutting.incision import cutter
from lappet.cutting.ribbon import Ribbon
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.geometry.solid import Label, LabeledSolid
from lappet.geometry.triangles import area_normals, areas
from lappet.geometry.unique_rows import unique_rows

LINE_KERF = 0.02  # of the lattice spacing: the width of the line that parts inside from outside
# Of the walls of a part, by area: so much may seem to lie on the other side, where the curve has corners. What is on
# both of its sides, and both surrounded and not, hangs together across it.
_BOTH = 0.1
_LINE = "line"


class AreaParts:
    """The parts of the uncut tissue inside and outside of a closed curve.

    Parameters
    ----------
    rest
        The uncut tissue.
    ribbons
        The curve on its skin.
    kerf
        Width of the line that parts inside from outside in mm.
    spacing
        Lattice spacing in mm.
    """

    def __init__(self, rest: LabeledSolid, ribbons: list[Ribbon], kerf: float, spacing: float) -> None:
        self.line = _sheet(ribbons)
        turns = _Turns(ribbons, self.line, kerf)
        # What a cut would make, if that parts the tissue.
        for line in (_cutters, _hulls):
            parts = _parted(rest, line(ribbons, kerf, spacing))
            shares = [turns.shares(part.points[part.triangles[part.grips[_LINE]]]) for part in parts]
            self.is_parted = not any(all(_BOTH < share < 1.0 - _BOTH for share in both) for both in shares)
            if self.is_parted:
                break
        corners, owner, known, known_owner = [], [], [], []
        inside: list[bool] = []
        widths: list[float] = []
        self.within: list[Surface] = []  # the surfaces of the parts inside
        for k, (surface, (around, _)) in enumerate(zip(parts, shares, strict=True)):
            inside.append(around > 0.5)
            if inside[-1]:
                self.within.append(surface)
                under = surface.points[surface.triangles[surface.origin == FaceOrigin.UNDERSIDE]]
                widths.append(float(areas(under).sum()) / max(float(np.ptp(surface.points, axis=0).max()), 1e-300))
            corners.append(surface.points[surface.triangles])
            owner.append(np.full(len(surface.triangles), k))
            known.append(surface.points)
            known_owner.append(np.full(len(surface.points), k))
        self.inside = np.array(inside, bool)
        self.width = max(widths, default=0.0)  # mm, of the widest part inside
        self._owner = np.concatenate(owner)
        soup = np.concatenate(corners)
        self._known, self._known_owner = np.concatenate(known), np.concatenate(known_owner)
        self._closest = ClosestPoint(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))
        chosen = soup[self.inside[self._owner]].reshape(-1, 3)
        margin = 0.01 * spacing
        self._box = (chosen.min(axis=0) - margin, chosen.max(axis=0) + margin) if len(chosen) else None

    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Find the box around what is inside.

        Returns
        -------
        tuple[NDArray[np.float64], NDArray[np.float64]]
            Its lowest and its highest corner in mm, each of shape (3,).
        """
        assert self._box is not None
        return self._box

    def contain(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Tell which points belong to a part inside the curve.

        Parameters
        ----------
        points
            Points in mm, shape (k, 3).

        Returns
        -------
        NDArray[np.bool_]
            Whether each does, shape (k,).
        """
        result = np.zeros(len(points), bool)
        if self._box is not None:
            near = np.flatnonzero(((points >= self._box[0]) & (points <= self._box[1])).all(axis=1))
            # Vertices away from all cuts are the same to the bit; the few others are looked for.
            same = _first_equal(points[near], self._known)
            result[near] = self.inside[self._known_owner[same]]
            other = near[same < 0]
            result[other] = self.inside[self._owner[self._closest.query(points[other])[0]]]
        return result


def _cutters(ribbons: list[Ribbon], kerf: float, above: float) -> tuple[list[manifold3d.Manifold], set[int]]:
    """Solids as of a cut along the curve, and the run ids of their walls."""
    wall = manifold3d.Manifold.reserve_ids(2)
    return [cutter(ribbon, kerf, above, (wall, wall, wall + 1)) for ribbon in ribbons], {wall}


def _hulls(ribbons: list[Ribbon], kerf: float, above: float) -> tuple[list[manifold3d.Manifold], set[int]]:
    """The same as the convex hulls of every two sections.

    On skin that is bent in two directions the walls of a cutter are twisted, and where it is thinner than they sag they
    go through each other: it is inside out there and cuts nothing. Hulls are never inside out.
    """
    made = []
    for ribbon in ribbons:
        sections = ribbon.sections(kerf, above)
        following = np.roll(sections, -1, axis=0) if ribbon.closed else sections[1:]
        pairs = np.concatenate([sections[: len(following)], following], axis=1)
        made += [manifold3d.Manifold.hull_points(pair) for pair in pairs]
    solid = manifold3d.Manifold.batch_boolean(made, manifold3d.OpType.Add).as_original()
    return [solid], {solid.original_id()}


def _parted(rest: LabeledSolid, line: tuple[list[manifold3d.Manifold], set[int]]) -> list[Surface]:
    """The surfaces of the parts that solids along the curve leave; `_LINE` is where their walls cut."""
    solids, walls = line
    left = manifold3d.Manifold.batch_boolean([rest.solid, *solids], manifold3d.OpType.Subtract)
    ids = {int(k) for solid in solids for k in np.asarray(solid.to_mesh().run_original_id)} | walls
    grips = {k: (_LINE,) if k in walls else () for k in ids}
    labels = {**rest.labels, **{k: Label(FaceOrigin.WOUND_WALL, grips=grips[k]) for k in ids}}
    return [LabeledSolid(part, labels, (_LINE,)).surface() for part in left.decompose()]


def _first_equal(points: NDArray[np.float64], known: NDArray[np.float64]) -> NDArray[np.int64]:
    """The first of the known points (n, 3) that each point (k, 3) is equal to; -1 where there is none."""
    _, which = unique_rows(np.concatenate([known, points]))
    first = np.full(int(which.max(initial=-1)) + 1, -1)
    first[which[: len(known)][::-1]] = np.arange(len(known))[::-1]
    return first[which[len(known) :]]


class _Turns:
    """How often the curve winds around the skin on either side of it, seen along its mean normal."""

    def __init__(self, ribbons: list[Ribbon], line: ClosestPoint, kerf: float) -> None:
        self._line, self._kerf = line, kerf
        middles, sides = [], []
        for ribbon in ribbons:
            points, side = ribbon.points, ribbon.sides
            if ribbon.closed:
                points, side = np.vstack([points, points[:1]]), np.vstack([side, side[:1]])
            # Two triangles of the sheet per section, see `_sheet`.
            middles += [0.5 * (points[:-1] + points[1:])] * 2
            sides += [0.5 * (side[:-1] + side[1:])] * 2
        self._middles, self._sides = np.concatenate(middles), np.concatenate(sides)
        frame = _plane(np.vstack([ribbon.normals for ribbon in ribbons]).mean(axis=0))
        curve = np.vstack([ribbon.points for ribbon in ribbons]) @ frame.T
        self._left = _winding((self._middles + kerf * self._sides) @ frame.T, curve)
        self._right = _winding((self._middles - kerf * self._sides) @ frame.T, curve)

    def shares(self, walls: NDArray[np.float64]) -> tuple[float, float]:
        """Shares by area of wall triangles (k, 3, 3): around whose skin the curve winds, and those on the left."""
        if len(walls) == 0:
            return 0.0, 0.0
        normal = area_normals(walls)
        area = np.linalg.norm(normal, axis=1)
        largest = np.argsort(-area, kind="stable")[:64]
        area = area[largest]
        behind = walls[largest].mean(axis=1) - self._kerf * normal[largest] / np.maximum(area, 1e-300)[:, None]
        section, on_line, _ = self._line.query(behind)
        left = np.einsum("ij,ij->i", behind - on_line, self._sides[section]) > 0.0
        turns = np.where(left, self._left[section], self._right[section])
        whole = max(float(area.sum()), 1e-300)
        return float(area[turns != 0].sum()) / whole, float(area[left].sum()) / whole


def _winding(points: NDArray[np.float64], polygon: NDArray[np.float64]) -> NDArray[np.int64]:
    """The winding number of a closed polygon (k, 2) about each point (q, 2)."""
    a = polygon[None] - points[:, None]
    b = np.roll(a, -1, axis=1)
    cross = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    dot = np.einsum("qki,qki->qk", a, b)
    return np.rint(np.arctan2(cross, dot).sum(axis=1) / (2.0 * np.pi)).astype(np.int64)


def _plane(axis: NDArray[np.float64]) -> NDArray[np.float64]:
    """Two unit vectors (2, 3) across an axis."""
    axis = axis / max(float(np.linalg.norm(axis)), 1e-300)
    first = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)])


def _sheet(ribbons: list[Ribbon]) -> ClosestPoint:
    """The curve swept along the normals, as triangles to measure distances to."""
    soup = []
    for ribbon in ribbons:
        top = ribbon.points + ribbon.normals
        low = ribbon.points - ribbon.depth[:, None] * ribbon.normals
        if ribbon.closed:
            top, low = np.vstack([top, top[:1]]), np.vstack([low, low[:1]])
        soup += [
            np.stack([top[:-1], low[:-1], low[1:]], axis=1),
            np.stack([top[:-1], low[1:], top[1:]], axis=1),
        ]
    points = np.concatenate(soup).reshape(-1, 3)
    return ClosestPoint(points, np.arange(len(points)).reshape(-1, 3))
