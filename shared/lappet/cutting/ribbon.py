"""Curves on the skin as ribbons: strips of cross-sections, each of which sweeps a solid without folds.

Notation: p sample on the skin, n skin normal, d direction of a segment in the tangent plane, s = n x d the left side,
theta the turn at a sample, k the kerf.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Place, refused
from lappet.core.problem_code import ProblemCode
from lappet.cutting.blade import along_blade
from lappet.geometry.curve import sample_curve
from lappet.geometry.surface_check import place
from lappet.procedure import Basis, Incision, Point
from lappet.tissue.rest_skin import RestSkin, SkinPoints

_STEP = 1.0  # mm
_MOST_STEPS = 400
_OVERLAP = 0.1  # of the kerf: how far open ends reach on, so that curves that touch are joined at any kerf
_FOLD = 0.45  # of a segment: how far a mitre may reach back before the ribbon is broken at the corner
# Steps between neighbors on the skin from which on the curve went over a ridge between them; so often they are halved.
_JUMP, _RIDGE_ROUNDS = 3.0, 6
_CREASE = np.cos(np.radians(30.0))  # of the angle between their normals: a crease lies between them


@dataclass(frozen=True, eq=False)
class Ribbon:
    """A strip of cross-sections along a curve on the skin.

    The edges of a cross-section are points ± kerf/2 sides.

    Parameters
    ----------
    points
        Middles of the cross-sections in mm, shape (k, 3).
    normals
        Unit normals of the skin there, shape (k, 3).
    sides
        Vectors across the curve, as long as the mitre needs, shape (k, 3).
    depth
        Depth below the skin in mm, shape (k,).
    along
        Arc length from the curve's begin in mm, shape (k,).
    closed
        Whether the last section joins the first.
    length
        Arc length around a closed curve in mm.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    sides: NDArray[np.float64]
    depth: NDArray[np.float64]
    along: NDArray[np.float64]
    closed: bool
    length: float

    def sections(self, kerf: float, above: float) -> NDArray[np.float64]:
        """Find the corners of the cross-sections of what it sweeps.

        Parameters
        ----------
        kerf
            Width of the cut in mm.
        above
            Height over the skin at which they end in mm.

        Returns
        -------
        NDArray[np.float64]
            Left and right above the skin, left and right at its depth, in mm, shape (k, 4, 3).
        """
        half = 0.5 * kerf * self.sides
        top, low = self.points + above * self.normals, self.points - self.depth[:, None] * self.normals
        return np.stack([top + half, top - half, low + half, low - half], axis=1)


