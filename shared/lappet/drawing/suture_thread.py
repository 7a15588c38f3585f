"""Draw the active skin sutures of a frame as simple interrupted stitches that ride on the skin; buried ones hide.

Threads with more than two bites run from each to the next, over the skin where they are outside.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

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
from lappet.drawing.suture_path import THREAD_RADIUS, StitchPath, risen, stitch_path
from lappet.drawing.thread_on_skin import laid_on_skin, rises_over_skin

# Stitches stand no closer: two sutures that hold one corner are its one corner stitch, and a dense row is thinned.
NEAREST = 1.7 * BITE
_BESIDE = 0.5  # mm beside the line between the bites: so far skin counts on which a stitch lies


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
    skin
        Vertex indices of the skin around it, shape (k, 3): what it lies on.
    """

    bites: tuple[Bite, Bite]
    crossing: NDArray[np.float64]
    turned: bool
    skin: NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class SutureWork:
    """What has to be known to find where a suture is drawn in an epoch; finding it asks no source.

    Parameters
    ----------
    index
        The suture's index.
    apart
        Positions at which its lips are easy to tell apart in mm, shape (n, 3).
    anchors
        Its ends there in mm, shape (2, 3).
    closed
        Positions of the last frame at which it is active in mm, shape (n, 3).
    ends
        Its ends there in mm, shape (2, 3).
    """

    index: int
    apart: NDArray[np.float32]
    anchors: NDArray[np.float32]
    closed: NDArray[np.float32]
    ends: NDArray[np.float32]


class Pending(Protocol):
    """What a thread finds."""

    @property
    def done(self) -> bool:
        """Whether it is found."""

    def take(self) -> dict[int, Stitch | None]:
        """Return it, by the suture's index."""


Begin = Callable[[Callable[[], dict[int, Stitch | None]]], Pending]


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
    return _lies_deep(epoch, points, anchors, source.depth(epoch), near or TrianglesNear(points, epoch.triangles))


def _lies_deep(
    epoch: SkinEpoch,
    points: NDArray[np.float32],
    anchors: NDArray[np.float32],
    depth: NDArray[np.float32],
    near: TrianglesNear,
) -> bool:
    around = np.unique(np.concatenate([near.around(end, 2.0 * near.longest) for end in anchors]))
    return buried(points, epoch.triangles[around], depth, anchors)


