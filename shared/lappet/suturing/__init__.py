"""Sutures along the edges of a wound: the single stitches of a run.

`single_sutures` replaces the runs of a procedure by their stitches, before the procedure is compiled; the daemon knows
single sutures only.
"""

from __future__ import annotations

from lappet.suturing.single_sutures import with_single_sutures
from lappet.suturing.stitches_of_run import RunStitches, run_stitches

__all__ = ["RunStitches", "run_stitches", "with_single_sutures"]
