"""Labels beside a panel with straight leaders of the least total length that cross neither each other nor a text.

Each label takes one of the ports at equal distances on the two sides of the panel (boundary labeling with straight
leaders: Bekos et al. 2007, "Boundary labeling: models and efficient algorithms"). The assignment is solved exactly, as
an integer program: first without conditions, then with those that its solution breaks, until it breaks none.

Labels that a panel before has keep their places: leaving one costs more than a shorter leader saves, and less than a
text over what is drawn. They move where they would cross another or cover something.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, LinearConstraint, linear_sum_assignment, milp
from scipy.sparse import csr_array

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

_ROW = 1.25  # distance of two ports in lines of text
_GAP = 0.4  # between a text and its leader, in lines
_MARGIN = 0.4  # between a text and the panel's side, in lines
_ROUNDS = 60
_ALONG = 4.0  # mm that each sixth of a leader costs which runs along what is taken
_COVERS = 1e3  # mm that a text over what is taken, or over its own leader, costs
_MOVES = 200.0  # mm that a text costs which leaves its place of before: more than all that a shorter leader saves
_STRAYS = 2.0  # times the way by which a leader's begin leaves its place of before


@dataclass(frozen=True, eq=False)
class PlacedLabel:
    """A label beside a panel.

    Parameters
    ----------
    text
        What it says.
    site
        What it names, in mm on paper, shape (2,).
    port
        Where its leader ends, shape (2,).
    left
        Whether it stands at the panel's left side, so that its text begins at the border; otherwise it ends there.
    """

    text: str
    site: NDArray[np.float64]
    port: NDArray[np.float64]
    left: bool


@dataclass(frozen=True, eq=False)
class _Ports:
    """For each label and port: where its leader begins and ends, each (n, p, 2), and its text's box (n, p, 4)."""

    sites: NDArray[np.float64]
    ends: NDArray[np.float64]
    boxes: NDArray[np.float64]
    cost: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Kept:
    """What labels keep free, (k, 2) and (b, 4), and where each was before."""

    taken: NDArray[np.float64]
    texts: NDArray[np.float64]
    before: tuple[PlacedLabel | None, ...]


