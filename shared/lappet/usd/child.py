"""The process that reads USD files of others: `python -m lappet.usd.child`, see `lappet.foreign.reading_child`."""

from __future__ import annotations

import sys
from pathlib import Path

from lappet.foreign.limits import ReadLimits
from lappet.foreign.reading_child import serve
from lappet.usd.stage import read_here
from lappet.usd.stage_procedure import StageProcedure


def read_stage_procedure(file: Path, limits: ReadLimits, _: str) -> StageProcedure:
    """Read the procedure of a stage.

    Parameters
    ----------
    file
        The file.
    limits
        What reading may take.

    Returns
    -------
    StageProcedure
        The procedure.
    """
    return read_here(file, limits)


READERS = {"procedure": read_stage_procedure}

if __name__ == "__main__":
    serve(READERS, sys.argv[1:])
