"""The deep tissue under the skin, seen through an open wound: the underside at rest, a little deeper."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_fields import RIM, UNDERSIDE, WOUND_WALL, vertex_normals
from lappet.drawing.skin_source import SkinEpoch, SkinSource
from lappet.geometry.closest_point import ClosestPoint

BED_GAP = 0.35
REACH = 18.0  # mm around the wound; farther away nothing can be seen of it
_CELL = 1.0
_STILL = 0.1  # mm
_SPREAD = 3  # rings of neighbors that give way together


class DeepBed:
    """The bed of a procedure; it gives way where the skin sinks, so that it never shows through closed skin.

    `rest` are its vertices in mm, shape (b, 3), `triangles` their indices, shape (t, 3), int32, outward; both are empty
    where there is no underside, or nothing below it. `source` may be changed for one of equal epochs.

    Parameters
    ----------
    source
        The solved procedure.
    """

    def __init__(self, source: SkinSource) -> None:
        self.source = source
        epoch = source.epochs[0]
        points = source.rest(epoch)
        below = epoch.origin == UNDERSIDE
        if epoch.lining is not None:
            below = below & ~epoch.lining
        faces = epoch.triangles[below]
        faces = faces[self._near_wounds(points[faces].mean(axis=1))] if len(faces) else faces
        # At the tissue's cut rim it would look out from under it.
        inner = ~np.isin(faces, epoch.triangles[epoch.origin == RIM]).any(axis=1)
        faces = faces[inner] if inner.any() else faces
        used, corners = np.unique(faces, return_inverse=True)
        corners = corners.reshape(-1, 3)
        self.triangles = corners[:, ::-1].astype(np.int32)
        self.rest = points[used].astype(np.float64)
        self._down = vertex_normals(points, epoch.triangles, epoch.origin, UNDERSIDE)[used].astype(np.float64)
        self._base = (self.rest + BED_GAP * self._down).astype(np.float32)
        box = self.rest if len(used) else np.zeros((1, 3))
        self._low, self._high = box.min(axis=0) - REACH, box.max(axis=0) + REACH
        self._lower: dict[str, tuple[NDArray[np.int32], NDArray[np.float32]]] = {}
        every = np.arange(len(used))
        self._vertices = ClosestPoint(self.rest, np.stack([every] * 3, axis=1)) if len(used) else None
        count = max(len(used), 1)
        ways = ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2))
        own = np.arange(len(used)) * (count + 1)
        pairs = np.unique(np.concatenate([own, *(corners[:, a] * count + corners[:, b] for a, b in ways)]))
        self._ring, self._begin = pairs % count, np.searchsorted(pairs // count, np.arange(len(used)))
        self._cells, self._nearest = np.zeros(0, np.int64), np.zeros(0, np.int64)

    def __len__(self) -> int:
        return len(self.rest)

    def positions(self, time: float) -> NDArray[np.float32]:
        """Find where the bed lies under the skin of a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        NDArray[np.float32]
            Its vertices in mm, shape (b, 3).
        """
        epoch = self.source.epoch_at(time)
        lower, rest = self.underside(epoch)
        now = self.source.positions(epoch, time)[lower]
        # What lies where it lay does not press on the bed.
        away = now - rest
        now = now[np.einsum("ij,ij->i", away, away) > _STILL**2]
        now = now[((now >= self._low) & (now <= self._high)).all(axis=1)].astype(np.float64)
        if not len(now):
            return self._base
        below = np.zeros(len(self.rest))
        nearest = self._closest(now)
        np.maximum.at(below, nearest, np.einsum("ij,ij->i", now - self.rest[nearest], self._down[nearest]))
        for _ in range(_SPREAD):
            below = np.maximum.reduceat(below[self._ring], self._begin)
        pressed = np.flatnonzero(below)
        placed = self._base.copy()
        placed[pressed] += (below[pressed, None] * self._down[pressed]).astype(np.float32)
        return placed

    def underside(self, epoch: SkinEpoch) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
        """Find what may press on the bed in an epoch; found once.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        tuple[NDArray[np.int32], NDArray[np.float32]]
            Vertex indices of the underside, shape (u,), and their places at rest in mm, shape (u, 3).
        """
        if epoch.name not in self._lower:
            lower = np.unique(epoch.triangles[epoch.origin == UNDERSIDE])
            self._lower[epoch.name] = lower, self.source.rest(epoch)[lower]
        return self._lower[epoch.name]

    def _near_wounds(self, middles: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Which of some places (t, 3) lie within `REACH` of where a wound will be, box by box."""
        walls = [self.source.rest(e)[np.unique(e.triangles[e.origin == WOUND_WALL])] for e in self.source.epochs[1:]]
        wound = np.concatenate([w for w in walls if len(w)]) if any(len(w) for w in walls) else None
        if wound is None:
            return np.ones(len(middles), bool)
        near: NDArray[np.bool_] = ((middles >= wound.min(axis=0) - REACH) & (middles <= wound.max(axis=0) + REACH)).all(
            axis=1
        )
        return near

    def _closest(self, points: NDArray[np.float64]) -> NDArray[np.int64]:
        """The bed's vertex closest to the middle of the cell of 1 mm in which each point lies."""
        cell = np.floor(points / _CELL).astype(np.int64)
        key = ((cell[:, 0] + (1 << 20)) << 42) | ((cell[:, 1] + (1 << 20)) << 21) | (cell[:, 2] + (1 << 20))
        seen, first, back = np.unique(key, return_index=True, return_inverse=True)
        at = np.atleast_1d(np.searchsorted(self._cells, seen))
        known = np.zeros(len(seen), bool)
        inside = at < len(self._cells)
        known[inside] = self._cells[at[inside]] == seen[inside]
        if not known.all():
            assert self._vertices is not None
            fresh = self._vertices.query((cell[first[~known]] + 0.5) * _CELL)[0]
            cells = np.concatenate([self._cells, seen[~known]])
            order = np.argsort(cells)
            self._cells, self._nearest = cells[order], np.concatenate([self._nearest, fresh])[order]
            at = np.atleast_1d(np.searchsorted(self._cells, seen))
        found: NDArray[np.int64] = self._nearest[at[back]]
        return found
