"""What the atlas keeps of a solved design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lappet.core.problem_code import ProblemCode
from lappet.output.solve_to_cache import SolveResult
from lappet.procedure import Landmark, Procedure

# Where the results keep the rows on models, and those of them with self-contact.
MODEL_ROWS, CONTACT_ROWS = "model_rows", "contact_rows"


@dataclass(frozen=True)
class AtlasRow:
    """What a design gave, in its last frame; forces, lengths and tensions with their estimated errors.

    Parameters
    ----------
    name
        Name of the design.
    frames
        Frames that converged.
    of_frames
        Frames of the operation.
    seconds
        Run time of the solve with its estimate of errors, in seconds.
    total_force
        Sum of the forces of all sutures in mN, and its error.
    greatest_force
        Greatest force of a suture in mN, and its error.
    greatest_suture
        Name of that suture.
    scar_length
        Length of the scar in mm.
    open_area
        Area of the wound that is still open in mm².
    dog_ear
        Greatest height of a dog-ear in mm, None where none is measured.
    tension
        Greatest mean tension of the skin in kPa, and its error, None where none is measured.
    overlap
        Depth in mm by which tissue lies in other tissue at the end, 0 for none.
    """

    name: str
    frames: int
    of_frames: int
    seconds: float
    total_force: tuple[float, float | None] | None
    greatest_force: tuple[float, float | None] | None
    greatest_suture: str
    scar_length: float
    open_area: float
    dog_ear: float | None
    tension: tuple[float, float | None] | None
    overlap: float


@dataclass(frozen=True)
class ModelRow:
    """What a design gave on a model of the body.

    Parameters
    ----------
    measured
        What is measured of every design; its name is that of the operation.
    design
        Name of the design.
    model
        Name of the model.
    spacing
        Edge of the lattice's cells in mm.
    cells
        Cells of the lattice in the last frame.
    newton
        Newton iterations of all frames.
    moved
        By name of an anatomical landmark, how far it has moved in mm, and its error.
    reason
        Why the solve ended before its last frame, a sentence, or "".
    """

    measured: AtlasRow
    design: str
    model: str
    spacing: float
    cells: int
    newton: int
    moved: dict[str, tuple[float, float | None]]
    reason: str

    def flat(self) -> dict[str, Any]:
        """Put all of it into one map.

        Returns
        -------
        dict[str, Any]
            Everything by its name.
        """
        own = {name: value for name, value in vars(self).items() if name != "measured"}
        return {**vars(self.measured), **own}


def atlas_row(name: str, result: SolveResult) -> AtlasRow:
    """Take what the atlas shows of a solved design.

    Parameters
    ----------
    name
        Name of the design.
    result
        Its solve.

    Returns
    -------
    AtlasRow
        The row.
    """
    last = result.measures[-1] if result.measures else None
    sums = last.sums if last else None
    tension = last.mean_tension if last else None
    time = result.frames[-1].solved.time if result.frames else 0.0
    seams = [row for row in result.seams if row.time == time]
    ears = [ear for row in seams for ear in (row.start_dog_ear_mm, row.end_dog_ear_mm) if ear is not None]
    deep = [float(note.value) for note in result.notes if note.code is ProblemCode.TISSUE_IN_TISSUE]
    return AtlasRow(
        name,
        sum(frame.solved.converged for frame in result.frames),
        len(list(result.procedure.frames())),
        result.wall_seconds,
        (sums.total_mn, sums.total_error_mn) if sums else None,
        (sums.greatest_mn, sums.greatest_error_mn) if sums else None,
        (sums.greatest_suture or "") if sums else "",
        sum(row.scar_length_mm for row in seams),
        sum(row.open_area_mm2 for row in seams),
        max(ears) if ears else None,
        (tension.tension, tension.error) if tension else None,
        max(deep, default=0.0),
    )


def model_row(name: str, design: str, model: str, result: SolveResult) -> ModelRow:
    """Take what the atlas shows of a design that was solved on a model of the body.

    Parameters
    ----------
    name
        Name of the operation.
    design
        Name of the design.
    model
        Name of the model.
    result
        Its solve.

    Returns
    -------
    ModelRow
        The row.
    """
    lattice = result.frames[-1].solved.lattice if result.frames else None
    reason = result.reason
    return ModelRow(
        atlas_row(name, result),
        design=design,
        model=model,
        spacing=result.procedure.tissue.spacing,
        cells=lattice.cells if lattice else 0,
        newton=sum(frame.solved.diagnostics.newton for frame in result.frames),
        moved=_moved(result),
        reason="" if reason is None else str(reason),
    )


def _moved(result: SolveResult) -> dict[str, tuple[float, float | None]]:
    """How far the landmarks of the model have gone since the first frame, those of the flap apart."""
    if not result.frames:
        return {}
    first, last = (result.frames[k].solved for k in (0, -1))
    own, names = _anatomical(result.procedure), result.program.landmarks
    before = dict(zip(first.landmark_index.tolist(), first.landmarks, strict=True))
    estimate = result.errors.frames[-1] if result.errors and result.errors.frames else None
    errors = estimate.landmarks if estimate else ()
    found: dict[str, tuple[float, float | None]] = {}
    for row, (which, now) in enumerate(zip(last.landmark_index.tolist(), last.landmarks, strict=True)):
        if names[which] in own and which in before:
            error = float(errors[row]) if row < len(errors) else None
            found[names[which]] = (float(np.linalg.norm(now - before[which])), error)
    return found


def _anatomical(procedure: Procedure) -> set[str]:
    """The labels of the landmarks of one point that no flap has made."""
    made = {name for flap in procedure.flaps for name in flap.events}
    marks = [event for event in procedure.events if isinstance(event, Landmark) and event.name not in made]
    return {mark.label for mark in marks if len(mark.points) == 1}
