"""What a USD file holds, a procedure or a skin cache, and a look at all of its values before others read them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import ReadLimits
from lappet.usd.stage import open_stage, read_here
from lappet.usd.stage_procedure import StageProcedure

SKIN = "/Procedure/Skin"
_UNFOLDED = 8  # times the size of the files that their values may take, where that is more than the memory


@dataclass(frozen=True)
class SkinCacheNote:
    """What a skin cache says about itself.

    Parameters
    ----------
    spacing
        Lattice spacing in mm with which it was solved, NaN where it is not told.
    last_key
        Key of its last frame, "" where it is not told.
    """

    spacing: float
    last_key: str


@dataclass(frozen=True, eq=False)
class StageContents:
    """What a USD file holds.

    Parameters
    ----------
    read
        The procedure of the file itself, or of the one below a skin cache, as far as it could be read.
    skin
        What a skin cache says about itself, or None for a procedure.
    """

    read: StageProcedure
    skin: SkinCacheNote | None = None


@dataclass(frozen=True)
class ValueSizes:
    """What the values of a stage take.

    Parameters
    ----------
    total
        Bytes of all values at all times.
    """

    total: int


def contents_of(file: Path, limits: ReadLimits) -> StageContents:
    """Read what a USD file holds; the values of a skin cache are looked at and left to its reader.

    Parameters
    ----------
    file
        The file.
    limits
        What `open_stage` may take.

    Returns
    -------
    StageContents
        What it holds.

    Raises
    ------
    RefusedError
        If the file cannot be opened, or its values are far larger than itself.
    """
    stage = open_stage(file, limits)
    if not stage.GetPrimAtPath(SKIN):
        return StageContents(read_here(file, limits))
    _look_at_values(stage, limits)
    layer = stage.GetRootLayer()
    below = [layer.ComputeAbsolutePath(each) for each in layer.subLayerPaths]
    procedure = Path(below[0]) if below else file
    told = dict(layer.customLayerData).get("lappet", {})
    spacing, key = told.get("spacing"), told.get("lastKey", "")
    note = SkinCacheNote(float(spacing) if isinstance(spacing, (int, float)) else float("nan"), str(key))
    return StageContents(read_here(procedure, limits), note)


def value_sizes(file: Path, limits: ReadLimits) -> ValueSizes:
    """Look at every value of a stage, so that whoever reads it afterwards meets nothing unexpected.

    Parameters
    ----------
    file
        The file.
    limits
        What `open_stage` may take.

    Returns
    -------
    ValueSizes
        What the values take.

    Raises
    ------
    RefusedError
        If the file cannot be opened, or its values are far larger than itself.
    """
    return _look_at_values(open_stage(file, limits), limits)


def _look_at_values(stage: Any, limits: ReadLimits) -> ValueSizes:
    """Read every value at every time, one after the other: few bytes of a file may unfold to many."""
    files = [Path(layer.realPath).stat().st_size for layer in stage.GetUsedLayers(True) if layer.realPath]
    most = max(limits.memory, _UNFOLDED * sum(files))
    total = 0
    for prim in stage.TraverseAll():
        for attribute in prim.GetAuthoredAttributes():
            for time in (None, *attribute.GetTimeSamples()):
                value = attribute.Get() if time is None else attribute.Get(time)
                total += np.asarray(value).nbytes
                if total > most:
                    raise refused(ProblemCode.READ_MEMORY, stage.GetRootLayer().realPath, f"{most / 2**30:.3g} GiB")
    return ValueSizes(total)