@dataclass(frozen=True, eq=False)
class _Path:
    """A stretch of curve on (or just beyond) the skin."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    depth: NDArray[np.float64]
    along: NDArray[np.float64]
    closed: bool
    length: float


def skin_ribbons(
    skin: RestSkin,
    points: tuple[Point, ...],
    *,
    prim: str,
    basis: Basis = "linear",
    closed: bool = False,
    depth: float | None = None,
    kerf: float = Incision.kerf,
    spacing: float = 1.0,
    step: float | None = None,
    direction: Point | None = None,
) -> list[Ribbon]:
    """Make the ribbons of a curve on the skin.

    The curve is sampled and its samples are dropped onto the skin; what lies past the skin's border stays there, and an
    end near the border runs on past it. A curve is broken into several ribbons where it leaves the tissue, turns too
    sharply for a mitre, or meets itself.

    Parameters
    ----------
    skin
        The uncut skin.
    points
        Control points in mm.
    prim
        Path of the prim, for messages.
    basis
        How the curve runs through or beside its points.
    closed
        Whether it returns to its first point.
    depth
        Depth along the skin's normal or the direction in mm, or None for the whole thickness (measured by a ray per
        sample).
    kerf
        Width of the cut in mm.
    spacing
        Lattice spacing in mm.
    step
        Distance of the samples in mm; None for the lattice spacing, at most 1 mm or, for tissue of metres, a 400th of
        the curve.
    direction
        Direction in which the blade goes into the tissue; None for against the skin's normal.

    Returns
    -------
    list[Ribbon]
        The ribbons.

    Raises
    ------
    RefusedError
        If the curve cannot be followed, hovers off the skin, misses the tissue or faces the blade nowhere.
    """
    if not (np.isfinite(kerf) and kerf > 0.0):
        raise refused(ProblemCode.CUT_KERF, prim, f"{kerf:g}")
    if depth is not None and not (np.isfinite(depth) and depth > 0.0):
        raise refused(ProblemCode.CUT_DEPTH, prim, f"{depth:g}")
    if step is None:
        way = np.linalg.norm(np.diff(np.asarray(points, np.float64).reshape(-1, 3), axis=0), axis=1).sum()
        step = min(spacing, max(_STEP, float(way) / _MOST_STEPS))
    samples = sample_curve(points, basis, closed, step, prim)
    placed = skin.locate(samples)
    if direction is None:
        samples, placed = _over_ridges(skin, samples, placed, closed, step)
    # A blade with a direction of its own meets no skin beside a rim: there the curve may be drawn in the air.
    control = np.asarray(points, np.float64) if direction is None else None
    _check_on_skin(skin, control, samples, placed, basis, spacing, prim)
    if direction is not None:
        placed = along_blade(placed, samples, direction, closed, kerf + 0.25 * spacing, prim)
    on, thick = placed.beyond <= 0.0, np.zeros(len(placed.points))
    measure = skin.thickness if direction is None else skin.rolled_thickness
    thick[on] = measure(placed.points[on], placed.normals[on])
    paths = _paths(skin, placed, thick, closed, depth, kerf, spacing, step)
    ribbons = [ribbon for path in paths for ribbon in _unfolded(path, kerf)]
    if not ribbons:
        first, last = place(samples[0]), place(samples[-1])
        at = Place.at(samples[0], samples[-1])
        raise refused(ProblemCode.CUT_NO_LENGTH, prim, first, place=at, first=first, last=last)
    return ribbons


def _over_ridges(
    skin: RestSkin, samples: NDArray[np.float64], placed: SkinPoints, closed: bool, step: float
) -> tuple[NDArray[np.float64], SkinPoints]:
    """Add samples where neighbors dropped onto two sides of a ridge, as of a web of the hand, or of a crease.

    A chord of the curve runs below the ridge, and what is nearest to it jumps from one side to the other. From above,
    what is nearest is the ridge. Below a crease, as beside a nose, the tissue is thicker than on its sides.
    """
    for _ in range(_RIDGE_ROUNDS):
        after = np.arange(1, len(samples) + 1) % len(samples)
        apart = np.linalg.norm(placed.points[after] - placed.points, axis=1)
        on = placed.beyond <= 0.0
        turn = np.einsum("ij,ij->i", placed.normals, placed.normals[after])
        far = (apart > _JUMP * step) | ((apart > step) & (turn < _CREASE))
        jumps = np.flatnonzero(far & on & on[after] & (closed | (after > 0)))
        if not len(jumps):
            break
        upwards = placed.normals[jumps] + placed.normals[after[jumps]]
        upwards /= np.maximum(np.linalg.norm(upwards, axis=1, keepdims=True), 1e-300)
        middles = 0.5 * (placed.points[jumps] + placed.points[after[jumps]]) + 0.5 * apart[jumps, None] * upwards
        samples = np.insert(samples, jumps + 1, skin.locate(middles).points, axis=0)
        placed = skin.locate(samples)
    return samples, placed


def _check_on_skin(
    skin: RestSkin,
    control: NDArray[np.float64] | None,
    samples: NDArray[np.float64],
    placed: SkinPoints,
    basis: Basis,
    spacing: float,
    prim: str,
) -> None:
    reach = max(spacing, 0.02 * float(np.linalg.norm(np.ptp(skin.points, axis=0))))
    near = np.abs(placed.height) <= reach
    if not (near & (placed.beyond == 0.0)).any():
        away = skin.distance(samples)
        at = Place.at(samples[int(away.argmin())])
        raise refused(ProblemCode.CUT_MISSES_TISSUE, prim, f"{float(away.min()):.3g}", place=at)
    if control is None:
        return
    # A chord may dip under a curved skin; the points that the curve passes through may not.
    anchors = {"linear": control, "bezier": control[::3]}.get(basis, samples)
    where = placed if anchors is samples else skin.locate(anchors)
    height = np.abs(where.height)
    off = np.flatnonzero((height > reach) & (where.beyond == 0.0))
    if len(off):
        raise refused(
            ProblemCode.CUT_POINT_OFF_SKIN,
            prim,
            f"{height[off[0]]:.3g}",
            place=Place.at(*anchors[off]),
            where=place(anchors[off[0]]),
            reach=reach,
        )


def _paths(
    skin: RestSkin,
    placed: SkinPoints,
    thick: NDArray[np.float64],
    closed: bool,
    depth: float | None,
    kerf: float,
    spacing: float,
    step: float,
) -> list[_Path]:
    count = len(placed.points)
    on = placed.beyond <= 0.0
    known = np.flatnonzero(thick > 0.0)
    if len(known) == 0:
        return []
    nearest = known[np.abs(np.arange(count)[:, None] - known).argmin(axis=1)]
    thick = thick[nearest]
    run_off = float(thick.max()) + 2.0 * kerf + step
    if depth is None:
        under = _running_max(thick, closed)
        depths = under + np.maximum(0.25 * under, 0.5 * step)
    else:
        depths = np.full(count, depth)

    paths = []
    for run, whole in _runs(placed.beyond <= run_off, closed):
        points, first = _without_repeats(placed.points[run], whole)
        chosen = run[first]
        if len(chosen) < 2 or not on[chosen].any():
            continue
        around = np.vstack([points, points[:1]]) if whole else points
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(around, axis=0), axis=1))])
        path = _Path(points, placed.normals[chosen], depths[chosen], along[: len(points)], whole, float(along[-1]))
        if not whole:
            touch = max(kerf, 0.25 * spacing)
            for at_end in (False, True):
                k = chosen[-1 if at_end else 0]
                beyond = placed.beyond[k]
                if beyond > 0.0 or (beyond == 0.0 and skin.to_border(placed.points[k : k + 1])[0] <= touch):
                    path = _run_off(skin, path, at_end, run_off)
        paths.append(path)
    return paths


def _running_max(values: NDArray[np.float64], closed: bool) -> NDArray[np.float64]:
    padded = np.concatenate([values[-1:], values, values[:1]] if closed else [values[:1], values, values[-1:]])
    return np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])


def _runs(keep: NDArray[np.bool_], closed: bool) -> list[tuple[NDArray[np.int64], bool]]:
    """Index runs of kept samples, cyclic for closed curves; the flag tells a run that is the whole closed curve."""
    n = len(keep)
    if keep.all():
        return [(np.arange(n), closed)]
    shift = int(np.flatnonzero(~keep)[0]) if closed else 0
    order = np.roll(np.arange(n), -shift)
    kept = keep[order]
    starts = np.flatnonzero(kept & ~np.concatenate([[False], kept[:-1]]))
    stops = np.flatnonzero(kept & ~np.concatenate([kept[1:], [False]])) + 1
    return [(order[a:b], False) for a, b in zip(starts, stops, strict=True)]


def _without_repeats(points: NDArray[np.float64], closed: bool) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Drop samples that fell onto their predecessor."""
    gap = np.linalg.norm(np.diff(points, axis=0), axis=1)
    keep = np.concatenate([[True], gap > 1e-9 * (1.0 + np.abs(points).max())])
    if closed and len(points) > 1 and np.allclose(points[0], points[-1], rtol=0.0, atol=1e-9):
        keep[-1] = False
    chosen = np.flatnonzero(keep)
    return points[chosen], chosen


