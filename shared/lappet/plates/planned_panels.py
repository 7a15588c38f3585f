"""The panels of a plate of the procedure: the frame of each, and what must hold before anything is drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import Problem, problem, refused
from lappet.core.problem_code import ProblemCode
from lappet.drawing.framing import surgical_field
from lappet.drawing.skin_source import FigureError, SkinSource
from lappet.plates.panel_camera import LEAST_ACROSS, own_direction
from lappet.plates.plate_steps import CUTS, PlateStep, StepKind, plate_steps
from lappet.procedure.plate import PanelStep, Plate

_LEAST_ABOVE = 0.05  # sine of the least angle above the skin from which a panel is seen
_KINDS: dict[PanelStep, frozenset[StepKind]] = {
    "plan": frozenset({StepKind.PLAN, StepKind.PLAN_EXCISION}),
    "cut": CUTS,
    "raised": frozenset({StepKind.RAISED, StepKind.RETRACTED}),
    "placed": frozenset({StepKind.PLACED, StepKind.APPROXIMATED}),
    "sutured": frozenset({StepKind.ON_PEDICLE, StepKind.SUTURED}),
    "result": frozenset({StepKind.RESULT}),
}
# Where the result looks as the sutured wound does, the operation has one of them; it may be called by either name.
_ALIKE: dict[PanelStep, PanelStep] = {"result": "sutured", "sutured": "result"}


def plate_panels(source: SkinSource, plate: Plate, notes: list[Problem]) -> tuple[PlateStep, ...]:
    """Find the frames of a plate's panels.

    Parameters
    ----------
    source
        The solved procedure.
    plate
        The plate.
    notes
        Gets a note of each step that the operation does not have.

    Returns
    -------
    tuple[PlateStep, ...]
        The panels in the plate's order, insets among them; those of the operation's steps where the plate has none.

    Raises
    ------
    RefusedError
        If a frame is not there, a camera looks from below the skin, none of the steps is there, an inset has no panel,
        a crop has no size, or an annotation names a panel that the plate does not have.
    """
    _check(plate)
    normal = surgical_field(source, (source.frames[0],)).normal
    _check_cameras(plate, normal)
    steps = plate_steps(source, normal)
    if not plate.panels:
        return tuple(steps)
    found = []
    for panel in plate.panels:
        step = _step(source, steps, panel.step, panel.time, plate)
        if step is None:
            if not _told_already(panel.step, plate):
                notes.append(problem(ProblemCode.PLATE_NO_STEP, panel.name, panel.step))
            continue
        ghost = _step(source, steps, panel.ghost, 0.0, plate) if panel.ghost else None
        found.append(replace(step, panel=panel, ghost=None if ghost is None else ghost.time))
    hosts = {step.panel.name for step in found if step.panel is not None and not step.panel.inset_of}
    kept = [step for step in found if step.panel is not None and step.panel.inset_of in {"", *hosts}]
    if not hosts:
        names = ", ".join(dict.fromkeys(panel.step for panel in plate.panels))
        raise refused(ProblemCode.PLATE_FRAMES_NONE, plate.name, names)
    return tuple(kept)


def _step(source: SkinSource, steps: list[PlateStep], name: PanelStep, time: float, plate: Plate) -> PlateStep | None:
    """The frame of a step, or of a time code where there is no step; None where the operation has no such step."""
    if not name:
        try:
            source.epoch_at(time)
        except FigureError as error:
            raise refused(ProblemCode.PLATE_CACHE, plate.name, time, reason=str(error)) from error
        return next((each for each in steps if each.time == time), PlateStep(time, StepKind.FRAME))
    own = [each for each in steps if each.kind in _KINDS[name]]
    if own:
        return own[-1]
    if name in _ALIKE and not _told_already(name, plate):
        own = [each for each in steps if each.kind in _KINDS[_ALIKE[name]]]
    return own[-1] if own else None


def _told_already(name: PanelStep, plate: Plate) -> bool:
    """Whether another panel shows what looks as a step does that the operation does not have."""
    return name in _ALIKE and any(panel.step == _ALIKE[name] and not panel.inset_of for panel in plate.panels)


def _check_cameras(plate: Plate, normal: NDArray[np.float64]) -> None:
    """Refuse cameras that look from below the skin, and directions that are none."""
    for panel in plate.panels:
        if panel.look_from is None:
            continue
        own = own_direction(panel)
        if own is None or float(own[0] @ normal) < _LEAST_ABOVE:
            said = ", ".join(f"{each:g}" for each in panel.look_from)
            raise refused(ProblemCode.PLATE_CAMERA, panel.name, said)


def _check(plate: Plate) -> None:
    names = {panel.name for panel in plate.panels}
    hosts = {panel.name for panel in plate.panels if not panel.inset_of}
    for panel in plate.panels:
        if panel.inset_of and (panel.inset_of not in hosts or panel.inset_of == panel.name):
            known = ", ".join(sorted(hosts - {panel.name})) or "none"
            raise refused(ProblemCode.PLATE_INSET, panel.name, panel.inset_of, known=known)
        if panel.at is not None and not panel.across >= LEAST_ACROSS:
            raise refused(ProblemCode.PLATE_CROP, panel.name, f"{panel.across:g}", least=LEAST_ACROSS)
    for note in plate.annotations:
        for name in note.panels:
            if name not in names:
                known = ", ".join(sorted(names)) or "none"
                raise refused(ProblemCode.PLATE_PANEL, note.name, name, known=known)
