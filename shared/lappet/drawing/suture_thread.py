"""Draw the active skin sutures of a frame as simple interrupted stitches that ride on the skin; buried ones hide.

Threads with more than two bites run from each to the next, over the skin where they are outside.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.epoch_searches import EpochSearches
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.skin_source import SkinEpoch, SkinSource
from lappet.drawing.suture_bites import (
    BITE,
    CLOSED_GAP,
    Bite,
    TrianglesNear,
    buried,
    carried,
    find_bites,
    find_lip,
)
from lappet.drawing.suture_path import THREAD_RADIUS, stitch_path
from lappet.drawing.thread_on_skin import laid_on_skin

# Stitches stand no closer: two sutures that hold one corner are its one corner stitch, and a dense row is thinned.
NEAREST = 1.7 * BITE


@dataclass(frozen=True, eq=False)
class Stitch:
    """A suture as it is drawn in one epoch.

    Parameters
    ----------
    bites
        Where it enters the skin.
    crossing
        Where it crosses the closed wound in mm, shape (3,).
    turned
        Whether the first bite belongs to the suture's second end.
    """

    bites: tuple[Bite, Bite]
    crossing: NDArray[np.float64]
    turned: bool


def buried_sutures(source: SkinSource) -> frozenset[int]:
    """Find the sutures that lie in the depth, judged where each is first active.

    Parameters
    ----------
    source
        The solved procedure.

    Returns
    -------
    frozenset[int]
        Their indices.
    """
    found: set[int] = set()
    seen: set[int] = set()
    for time in source.frames:
        sutures = source.sutures(time)
        fresh = [int(i) for i in np.flatnonzero(sutures.active) if int(i) not in seen]
        found.update(i for i in fresh if suture_buried(source, source.epoch_at(time), i))
        seen.update(fresh)
    return frozenset(found)


def suture_buried(source: SkinSource, epoch: SkinEpoch, index: int, near: TrianglesNear | None = None) -> bool:
    """Tell whether a suture lies in the depth, judged in one epoch.

    Parameters
    ----------
    source
        The solved procedure.
    epoch
        The epoch.
    index
        The suture's index.
    near
        The triangles of the epoch at the positions of `source.suture_apart`, if they are sorted already.

    Returns
    -------
    bool
        Whether it does.
    """
    points, anchors = source.suture_apart(epoch, index)
    near = near or TrianglesNear(points, epoch.triangles)
    around = np.unique(np.concatenate([near.around(end, 2.0 * near.longest) for end in anchors]))
    return buried(points, epoch.triangles[around], source.depth(epoch), anchors)


class SutureThread:
    """The stitches of a procedure.

    `until` is the monotonic second after which `tubes` finds no new ones, None: it finds all; then `unfinished` says
    whether some are left.

    Parameters
    ----------
    source
        The solved procedure.
    facing
        The side on which knots are tied, shape (3,).
    scale
        Of bites and thread.
    hidden
        The sutures that are not drawn; None for those that turn out to be buried.
    before
        The stitches of the same epochs seen from another side; what was found of the epochs is kept.
    searches
        What is known of its epochs; None: what `before` knows.
    """

    def __init__(
        self,
        source: SkinSource,
        facing: NDArray[np.float64],
        scale: float,
        hidden: frozenset[int] | None = None,
        before: SutureThread | None = None,
        searches: EpochSearches | None = None,
    ) -> None:
        self._source, self._facing, self._scale, self._hidden = source, facing, scale, hidden
        self._stitches: dict[tuple[str, int], Stitch | None] = {}
        own = EpochSearches() if before is None else before._searches
        self._searches: EpochSearches = own if searches is None else searches
        self._near: dict[str, tuple[NDArray[np.float32], TrianglesNear]] = {} if before is None else before._near
        self.until: float | None = None
        self.unfinished = self._fresh = False

    @property
    def searched(self) -> bool:
        """Whether the last drawing had to find where a stitch bites, which takes long."""
        return self._fresh

    def tubes(self, time: float) -> tuple[list[NDArray[np.float64]], list[float]]:
        """Draw the thread and knots of a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        tuple[list[NDArray[np.float64]], list[float]]
            Lines, shape (k, 3) each, and their radii, in mm.
        """
        lines = list(self.named_lines(time).values())
        return lines, [THREAD_RADIUS * self._scale] * len(lines)

    def named_lines(self, time: float) -> dict[tuple[int, int], NDArray[np.float64]]:
        """Find the thread and knots of a frame and whose they are.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        dict[tuple[int, int], NDArray[np.float64]]
            Lines in mm, shape (k, 3) each, by the index of the suture and the number of the line: 0 is the thread, 1
            the knot's coil, 2 and 3 are its tails.
        """
        self.unfinished = self._fresh = False
        sutures, sliding = self._source.sutures(time), self._source.threads(time)
        lines = self._over_skin(time, sliding)  # the skin hides what runs in the tissue
        active = [
            int(i)
            for i in np.flatnonzero(sutures.active)
            if int(i) not in (self._hidden or ()) and int(i) not in sliding
        ]
        if not active:
            return lines
        epoch = self._source.epoch_at(time)
        until = np.inf if self.until is None else self.until
        shown = self._apart({i: s for i in active if (s := self._find(epoch, i, until)) is not None})
        if not shown:
            return lines
        points = self._source.positions(epoch, time)
        pairs = [bite for stitch in shown.values() for bite in stitch.bites]
        bites = carried(pairs, points).reshape(-1, 2, 3)
        at = np.array([bite.vertices for bite in pairs], np.int64)
        normals = self._searches.normals(epoch, len(points)).at(points, at.ravel()).reshape(-1, 3, 3)
        up = np.einsum("kc,kci->ki", np.array([bite.weights for bite in pairs]), normals)
        up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
        for k, (index, stitch) in enumerate(shown.items()):
            ends = sutures.ends[index][:: -1 if stitch.turned else 1].astype(np.float64)
            tied = bool(np.linalg.norm(ends[1] - ends[0]) <= CLOSED_GAP)
            path = stitch_path(bites[k], ends, up[2 * k : 2 * k + 2], tied, self._scale)
            lines.update(((index, part), line) for part, line in enumerate((path.thread, *path.knot)))
        return lines

    def _over_skin(
        self, time: float, sliding: Mapping[int, NDArray[np.float64]]
    ) -> dict[tuple[int, int], NDArray[np.float64]]:
        """The threads with many bites of a frame."""
        if not sliding:
            return {}
        epoch = self._source.epoch_at(time)
        points, skin = self._source.positions(epoch, time), epoch.triangles[epoch.origin == SKIN]
        lift = 0.5 * THREAD_RADIUS * self._scale
        return {(index, 0): laid_on_skin(bites, points, skin, lift) for index, bites in sliding.items()}

    def _apart(self, stitches: dict[int, Stitch]) -> dict[int, Stitch]:
        """Those that do not stand too close to one before them."""
        kept: dict[int, Stitch] = {}
        crossings = np.zeros((0, 3))
        for index, stitch in stitches.items():
            if not (np.linalg.norm(crossings - stitch.crossing, axis=1) < NEAREST * self._scale).any():
                crossings = np.vstack([crossings, stitch.crossing])
                kept[index] = stitch
        return kept

    def _find(self, epoch: SkinEpoch, index: int, until: float) -> Stitch | None:
        key = (epoch.name, index)
        if key not in self._stitches:
            if self._fresh and monotonic() > until:
                self.unfinished = True
                return None
            self._fresh = True  # one at least is found every time
            points, _ = self._source.suture_apart(epoch, index)
            if epoch.name not in self._near or self._near[epoch.name][0] is not points:
                at_rest = points is self._source.rest(epoch)
                near = self._searches.near(epoch, points) if at_rest else TrianglesNear(points, epoch.triangles)
                self._near[epoch.name] = points, near
            near = self._near[epoch.name][1]
            deep = self._hidden is None and suture_buried(self._source, epoch, index, near)
            self._stitches[key] = None if deep else self._made(epoch, index, near)
        return self._stitches[key]

    def _made(self, epoch: SkinEpoch, index: int, near: TrianglesNear) -> Stitch | None:
        """A stitch, None where there is no skin near an end: of a suture that came to no rest."""
        points, anchors = self._source.suture_apart(epoch, index)
        radius = 2.0 * BITE * self._scale
        lips = []
        for end in anchors:
            around = near.around(end, radius + 3.0 * near.longest)
            if not (epoch.origin[around] == SKIN).any():
                return None
            lips.append(find_lip(points, epoch.triangles[around], epoch.origin[around], end, radius))
        last = self._source.suture_closed(epoch, index)
        closed = self._source.positions(epoch, last)
        ends = self._source.sutures(last).ends[index]
        across = find_bites(closed, (lips[0], lips[1]), ends, BITE * self._scale)
        way = across[1].carried(closed) - across[0].carried(closed)
        turned = bool(way @ self._facing > 0.0)
        bites = (across[1], across[0]) if turned else across
        return Stitch(bites, ends.astype(np.float64).mean(axis=0), turned)