def _run_off(skin: RestSkin, path: _Path, at_end: bool, reach: float) -> _Path:
    """Lengthen a path past the skin's border, if its own direction leads there."""
    a, b = (path.points[-1], path.points[-2]) if at_end else (path.points[0], path.points[1])
    normal = path.normals[-1 if at_end else 0]
    direction = a - b
    direction = direction - np.dot(direction, normal) * normal
    length = float(np.linalg.norm(direction))
    if length == 0.0:
        return path
    tip = a + direction / length * reach
    if skin.locate(tip[None]).beyond[0] <= 0.0:
        return path
    where = len(path.points) if at_end else 0
    edge = -1 if at_end else 0
    return replace(
        path,
        points=np.insert(path.points, where, tip, axis=0),
        normals=np.insert(path.normals, where, normal, axis=0),
        depth=np.insert(path.depth, where, path.depth[edge]),
        along=np.insert(path.along, where, path.along[edge] + (reach if at_end else -reach)),
    )


def _unfolded(path: _Path, kerf: float) -> list[Ribbon]:
    """Ribbons along a path that neither fold at a corner nor overlap themselves."""
    n = len(path.points)
    following = np.roll(path.points, -1, axis=0) - path.points
    lengths = np.linalg.norm(following, axis=1)
    turn = np.zeros(n)
    directions_in, directions_out = np.zeros((n, 3)), np.zeros((n, 3))
    for i in range(n):
        normal = path.normals[i]
        out = following[i] - np.dot(following[i], normal) * normal
        into = following[i - 1] - np.dot(following[i - 1], normal) * normal
        if not path.closed and i == 0:
            into = out
        if not path.closed and i == n - 1:
            out = into
        directions_in[i] = into / max(float(np.linalg.norm(into)), 1e-300)
        directions_out[i] = out / max(float(np.linalg.norm(out)), 1e-300)
        turn[i] = np.arccos(np.clip(np.dot(directions_in[i], directions_out[i]), -1.0, 1.0))
    shortest = np.minimum(lengths, np.roll(lengths, 1))
    if not path.closed:
        shortest[0], shortest[-1] = lengths[0], lengths[-2]
    breaks = (turn > np.radians(150.0)) | (0.5 * kerf * np.tan(np.minimum(turn, 3.0) / 2.0) > _FOLD * shortest)

    ribbons = []
    for chain, whole, begins, ends in _chains(path, breaks, turn, lengths, kerf):
        into, out = directions_in[chain].copy(), directions_out[chain].copy()
        if not whole:
            into[0], out[-1] = out[0], into[-1]
        sides = np.cross(path.normals[chain], into + out)
        sides /= np.maximum(np.linalg.norm(sides, axis=1, keepdims=True), 1e-300)
        cosine = np.sqrt(np.clip((1.0 + np.einsum("ij,ij->i", into, out)) / 2.0, 0.0, 1.0))
        sides /= np.maximum(cosine, 0.25)[:, None]
        points = path.points[chain].copy()
        if not whole:
            points[0] -= begins * kerf * out[0]
            points[-1] += ends * kerf * into[-1]
        along = path.along[chain]
        ribbons.append(Ribbon(points, path.normals[chain], sides, path.depth[chain], along, whole, path.length))
    return ribbons