def place_labels(
    labels: Sequence[tuple[str, NDArray[np.float64]]],
    widths: Sequence[float],
    size: tuple[float, float],
    line: float,
    taken: NDArray[np.float64] | None = None,
    panel: str = "",
    texts: NDArray[np.float64] | None = None,
    before: Mapping[str, PlacedLabel] = MappingProxyType({}),
) -> list[PlacedLabel]:
    """Place labels at the sides of a panel.

    Parameters
    ----------
    labels
        Text of each and the places that it may lead to, in mm from the panel's middle, y downwards, shape (c, 2).
    widths
        Width of each text in mm.
    size
        Width and height of the panel in mm.
    line
        Height of a line of text in mm.
    taken
        Places in mm that no text should cover, shape (k, 2); where there is no other way it does.
    panel
        What the panel is called in a refusal.
    texts
        Boxes of what is written in the panel already (low x, low y, high x, high y), shape (b, 4): neither a label nor
        a leader runs over one where there is another way.
    before
        By their texts, labels of the panel before, which is as large as this one.

    Returns
    -------
    list[PlacedLabel]
        The labels in the same order.

    Raises
    ------
    RefusedError
        If a panel has more labels than it has room for, or a text is wider than half of it.
    """
    if not labels:
        return []
    rows = int(size[1] // (_ROW * line))
    if len(labels) > 2 * rows:
        raise refused(ProblemCode.PLATE_LABELS, panel, len(labels), most=2 * rows)
    wide = int(np.argmax(widths))
    room = 0.5 * size[0] - (_GAP + _MARGIN) * line
    if widths[wide] > room:
        raise refused(ProblemCode.PLATE_LABEL_WIDE, panel, labels[wide][0], room=f"{room:.0f}")
    sites = [np.atleast_2d(np.asarray(site, np.float64)) for _, site in labels]
    kept = _Kept(
        np.zeros((0, 2)) if taken is None else taken,
        np.zeros((0, 4)) if texts is None else texts,
        tuple(before.get(text) for text, _ in labels),
    )
    ports = _ports(sites, np.asarray(widths, np.float64), size, line, rows, kept)
    chosen = _assigned(ports)
    if chosen is None:
        raise refused(ProblemCode.PLATE_LABELS, panel, len(labels), most=len(labels) - 1)
    return [
        PlacedLabel(text, ports.sites[k, port], ports.ends[k, port], bool(port < rows))
        for k, ((text, _), port) in enumerate(zip(labels, chosen, strict=True))
    ]


def _ports(
    sites: Sequence[NDArray[np.float64]],
    widths: NDArray[np.float64],
    size: tuple[float, float],
    line: float,
    rows: int,
    kept: _Kept,
) -> _Ports:
    half = 0.5 * np.asarray(size)
    y = (np.arange(rows) + 0.5) * size[1] / rows - half[1]
    ends, boxes = np.empty((len(sites), 2 * rows, 2)), np.empty((len(sites), 2 * rows, 4))
    for side, sign in enumerate((-1.0, 1.0)):
        half_of = slice(side * rows, (side + 1) * rows)
        outer = sign * (half[0] - _MARGIN * line)
        inner = outer - sign * widths[:, None]
        ends[:, half_of] = np.stack(np.broadcast_arrays(inner - sign * _GAP * line, y), axis=-1)
        low, high = np.minimum(inner, outer), np.maximum(inner, outer)
        boxes[:, half_of] = np.stack(np.broadcast_arrays(low, y - 0.5 * line, high, y + 0.5 * line), axis=-1)
    taken, texts = kept.taken, kept.texts
    begins, cost = np.empty_like(ends), np.empty(ends.shape[:2])
    for k, own in enumerate(sites):
        was = kept.before[k]
        strays = 0.0 if was is None else _STRAYS * np.linalg.norm(own - was.site, axis=1)
        for port in range(2 * rows):
            effort = _effort(own, ends[k, port], taken, line) + _COVERS * _enters(own, ends[k, port], texts) + strays
            best = int(np.argmin(effort))
            begins[k, port], cost[k, port] = own[best], effort[best]
            # A leader that runs back below its own text, and a text over what is taken.
            cost[k, port] += _COVERS * _meets(own[best], ends[k, port], boxes[k, port])
        box = boxes[k][:, None]
        covered = ((taken >= box[..., :2]) & (taken <= box[..., 2:])).all(axis=2)
        over = ((texts[:, :2] <= box[..., 2:]) & (texts[:, 2:] >= box[..., :2])).all(axis=2)
        cost[k] += _COVERS * (covered.any(axis=1) | over.any(axis=1))
        if was is not None:
            away = np.linalg.norm(ends[k] - was.port, axis=1)
            cost[k] += away + _MOVES * (away > 1e-6)
    return _Ports(begins, ends, boxes, cost)


def _effort(
    sites: NDArray[np.float64], end: NDArray[np.float64], taken: NDArray[np.float64], line: float
) -> NDArray[np.float64]:
    """Lengths of leaders from some sites (c, 2) to a port, with what they lose where they run along what is taken."""
    lengths = np.linalg.norm(end - sites, axis=1)
    if not len(taken):
        return lengths
    along = sites[:, None] + np.linspace(0.3, 0.95, 6)[:, None] * (end - sites)[:, None]
    across, down = along[..., None, 0] - taken[:, 0], along[..., None, 1] - taken[:, 1]
    near = np.sqrt((across * across + down * down).min(axis=2)) < 0.3 * line
    effort: NDArray[np.float64] = lengths + _ALONG * near.sum(axis=1)
    return effort


def _enters(sites: NDArray[np.float64], end: NDArray[np.float64], boxes: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the leaders from some sites (c, 2) to a port enter one of some boxes (b, 4), shape (c,)."""
    way = (end - sites)[:, None]
    way = np.where(np.abs(way) < 1e-12, 1e-12, way)
    first, second = ((boxes[:, half] - sites[:, None]) / way for half in (slice(0, 2), slice(2, 4)))
    near = np.minimum(first, second).max(axis=2, initial=0.0)
    far = np.maximum(first, second).min(axis=2, initial=1.0)
    found: NDArray[np.bool_] = (near <= far).any(axis=1)
    return found


def _assigned(ports: _Ports) -> NDArray[np.int64] | None:
    """The port of each label, (n,); None where no assignment keeps all conditions."""
    chosen = linear_sum_assignment(ports.cost)[1]
    count, places = ports.cost.shape
    broken: list[tuple[int, int]] = []
    for _ in range(_ROUNDS):
        fresh = _conflicts(ports, chosen)
        if not fresh:
            found: NDArray[np.int64] = chosen
            return found
        broken += fresh
        each = csr_array(np.kron(np.eye(count), np.ones(places)))
        port = csr_array(np.tile(np.eye(places), count))
        pairs = np.repeat(np.arange(len(broken)), 2)
        not_both = csr_array(
            (np.ones(len(pairs)), (pairs, np.array(broken).ravel())), shape=(len(broken), count * places)
        )
        solved = milp(
            ports.cost.ravel(),
            integrality=np.ones(count * places),
            bounds=Bounds(0.0, 1.0),
            constraints=[
                LinearConstraint(each, 1.0, 1.0),
                LinearConstraint(port, -np.inf, 1.0),
                LinearConstraint(not_both, -np.inf, 1.0),
            ],
        )
        if solved.x is None:
            return None
        chosen = solved.x.reshape(count, places).argmax(axis=1)
    return None


def _conflicts(ports: _Ports, chosen: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Pairs of choices, as label times ports plus port, that cannot both be: their leaders or a text cross."""
    count, places = ports.cost.shape
    own = np.arange(count)
    sites, ends, boxes = ports.sites[own, chosen], ports.ends[own, chosen], ports.boxes[own, chosen]
    found = []
    for a in range(count):
        for b in range(a + 1, count):
            crossing = _cross(sites[a], ends[a], sites[b], ends[b])
            if crossing or _meets(sites[a], ends[a], boxes[b]) or _meets(sites[b], ends[b], boxes[a]):
                found.append((a * places + int(chosen[a]), b * places + int(chosen[b])))
    return found


def _cross(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], d: NDArray[np.float64]) -> bool:
    """Whether the segments ab and cd have a point in common."""

    def side(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    return side(a, b, c) * side(a, b, d) <= 0.0 and side(c, d, a) * side(c, d, b) <= 0.0


def _meets(begin: NDArray[np.float64], end: NDArray[np.float64], box: NDArray[np.float64]) -> bool:
    """Whether a segment enters a box (low x, low y, high x, high y)."""
    way = end - begin
    near, far = 0.0, 1.0
    for axis in (0, 1):
        low, high = box[axis] - begin[axis], box[axis + 2] - begin[axis]
        if abs(way[axis]) < 1e-12:
            if low > 0.0 or high < 0.0:
                return False
            continue
        first, second = sorted((low / way[axis], high / way[axis]))
        near, far = max(near, first), min(far, second)
    return near <= far
