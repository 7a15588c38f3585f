"""When the steps of an operation are done, and how the surgeon works."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Schedule:
    """When what is done, as time codes.

    Parameters
    ----------
    incise
        The cuts.
    excise
        The removal of the defect.
    undermine
        The release of the skin around it.
    lift
        The hooks begin to lift the flap.
    carried
        The hooks have laid the flap down.
    donor_from
        The sutures of the donor site begin to draw together.
    donor_to
        The donor site is closed.
    suture_from
        The other sutures begin to draw together.
    suture_to
        All seams are closed.
    let_go
        The hooks are released.
    end
        Last frame.
    trim
        The removal of what is cut out late; it is incised a frame before.
    divide
        The cuts of the second stage; the pedicle is taken out with them.
    rejoin_from
        The sutures of the second stage begin to draw together.
    rejoin_to
        All seams of the second stage are closed.
    thin
        The flap is thinned in a stage of its own.
    """

    incise: float = 2
    excise: float = 4
    undermine: float = 6
    lift: float = 8
    carried: float = 24
    donor_from: float = 24
    donor_to: float = 32
    suture_from: float = 26
    suture_to: float = 37
    let_go: float = 35
    end: float = 40
    trim: float = 34
    divide: float = 42
    rejoin_from: float = 46
    rejoin_to: float = 56
    thin: float = 61


@dataclass(frozen=True)
class Row:
    """A row of sutures.

    Parameters
    ----------
    name
        Name of the row.
    depth
        Depth of the anchors below the skin in mm.
    shift
        Shift of its sutures along the seam, as a share of the distance between two.
    """

    name: str
    depth: float
    shift: float = 0.0


@dataclass(frozen=True)
class Technique:
    """How the surgeon works.

    Parameters
    ----------
    kerf
        Width of the cuts in mm.
    beyond
        How far around the design the skin is undermined in mm; 0 where it is not.
    apart
        Distance from suture to suture in mm.
    margin
        Distance from the first suture of a seam to the seam's end in mm.
    rows
        Rows of sutures; the corners are held in each.
    height
        Height to which the hooks lift the flap in mm.
    inside
        Distance from a flap's corner to its hook in mm.
    stiffness
        Stiffness of the hooks in mN/mm.
    follow
        Distance between two points of an edge that are measured in mm.
    runs
        Whether the sutures of a seam, or of several in a row, are one event: a suture run.
    """

    kerf: float = 0.05
    beyond: float = 15.0
    apart: float = 2.8
    margin: float = 2.0
    rows: tuple[Row, ...] = (Row("deep", 3.2), Row("dermal", 0.6, 0.5), Row("skin", 0.0))
    height: float = 10.0
    inside: float = 2.0
    stiffness: float = 300.0
    follow: float = 1.0
    runs: bool = False
