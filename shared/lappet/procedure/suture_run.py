"""A run of sutures: two edges of a wound, and how they are sewn together, as one event.

`lappet.suturing` makes the single stitches of it. All points are material (rest) coordinates in mm; times are USD time
codes; stiffness is in mN/mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Literal

from lappet.procedure.exact_values import Point, double_point, set_fields, single_points
from lappet.procedure.plain_text import number

SutureMode = Literal["exact", "thread"]
SuturePattern = Literal[
    "interrupted",
    "simple",
    "running",
    "verticalMattress",
    "horizontalMattress",
    "halfBuriedMattress",
    "deepDermal",
    "figureOfEight",
]
SutureOrder = Literal["halving", "forward", "together"]

BESIDE = 0.035
"""Distance of a bite from the edge of a wound in mm where none is given: in the wall of a usual cut."""

DRAWN = 0.9
"""Share of the length at which the edges just meet to which threads are drawn: soft skin gives way at the bites."""


@dataclass(frozen=True)
class SutureLayer:
    """A layer in which a run is sewn.

    Parameters
    ----------
    name
        Its name, as "deep" or "skin"; part of the names of its stitches.
    depth
        Depth of its stitches below the skin in mm; 0: on the skin.
    between
        Whether its stitches lie between those of the other layers, half a distance further.
    """

    name: str = "skin"
    depth: float = 0.0
    between: bool = False

    def __post_init__(self) -> None:
        set_fields(self, depth=float(self.depth) + 0.0)


SKIN_LAYER = SutureLayer()
"""The layer of stitches on the skin."""


@dataclass(frozen=True)
class SutureRun:
    """A run of sutures that sews two edges of a wound together, from start to end.

    The stitches pair points of both edges at equal shares of their lengths, so that edges of unequal length come
    together without a fold at the end. Corners that meet divide the edges: each stretch between two is divided on its
    own, and a stitch lies in every corner.

    Parameters
    ----------
    name
        Name of the event, unique in the procedure; its stitches are `name/1`, or `name/skin/1` in several layers.
    edges
        Points along both edges on the skin in mm, each of shape (n, 3), kept in single precision; the first points of
        the edges meet, and the last.
    start
        Time code at which the first stitches begin to draw together.
    sides
        The side on which the tissue of each edge lies: 1 to the left of the edge's direction, -1 to the right. By
        default the edges run along a cut, the first to its left.
    corners
        Pairs of numbers of points of the first and the second edge that meet, in order along the edges; of an end too
        where a stitch lies in it.
    duration
        How many time codes it takes to draw all of them together.
    spacing
        Distance from stitch to stitch in mm, along the mean of both edges, at least.
    margin
        Distance from the ends, and from corners, to the next stitch in mm; None for half a distance between stitches.
    bite
        Distance of the bites from the edges in mm; None for what is usual of the pattern.
    layers
        The layers in which it is sewn.
    pattern
        What each stitch does: "interrupted" holds one point of each edge, the others are threads as
        `lappet.procedure.stitches` makes them, on the skin; stitches in a depth are interrupted, or deep dermal.
    pass_depth
        Depth in which the thread of a pattern crosses the wound in mm.
    order
        "halving": the corners and the middle first, then the middles of the halves, and so on; "forward": from the
        start on; "together": all at once.
    mode
        "exact" or "thread", of interrupted stitches; those of other patterns are threads.
    thread
        A thread of `lappet.procedure.threads.THREADS`, or "" for the stiffness.
    stiffness
        Stiffness of a thread that is none from the shelf in mN/mm.
    drawn
        Share of the length at which the edges just meet to which threads are drawn.
    tension
        Tension in mN with which threads are drawn at most, or 0 for as much as it takes.
    pull_through
        Tension in mN at which a thread cuts through the tissue; 0 for what the thread has.
    insides
        For each corner a point in mm toward which its tissue lies beside the first edge, and one beside the second,
        kept in single precision; none: where the edges halve it.
    """

    kind: ClassVar[str] = "SutureRun"
    name: str
    edges: tuple[tuple[Point, ...], tuple[Point, ...]]
    start: float
    sides: tuple[int, int] = (1, -1)
    corners: tuple[tuple[int, int], ...] = ()
    duration: float = 8.0
    spacing: float = 4.0
    margin: float | None = None
    bite: float | None = None
    layers: tuple[SutureLayer, ...] = (SKIN_LAYER,)
    pattern: SuturePattern = "interrupted"
    pass_depth: float = 2.0
    order: SutureOrder = "halving"
    mode: SutureMode = "exact"
    thread: str = ""
    stiffness: float = 1000.0
    drawn: float = DRAWN
    tension: float = 0.0
    pull_through: float = 0.0
    insides: tuple[tuple[Point, Point], ...] = ()

    def __post_init__(self) -> None:
        first, second = (single_points(edge) for edge in self.edges)
        corners = tuple((int(one), int(other)) for one, other in self.corners)
        sides = (int(self.sides[0]), int(self.sides[1]))
        insides = tuple((pair[0], pair[1]) for pair in (single_points(each) for each in self.insides))
        set_fields(
            self, edges=(first, second), corners=corners, sides=sides, layers=tuple(self.layers), insides=insides
        )

    @property
    def lengths(self) -> tuple[float, float]:
        """Lengths of both edges at rest in mm."""
        first, second = (sum((math.dist(a, b) for a, b in pairwise(edge)), 0.0) for edge in self.edges)
        return first, second

    @property
    def middle(self) -> Point:
        """The middle of the points of both edges in mm, (0, 0, 0) where there are none."""
        points = [*self.edges[0], *self.edges[1]]
        count = max(len(points), 1)
        return double_point([sum(point[axis] for point in points) / count for axis in range(3)])


def describe_run(run: SutureRun) -> str:
    """Describe a run in a few words with units.

    Parameters
    ----------
    run
        The run.

    Returns
    -------
    str
        A part of a sentence.
    """
    first, second = run.lengths
    layers = " and ".join(
        layer.name if layer.depth == 0.0 else f"{number(layer.depth)} mm deep" for layer in run.layers
    )
    order = {"halving": ", by halving", "forward": ", from the start on", "together": ", all at once"}
    hold = "closed exactly"
    if run.pattern != "interrupted" or run.mode != "exact":
        hold = f"{run.thread or f'{number(run.stiffness)} mN/mm'}, drawn to {number(100.0 * run.drawn)} %"
    corners = f", {len(run.corners)} corner{'s' if len(run.corners) > 1 else ''}" if run.corners else ""
    return (
        f"edges of {number(first)} and {number(second)} mm{corners}, {pattern_words(run.pattern)} every "
        f"{number(run.spacing)} mm, {layers}{order.get(run.order, '')}, {hold}"
    )


def pattern_words(pattern: str) -> str:
    """Write the name of a pattern as people say it.

    Parameters
    ----------
    pattern
        The pattern, as "verticalMattress".

    Returns
    -------
    str
        The words, as "vertical mattress".
    """
    return "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in pattern)
