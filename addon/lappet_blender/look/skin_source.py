"""What the drawing of a solved skin asks of its source: a skin cache (`skin_read.py`) or a `ManifestSource`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import TissueLayers

ORIGINS = ("skin", "woundWall", "underside", "rim")
SCALARS = ("strain", "stress", "tension")


class FigureError(ValueError):
    """A figure cannot be drawn; the message is one sentence for the user."""


@dataclass(frozen=True)
class StepEvent:
    """An event of the procedure as far as pictures need it: its kind, name and the time codes it spans.

    stitches: of a suture run, which is of the kind Suture here, how many it has.
    """

    kind: str
    name: str
    start: float
    end: float
    stitches: int = 1


@dataclass(frozen=True, eq=False)
class SkinEpoch:
    """The skin of one epoch: constant topology, its own frames.

    triangles: (m, 3) int32. origin: (m,) uint8, an index into `ORIGINS`. st: (m, 3, 2) float32 or None. frames: time
    codes at which this epoch is shown. prim: of a cache.
    """

    name: str
    triangles: NDArray[np.int32]
    origin: NDArray[np.uint8]
    st: NDArray[np.float32] | None
    frames: tuple[float, ...]
    prim: Any = None


@dataclass(frozen=True, eq=False)
class Strands:
    """Sutures or hooks at one frame. ends: (n, 2, 3) float32 mm. active: (n,) bool."""

    ends: NDArray[np.float32]
    active: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class VesselLine:
    """A piece of a vessel at one frame. points: (k, 3) mm. radius: mm. divided: whether its begin and end were cut."""

    kind: str
    points: NDArray[np.float64]
    radius: float
    divided: tuple[bool, bool]


class SkinSource(Protocol):
    """A solved procedure, frame by frame; positions in mm.

    epochs, frames and events are in order of time; `frames` are those that can be asked for.
    """

    @property
    def epochs(self) -> tuple[SkinEpoch, ...]:
        """The epochs that have frames."""

    @property
    def frames(self) -> tuple[float, ...]:
        """The time codes of all frames."""

    @property
    def events(self) -> tuple[StepEvent, ...]:
        """The procedure's events."""

    def epoch_at(self, time: float) -> SkinEpoch:
        """The epoch that is shown at a frame; FigureError where there is no such frame."""

    def positions(self, epoch: SkinEpoch, time: float) -> NDArray[np.float32]:
        """Vertex positions (n, 3) of an epoch at one of its frames, mm."""

    def scalar(self, epoch: SkinEpoch, name: str, time: float) -> NDArray[np.float32] | None:
        """A vertex quantity (n,), one of `SCALARS`, or None where it is not known."""

    def sutures(self, time: float) -> Strands:
        """The sutures of the procedure at a frame."""

    def threads(self, time: float) -> dict[int, NDArray[np.float64]]:
        """The bites (k, 3), mm, of the sutures that have more than two and are active at a frame, by their index."""

    def hooks(self, time: float) -> Strands:
        """The hooks of the procedure at a frame: the anchor on the tissue and the target."""

    def hook_courses(self) -> dict[int, NDArray[np.float64]]:
        """Where the hooks' ends on the tissue go, (k, 3) mm by the hook's index, for those that are ever active."""

    def rest(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        """Vertex positions (n, 3) of an epoch at rest, or at the first frame that is known, mm."""

    def depth(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        """How deep below the skin before any cut the vertices (n,) lie, mm; 0 on the skin."""

    @property
    def layers(self) -> TissueLayers:
        """The layers of the tissue."""

    def column(self, epoch: SkinEpoch) -> NDArray[np.int32]:
        """The column of layers that the triangles (m,) of an epoch lie in."""

    def vessels(self, time: float) -> list[VesselLine]:
        """The pieces of vessels at a frame."""

    def suture_apart(self, epoch: SkinEpoch, index: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Positions (n, 3) at which a suture's lips are easy to tell apart, and its ends (2, 3) there, mm."""

    def suture_closed(self, epoch: SkinEpoch, index: int) -> float:
        """The last frame of an epoch at which a suture is active."""

    def planned_incisions(self, step: float) -> list[NDArray[np.float64]]:
        """The incisions at rest, sampled every `step` mm: polylines (k, 3) in mm; closed ones repeat their first."""

    def undermined_areas(self, step: float) -> list[NDArray[np.float64]]:
        """The outlines of the undermined areas at rest, sampled and closed in the same way."""
