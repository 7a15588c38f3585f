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
    """An event of the procedure as far as pictures need it.

    Parameters
    ----------
    kind
        Its kind, such as "Incision"; a suture run is a Suture here.
    name
        Its prim's name.
    start
        Time code at which it begins.
    end
        Time code at which it ends.
    stitches
        How many stitches a suture run has.
    """

    kind: str
    name: str
    start: float
    end: float
    stitches: int = 1


@dataclass(frozen=True, eq=False)
class SkinEpoch:
    """The skin of one epoch: constant topology, its own frames.

    Parameters
    ----------
    name
        Its name.
    triangles
        Vertex indices, shape (m, 3), int32.
    origin
        An index into `ORIGINS` for each triangle, shape (m,), uint8.
    st
        Texture coordinates of the corners, shape (m, 3, 2), float32; None where there are none.
    frames
        The time codes at which this epoch is shown.
    prim
        The prim of a cache.
    lining
        Which triangles are underside with nothing below it, as of a lip, shape (m,), bool; None for none.
    """

    name: str
    triangles: NDArray[np.int32]
    origin: NDArray[np.uint8]
    st: NDArray[np.float32] | None
    frames: tuple[float, ...]
    prim: Any = None
    lining: NDArray[np.bool_] | None = None


@dataclass(frozen=True, eq=False)
class Strands:
    """Sutures or hooks at one frame.

    Parameters
    ----------
    ends
        Both ends of each in mm, shape (n, 2, 3), float32.
    active
        Which of them hold the tissue, shape (n,), bool.
    """

    ends: NDArray[np.float32]
    active: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class VesselLine:
    """A piece of a vessel at one frame.

    Parameters
    ----------
    kind
        The vessel's kind, such as "artery".
    points
        The line in mm, shape (k, 3).
    radius
        In mm.
    divided
        Whether its begin and its end were cut.
    """

    kind: str
    points: NDArray[np.float64]
    radius: float
    divided: tuple[bool, bool]


class SkinSource(Protocol):
    """A solved procedure, frame by frame; positions in mm.

    Epochs, frames and events are in order of time; `frames` are those that can be asked for.
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
        """Find the epoch that is shown at a frame.

        Parameters
        ----------
        time
            A time code.

        Returns
        -------
        SkinEpoch
            The epoch.

        Raises
        ------
        FigureError
            If there is no such frame.
        """

    def positions(self, epoch: SkinEpoch, time: float) -> NDArray[np.float32]:
        """Return the vertices of an epoch at one of its frames.

        Parameters
        ----------
        epoch
            The epoch.
        time
            Time code of the frame.

        Returns
        -------
        NDArray[np.float32]
            Positions in mm, shape (n, 3).

        Raises
        ------
        FigureError
            If the frame has no whole positions.
        """

    def scalar(self, epoch: SkinEpoch, name: str, time: float) -> NDArray[np.float32] | None:
        """Return a quantity of the vertices.

        Parameters
        ----------
        epoch
            The epoch.
        name
            One of `SCALARS`.
        time
            Time code of the frame.

        Returns
        -------
        NDArray[np.float32] or None
            Its values, shape (n,), stress and tension in kPa; None where it is not known.
        """

    def sutures(self, time: float) -> Strands:
        """Return the sutures of the procedure at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        Strands
            Their ends.
        """

    def threads(self, time: float) -> dict[int, NDArray[np.float64]]:
        """Return the bites of the sutures that have more than two and are active at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        dict[int, NDArray[np.float64]]
            The bites in mm, shape (k, 3) each, by the suture's index.
        """

    def hooks(self, time: float) -> Strands:
        """Return the hooks of the procedure at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        Strands
            The anchor on the tissue and the target of each.
        """

    def hook_courses(self) -> dict[int, NDArray[np.float64]]:
        """Return where the hooks' ends on the tissue go.

        Returns
        -------
        dict[int, NDArray[np.float64]]
            Their places in mm, shape (k, 3) each, by the hook's index, for those that are ever active.
        """

    def rest(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        """Return the vertices of an epoch at rest, or at the first frame where those are not known.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        NDArray[np.float32]
            Positions in mm, shape (n, 3).
        """

    def depth(self, epoch: SkinEpoch) -> NDArray[np.float32]:
        """Return how deep below the skin before any cut the vertices lie.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        NDArray[np.float32]
            Depths in mm, shape (n,); 0 on the skin. Below its edge where a source knows no more.
        """

    @property
    def layers(self) -> TissueLayers:
        """The layers of the tissue; one of skin where they are not known."""

    def column(self, epoch: SkinEpoch) -> NDArray[np.int32]:
        """Return the columns of layers that the triangles of an epoch lie in.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        NDArray[np.int32]
            The columns, shape (m,); the first where they are not known.
        """

    def vessels(self, time: float) -> list[VesselLine]:
        """Return the pieces of vessels at a frame.

        Parameters
        ----------
        time
            Time code of the frame.

        Returns
        -------
        list[VesselLine]
            The pieces.
        """

    def suture_apart(self, epoch: SkinEpoch, index: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Find where a suture's lips are easy to tell apart.

        Parameters
        ----------
        epoch
            The epoch.
        index
            The suture's index.

        Returns
        -------
        tuple[NDArray[np.float32], NDArray[np.float32]]
            The skin's vertices there in mm, shape (n, 3), and the suture's ends, shape (2, 3).
        """

    def suture_closed(self, epoch: SkinEpoch, index: int) -> float:
        """Find the last frame of an epoch at which a suture is active.

        Parameters
        ----------
        epoch
            The epoch.
        index
            The suture's index.

        Returns
        -------
        float
            Time code of the frame.
        """

    def planned_incisions(self, step: float) -> list[NDArray[np.float64]]:
        """Sample the incisions at rest, without those of a second stage.

        Parameters
        ----------
        step
            Distance between samples in mm.

        Returns
        -------
        list[NDArray[np.float64]]
            Polylines in mm, shape (k, 3) each; closed ones repeat their first point.
        """

    def undermined_areas(self, step: float) -> list[NDArray[np.float64]]:
        """Sample the outlines of the undermined areas at rest.

        Parameters
        ----------
        step
            Distance between samples in mm.

        Returns
        -------
        list[NDArray[np.float64]]
            Polylines in mm, shape (k, 3) each, which repeat their first point.
        """
