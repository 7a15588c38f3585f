"""The second stage of an operation: a flap that was carried and sewn in is cut from its pedicle.

It is told from another operation that follows by a hook, which holds the pedicle until it is cut.
"""

from __future__ import annotations

from collections.abc import Sequence

from lappet.drawing.skin_source import StepEvent

CUTS = ("Incision", "Excision", "Undermine")
PULLS = ("Hook", "Retractor")


def second_stage_from(events: Sequence[StepEvent]) -> float:
    """Find when a second stage begins.

    Parameters
    ----------
    events
        The events of the procedure.

    Returns
    -------
    float
        Time code of its first cut: one at which a hook or retractor lets go, when all sutures begun before it are
        closed. Infinite where there is none.
    """
    held = {e.end for e in events if e.kind in PULLS}
    sutures = [e for e in events if e.kind == "Suture"]
    sewn = min((e.start for e in sutures), default=float("inf"))
    first = min(
        (e.start for e in events if e.kind in CUTS and e.start > sewn and e.start in held), default=float("inf")
    )
    return float("inf") if any(e.start < first < e.end for e in sutures) else first