def _chains(
    path: _Path, breaks: NDArray[np.bool_], turn: NDArray[np.float64], lengths: NDArray[np.float64], kerf: float
) -> list[tuple[NDArray[np.int64], bool, float, float]]:
    """Vertex chains without folds and self-overlap: (vertices, closed, reach before, reach after), in units of kerf."""
    n = len(path.points)
    segments = n if path.closed else n - 1
    conflicts = _conflicts(path, lengths, kerf, segments)
    if path.closed and not breaks.any() and not conflicts:
        return [(np.arange(n), True, 0.0, 0.0)]
    first = int(np.flatnonzero(breaks)[0]) if path.closed and breaks.any() else 0
    order = (np.arange(segments) + first) % n
    chains: list[tuple[NDArray[np.int64], bool, float, float]] = []
    current: list[int] = []
    broke = bool(breaks[first]) if path.closed else False
    reach = 0.5 if broke else (0.0 if path.closed else _OVERLAP)
    for segment in order.tolist():
        corner = bool(current) and bool(breaks[segment])
        meets = bool(current) and any(other in conflicts.get(segment, ()) for other in current)
        if corner or meets:
            chains.append((np.array([*current, segment]) % n, False, reach, 0.5 if corner else 0.0))
            current, reach = [], 0.5 if corner else 0.0
        current.append(segment)
    last = 0.5 if broke else (0.0 if path.closed else _OVERLAP)
    chains.append((np.array([*current, current[-1] + 1]) % n, False, reach, last))
    if path.closed and len(chains) == 1:  # its two ends would overlap at the one sharp corner: part it where it is flat
        ((chain, _, before, after),) = chains
        at = 1 + int(turn[chain[1:-1]].argmin())
        return [(chain[: at + 1], False, before, 0.5), (chain[at:], False, 0.5, after)]
    return chains


