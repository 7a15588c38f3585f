"""A procedure whose suture runs are replaced by their stitches."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

from lappet.procedure import Event, Procedure, SutureRun, Tissue
from lappet.suturing.stitches_of_run import run_stitches
from lappet.tissue.skin_sheet import SkinSheet

_known: WeakKeyDictionary[Tissue, SkinSheet] = WeakKeyDictionary()


def skin_of(tissue: Tissue) -> SkinSheet:
    """Take the skin of a tissue, found once for each.

    Parameters
    ----------
    tissue
        The tissue.

    Returns
    -------
    SkinSheet
        Its skin.
    """
    if tissue not in _known:
        _known[tissue] = SkinSheet.of(tissue)
    return _known[tissue]


def with_single_sutures(procedure: Procedure, spacing: float | None = None) -> Procedure:
    """Replace the suture runs of a procedure by their stitches, each in the place of its run.

    Parameters
    ----------
    procedure
        A procedure whose runs have no errors.
    spacing
        Edge of the lattice's cells in mm, where it is not the tissue's own.

    Returns
    -------
    Procedure
        The procedure with single sutures only; itself where it has no run.
    """
    if not any(isinstance(event, SutureRun) for event in procedure.events):
        return procedure
    cell, skin = spacing or procedure.tissue.spacing, skin_of(procedure.tissue)
    events: list[Event] = []
    for event in procedure.events:
        events += run_stitches(event, skin, cell).sutures if isinstance(event, SutureRun) else [event]
    return replace(procedure, events=tuple(events))
