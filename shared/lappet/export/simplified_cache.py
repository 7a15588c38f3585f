"""A skin cache with fewer triangles: `lappet export --simplify`.

Vertices are some of the cache's own, and each epoch keeps one mesh over its frames, so that what is animated stays so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.skin_fields import SKIN
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError, SkinEpoch
from lappet.export.export_request import ExportRequest
from lappet.export.simplified_mesh import simplified_triangles, surface_distance
from lappet.export.simplify_target import SimplifyTarget

_UNBOUNDED = 1e9  # mm
_TRIES = 16
_TIGHTER = 0.7


@dataclass(frozen=True, eq=False)
class _Kept:
    """What is kept of an epoch: vertices and the column of each face, and how far its surface is from the cache's."""

    whole: SkinEpoch
    epoch: SkinEpoch
    vertices: NDArray[np.int64]
    column: NDArray[np.int32]
    error: float


class SimplifiedCache(SkinCache):
    """A skin cache of which some vertices are kept.

    Parameters
    ----------
    source
        The whole cache.
    kept
        What is kept of each epoch, by its name.
    """

    def __init__(self, source: SkinCache, kept: Mapping[str, _Kept]) -> None:
        super().__init__(source.path, source.stage)
        self._source, self._kept = source, kept
        self._epochs = tuple(kept[each.name].epoch for each in source.epochs if each.name in kept)
        self._frames = tuple(sorted({time for epoch in self._epochs for time in epoch.frames}))
        self._at_rest = source._at_rest  # which epochs have a rest is what the whole cache finds when it reads that

    def positions(self, epoch: SkinEpoch, time: float) -> NDArray[np.float32]:
        kept = self._kept[epoch.name]
        return self._source.positions(kept.whole, time)[kept.vertices]

    def rest(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        kept = self._kept[epoch.name]
        return self._source.rest(kept.whole)[kept.vertices]

    def scalar(self, epoch: SkinEpoch, name: str, time: float) -> NDArray[np.float32] | None:
        kept = self._kept[epoch.name]
        values = self._source.scalar(kept.whole, name, time)
        return None if values is None else values[kept.vertices]

    def depth(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        kept = self._kept[epoch.name]
        return self._source.depth(kept.whole)[kept.vertices]

    def column(self, epoch: SkinEpoch) -> NDArray[np.int32]:
        return self._kept[epoch.name].column


def simplified(cache: SkinCache, frames: Sequence[float], request: ExportRequest) -> SkinCache:
    """Simplify the skin of a cache, where a request asks for that, and tell how far it then is from it.

    Parameters
    ----------
    cache
        The cache.
    frames
        Time codes of the frames that are exported.
    request
        Has the option `simplify`, a `SimplifyTarget`.

    Returns
    -------
    SkinCache
        The simplified cache, or the cache as it is.

    Raises
    ------
    RefusedError
        If a mesh cannot be simplified so far, cannot be read, or meshoptimizer is not installed.
    """
    target: SimplifyTarget | None = request.options.get("simplify")
    if target is None:
        return cache
    try:
        kept = [_keep(cache, epoch, frames, target) for epoch in cache.epochs]
    except FigureError as error:
        raise refused(ProblemCode.EXPORT_CACHE, cache.path, reason=str(error)) from error
    shown = [each for each in kept if set(each.whole.frames) & set(frames)]
    left = max(len(each.epoch.triangles) for each in shown)
    if target.triangles is not None and left > target.triangles:
        raise refused(ProblemCode.EXPORT_SIMPLIFY, cache.path, target.triangles, least=left)
    before = max(len(each.whole.triangles) for each in shown)
    away = f"{max(each.error for each in shown):.3f}"
    request.note(problem(ProblemCode.EXPORT_SIMPLIFIED, request.target, away, left=left, before=before))
    return SimplifiedCache(cache, {each.whole.name: each for each in kept})


def fitting_triangles(vertices: float) -> int:
    """Find how many triangles a skin of so many vertices has, for what `--simplify` is to be told.

    Parameters
    ----------
    vertices
        How many vertices there may be.

    Returns
    -------
    int
        The triangles, rounded down to two digits: a little less than two for each vertex of a closed surface.
    """
    count = 1.9 * vertices
    digit = 10.0 ** (np.floor(np.log10(max(count, 10.0))) - 1.0)
    return int(count // digit * digit)


def _keep(cache: SkinCache, epoch: SkinEpoch, frames: Sequence[float], target: SimplifyTarget) -> _Kept:
    own = [time for time in epoch.frames if time in frames]
    if not own:  # it is not shown, and what is drawn below the others is found from all of it
        return _Kept(epoch, epoch, np.arange(len(cache.rest(epoch))), cache.column(epoch), 0.0)
    rest = cache.rest(epoch)
    states = np.stack([rest, *(cache.positions(epoch, time) for time in own)])
    corner = _Corners.of(cache, epoch)
    most = 0 if target.triangles is None else target.triangles
    allowed = _UNBOUNDED if target.error_mm is None else target.error_mm
    measure, faces, error = allowed, corner.triangles, 0.0
    for _ in range(_TRIES if most < len(epoch.triangles) else 0):
        faces = simplified_triangles(corner.triangles, corner.vertex, states, most, measure)
        error = _error(states[1:], epoch.triangles, corner.vertex[faces], allowed)
        if error <= allowed:
            break
        # The quadrics measure squares that are averaged over areas, and not the greatest distance.
        measure *= min(_TIGHTER, allowed / error)
    else:
        faces, error = corner.triangles, 0.0
    vertices, index = np.unique(corner.vertex[faces], return_inverse=True)
    made = replace(
        epoch,
        triangles=index.reshape(-1, 3).astype(np.int32),
        origin=corner.origin[faces[:, 0]],
        lining=corner.lining[faces[:, 0]],
        st=None if corner.st is None else corner.st[faces],
    )
    return _Kept(epoch, made, vertices, corner.column[faces[:, 0]], error)


def _error(
    states: NDArray[np.float32], triangles: NDArray[np.int32], faces: NDArray[np.int64], allowed: float
) -> float:
    """The greatest distance over the states; it is no longer measured once it is more than is allowed."""
    worst = 0.0
    for points in states[::-1]:  # the last ones are farthest from rest
        worst = max(worst, surface_distance(points, triangles, faces))
        if worst > allowed:
            break
    return worst


@dataclass(frozen=True, eq=False)
class _Corners:
    """The vertices of a mesh, divided where its faces have other labels, columns of layers or texture coordinates."""

    triangles: NDArray[np.int32]
    vertex: NDArray[np.int64]
    origin: NDArray[np.uint8]
    column: NDArray[np.int32]
    lining: NDArray[np.bool_]
    st: NDArray[np.float32] | None

    @staticmethod
    def of(cache: SkinCache, epoch: SkinEpoch) -> _Corners:
        corners = epoch.triangles.ravel().astype(np.int64)
        origin, column = np.repeat(epoch.origin, 3), np.repeat(cache.column(epoch), 3)
        lining = np.zeros(len(corners), bool) if epoch.lining is None else np.repeat(epoch.lining, 3)
        st = None if epoch.st is None else np.ascontiguousarray(epoch.st.reshape(-1, 2), np.float32)
        # Texture coordinates of other faces print nothing, and would divide them everywhere.
        printed = np.zeros((len(corners), 2), np.float32) if st is None else np.where(origin[:, None] == SKIN, st, 0.0)
        keys = np.column_stack([corners, origin, column, lining, (printed + 0.0).view(np.int32)])
        _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        triangles = index.reshape(-1, 3).astype(np.int32)
        kept = None if st is None else st[first]
        return _Corners(triangles, corners[first], origin[first], column[first], lining[first], kept)