class SutureThread:
    """The stitches of a procedure.

    `begin` has a thread find new stitches, None: `tubes` finds them itself. They are drawn once they are found;
    `pending` is what is still to be waited for.

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
        self.begin: Begin | None = None
        self._begun: tuple[str, Pending] | None = None

    @property
    def pending(self) -> Pending | None:
        """The stitches that a thread is finding."""
        return None if self._begun is None else self._begun[1]

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
        self._find(epoch, active)
        shown = self._apart({i: s for i in active if (s := self._stitches.get((epoch.name, i))) is not None})
        if not shown:
            return lines
        points = self._source.positions(epoch, time)
        pairs = [bite for stitch in shown.values() for bite in stitch.bites]
        bites = carried(pairs, points).reshape(-1, 2, 3)
        at = np.array([bite.vertices for bite in pairs], np.int64)
        normals = self._searches.normals(epoch, len(points)).at(points, at.ravel()).reshape(-1, 3, 3)
        up = np.einsum("kc,kci->ki", np.array([bite.weights for bite in pairs]), normals)
        up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
        paths: dict[int, StitchPath] = {}
        for k, (index, stitch) in enumerate(shown.items()):
            ends = sutures.ends[index][:: -1 if stitch.turned else 1].astype(np.float64)
            tied = bool(np.linalg.norm(ends[1] - ends[0]) <= CLOSED_GAP)
            paths[index] = stitch_path(bites[k], ends, up[2 * k : 2 * k + 2], tied, self._scale)
        between = dict(zip(shown, up[::2] + up[1::2], strict=True))
        paths |= self._risen({i: path for i, path in paths.items() if path.knot}, shown, between, points)
        for index, path in paths.items():
            lines.update(((index, part), line) for part, line in enumerate((path.thread, *path.knot)))
        return lines

    def _risen(
        self,
        paths: Mapping[int, StitchPath],
        stitches: Mapping[int, Stitch],
        between: Mapping[int, NDArray[np.float64]],
        points: NDArray[np.float32],
    ) -> dict[int, StitchPath]:
        """Tied stitches that lie on the skin where it bulges between their bites, all at once.

        between: the sum of the skin's unit normals at the bites of each, shape (3,).
        """
        if not paths:
            return {}
        most = max(len(stitches[i].skin) for i in paths)
        skin = np.zeros((len(paths), most, 3), np.int64)  # what is left over has no area
        for k, i in enumerate(paths):
            skin[k, : len(stitches[i].skin)] = stitches[i].skin
        ups = np.array([between[i] for i in paths])
        ups /= np.maximum(np.linalg.norm(ups, axis=1, keepdims=True), 1e-9)
        threads = np.array([path.thread[1:-1] for path in paths.values()])
        corners = points[skin].astype(np.float64)
        rises = rises_over_skin(threads, corners, ups, THREAD_RADIUS * self._scale, BITE * self._scale)
        return {i: risen(paths[i], rise, up) for i, rise, up in zip(paths, rises, ups, strict=True)}

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

    def _find(self, epoch: SkinEpoch, active: Sequence[int]) -> None:
        """Find what is not known of some sutures, or have it found."""
        if self._begun is not None:
            name, pending = self._begun
            if self.begin is not None and not pending.done:
                return
            self._begun = None
            self._stitches.update({(name, index): found for index, found in pending.take().items()})
        wanted = [self._work(epoch, index) for index in active if (epoch.name, index) not in self._stitches]
        if not wanted:
            return
        rest, depth = self._source.rest(epoch), self._source.depth(epoch)

        def find() -> dict[int, Stitch | None]:
            return {work.index: self._found(epoch, rest, depth, work) for work in wanted}

        if self.begin is not None:
            self._begun = epoch.name, self.begin(find)
        else:
            self._stitches.update({(epoch.name, index): found for index, found in find().items()})

    def _work(self, epoch: SkinEpoch, index: int) -> SutureWork:
        last = self._source.suture_closed(epoch, index)
        closed, ends = self._source.positions(epoch, last), self._source.sutures(last).ends[index]
        return SutureWork(index, *self._source.suture_apart(epoch, index), closed, ends)

    def _found(
        self, epoch: SkinEpoch, rest: NDArray[np.float32], depth: NDArray[np.float32], work: SutureWork
    ) -> Stitch | None:
        """A stitch; None where it lies deep, or has no skin near an end: of a suture that came to no rest."""
        known = self._near.get(epoch.name)
        if known is None or known[0] is not work.apart:
            at_rest = work.apart is rest
            near = self._searches.near(epoch, rest) if at_rest else TrianglesNear(work.apart, epoch.triangles)
            self._near[epoch.name] = known = work.apart, near
        near = known[1]
        if self._hidden is None and _lies_deep(epoch, work.apart, work.anchors, depth, near):
            return None
        radius = 2.0 * BITE * self._scale
        lips = []
        for end in work.anchors:
            around = near.around(end, radius + 3.0 * near.longest)
            if not (epoch.origin[around] == SKIN).any():
                return None
            lips.append(find_lip(work.apart, epoch.triangles[around], epoch.origin[around], end, radius))
        across = find_bites(work.closed, (lips[0], lips[1]), work.ends, BITE * self._scale)
        way = across[1].carried(work.closed) - across[0].carried(work.closed)
        turned = bool(way @ self._facing > 0.0)
        bites = (across[1], across[0]) if turned else across
        skin = np.concatenate([lip.disk for lip in lips])
        skin = skin[_below(work.closed[skin].astype(np.float64), carried(bites, work.closed), _BESIDE * self._scale)]
        return Stitch(bites, work.ends.astype(np.float64).mean(axis=0), turned, skin)


def _below(corners: NDArray[np.float64], ends: NDArray[np.float64], beside: float) -> NDArray[np.bool_]:
    """Which triangles (k, 3, 3) come nearer than a distance (mm) to the line between two points (2, 3)."""
    middle = corners.mean(axis=1)
    size = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
    way = ends[1] - ends[0]
    share = np.clip((middle - ends[0]) @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    away: NDArray[np.float64] = np.linalg.norm(middle - ends[0] - share[:, None] * way, axis=1)
    return away < size + beside
