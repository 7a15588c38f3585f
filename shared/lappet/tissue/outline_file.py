"""Read an outline that was drawn on the skin from a JSON file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS
from lappet.foreign.regular_file import refuse_irregular
from lappet.tissue.surgical_field import Outline

_MOST_BYTES = 1 << 20


def read_outline(path: Path) -> Outline:
    """Read an outline: a list of points, each of three numbers in mm, in order around the field.

    Parameters
    ----------
    path
        A JSON file.

    Returns
    -------
    Outline
        The outline.

    Raises
    ------
    RefusedError
        If the file is missing, or holds no such list.
    """
    if not path.exists() or path.is_dir():
        raise refused(ProblemCode.FILE_MISSING, path, what="an outline")
    refuse_irregular(path, DEFAULT_LIMITS)
    with path.open("rb") as stream:
        data = stream.read(_MOST_BYTES + 1)
    if len(data) > _MOST_BYTES:
        raise refused(ProblemCode.OUTLINE_NO_POINTS, path, f"more than {_MOST_BYTES} bytes")
    try:
        points = np.asarray(json.loads(data), np.float64)
    except (ValueError, TypeError, RecursionError) as error:
        raise refused(ProblemCode.OUTLINE_NO_POINTS, path, str(error).splitlines()[0]) from error
    if points.ndim != 2 or points.shape[1] != 3 or len(points) < 3 or not np.isfinite(points).all():
        raise refused(ProblemCode.OUTLINE_NO_POINTS, path, f"an array of the shape {points.shape}")
    return Outline(tuple((float(x), float(y), float(z)) for x, y, z in points))
