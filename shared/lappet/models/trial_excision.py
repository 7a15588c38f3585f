"""The operation that every model was tried with: a fusiform excision, undermined and closed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from lappet.designs import fusiform
from lappet.models.model import Trial
from lappet.procedure import Event, Excision, Incision, Procedure, Suture, Undermine
from lappet.tissue.skin_sheet import SkinSheet

INCISE, EXCISE, UNDERMINE, CLOSE, END = 2, 3, 4, 5, 12  # time codes
_WIDTH = 1.0 / 3.0  # of the length
_APART = 1.3  # spacings between sutures, at least
_BITE = 0.15  # mm from the edge to a suture


def with_excision(procedure: Procedure, trial: Trial, at: ArrayLike) -> Procedure:
    """Add the trial's excision to the procedure of a model.

    Parameters
    ----------
    procedure
        The procedure of a model.
    trial
        Length and direction of the excision.
    at
        Its middle on the skin in mm or near it, shape (3,).

    Returns
    -------
    Procedure
        The procedure with its operation, twelve frames long.

    Raises
    ------
    RefusedError
        If the design has no place on the skin.
    """
    sheet = SkinSheet.of(procedure.tissue)
    middle, normals = sheet.at(np.asarray(at, np.float64)[None])
    count = max(2, int(trial.length / max(_APART * procedure.tissue.spacing, trial.length / 12.0)) - 1)
    design = fusiform(
        middle[0],
        trial.length,
        _WIDTH * trial.length,
        trial.along,
        normal=normals[0],
        sutures=count,
        project=sheet.place,
    )
    beyond = 2.0 * trial.beyond * trial.length
    around = fusiform(
        middle[0],
        trial.length + beyond,
        _WIDTH * trial.length + beyond,
        trial.along,
        normal=normals[0],
        project=sheet.place,
    )
    events: list[Event] = [
        Incision("wound", INCISE, design.curve, closed=True),
        Excision("piece", EXCISE, (design.seed,)),
        Undermine("skin", UNDERMINE, around.curve),
    ]
    for number, (left, right) in enumerate(design.pairs, start=1):
        late = round(2 * abs(2 * (number - 1) / max(1, count - 1) - 1.0))  # frames after the middle
        away = _BITE * np.subtract(left, right) / np.linalg.norm(np.subtract(left, right))
        bites = (sheet.below(np.add(left, away), 0.0), sheet.below(np.subtract(right, away), 0.0))
        events.append(Suture(f"stitch_{number}", bites, start=CLOSE + late, duration=END - 2 - CLOSE))
    return replace(procedure.with_events(*events), end_time=float(END))