def _conflicts(path: _Path, lengths: NDArray[np.float64], kerf: float, segments: int) -> dict[int, set[int]]:
    """Segments of one path that come nearer to each other than the kerf, without being neighbors along it."""
    start = path.points[:segments]
    end = path.points[(np.arange(segments) + 1) % len(path.points)]
    centers = 0.5 * (start + end)
    found: dict[int, set[int]] = {}
    total = float(lengths[:segments].sum())
    middle = np.concatenate([[0.0], np.cumsum(lengths[:segments])])
    middle = 0.5 * (middle[1:] + middle[:-1])
    for i in range(segments - 1):
        js = np.arange(i + 1, segments)
        apart = middle[js] - middle[i]
        if path.closed:
            apart = np.minimum(apart, total - apart)
        js = js[apart > 2.0 * kerf + 0.5 * (lengths[i] + lengths[js]) + 0.5 * kerf]
        reach = 1.2 * kerf + 0.51 * (lengths[i] + lengths[js])
        js = js[np.linalg.norm(centers[js] - centers[i], axis=1) <= reach]
        if len(js) == 0:
            continue
        near = _segment_distance(start[i], end[i], start[js], end[js]) < 1.1 * kerf
        for j in js[near].tolist():
            found.setdefault(i, set()).add(j)
            found.setdefault(j, set()).add(i)
    return found


def _segment_distance(
    p: NDArray[np.float64], q: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The distance of the segment pq to the segments ab (k, 3) (Ericson, Real-Time Collision Detection, 5.1.9)."""
    u, v, w = q - p, b - a, p - a
    uu, vv = float(u @ u), np.einsum("ij,ij->i", v, v)
    uv, uw, vw = v @ u, w @ u, np.einsum("ij,ij->i", v, w)
    det = uu * vv - uv * uv
    parallel = det <= 1e-12 * uu * vv
    s = np.where(parallel, 0.0, np.clip((uv * vw - vv * uw) / np.where(parallel, 1.0, det), 0.0, 1.0))
    t = (uv * s + vw) / np.maximum(vv, 1e-300)
    clipped = np.clip(t, 0.0, 1.0)
    s = np.where(t == clipped, s, np.clip((uv * clipped - uw) / max(uu, 1e-300), 0.0, 1.0))
    gap = np.linalg.norm((p + s[:, None] * u) - (a + clipped[:, None] * v), axis=1)
    if parallel.any():  # parallel segments: the nearest ends decide
        for point in (p, q):
            r = np.clip(np.einsum("ij,ij->i", point - a, v) / np.maximum(vv, 1e-300), 0.0, 1.0)
            gap = np.where(parallel, np.minimum(gap, np.linalg.norm(point - (a + r[:, None] * v), axis=1)), gap)
    return gap
