"""Open a skin cache for a plate, and make the plate."""

from __future__ import annotations

from pathlib import Path

from lappet.core.problem import Problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.framing import surgical_field
from lappet.drawing.skin_read import SkinCache
from lappet.drawing.skin_source import FigureError, SkinSource
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.plates.plate_steps import PlateStep, StepKind, plate_steps
from lappet.procedure.plate import Plate
from lappet.usd.plate_prims import read_plates_of
from lappet.usd.procedure_file import CHILD
from lappet.usd.stage import pxr
from lappet.usd.stage_contents import ValueSizes


def open_cache(path: Path, limits: ReadLimits = DEFAULT_LIMITS) -> SkinCache:
    """Open a skin cache.

    Parameters
    ----------
    path
        The cache, as `lappet solve` wrote it.
    limits
        What reading may take.

    Returns
    -------
    SkinCache
        The cache.

    Raises
    ------
    RefusedError
        If the file cannot be read or is no skin cache.
    """
    with ReadingProcess(CHILD, "values", path, limits) as look:
        look.result(ValueSizes)
    try:
        return SkinCache(path)
    except FigureError as error:
        raise refused(ProblemCode.PLATE_CACHE, path, reason=str(error)) from error


def chosen_steps(source: SkinSource, frames: tuple[float, ...] | None = None) -> tuple[PlateStep, ...]:
    """Choose the panels of a plate.

    Parameters
    ----------
    source
        The solved procedure.
    frames
        Time codes of the panels; None for those that tell the operation.

    Returns
    -------
    tuple[PlateStep, ...]
        The panels. Chosen frames that the operation's own steps show keep their captions.

    Raises
    ------
    RefusedError
        If a frame is not in the cache.
    """
    steps = plate_steps(source, surgical_field(source, (source.frames[0],)).normal)
    if frames is None:
        return tuple(steps)
    for time in frames:
        try:
            source.epoch_at(time)
        except FigureError as error:
            raise refused(ProblemCode.PLATE_CACHE, "", time, reason=str(error)) from error
    known = {step.time: step for step in steps}
    return tuple(known.get(time, PlateStep(time, StepKind.FRAME)) for time in frames)


def compared_steps(source: SkinSource) -> tuple[PlateStep, ...]:
    """Choose the panels of a procedure on a plate that compares several.

    Parameters
    ----------
    source
        The solved procedure.

    Returns
    -------
    tuple[PlateStep, ...]
        What is planned, and what comes of it.
    """
    steps = chosen_steps(source)
    return (steps[0], steps[-1]) if len(steps) > 1 else steps


def plate_of(source: SkinCache, name: str, notes: list[Problem]) -> Plate:
    """Read a plate of the procedure that a cache was solved from.

    Parameters
    ----------
    source
        The solved procedure.
    name
        The plate's name.
    notes
        Gets a note of what was converted or left aside.

    Returns
    -------
    Plate
        The plate.

    Raises
    ------
    RefusedError
        If the procedure has no plate of that name, or it cannot be read.
    """
    plates = read_plates_of(source.stage, pxr(), notes)
    for plate in plates:
        if plate.name == name:
            return plate
    known = ", ".join(plate.name for plate in plates) or "none"
    raise refused(ProblemCode.PLATE_UNKNOWN, source.path, name, known=known)
