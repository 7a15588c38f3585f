"""Make the procedure of a model: its tissue, materials, skin lines and landmarks, without an operation."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_shape import BodyShape
from lappet.models.body_surface import BodySurface, body_surface
from lappet.models.landmarks import landmarks_on
from lappet.models.model import Model
from lappet.models.model_sheet import model_sheet
from lappet.models.skin_line_plans import lines_on
from lappet.procedure import Material, Procedure
from lappet.tissue.bed import BEDS
from lappet.tissue.presets import FAT, PRESETS, skin_over_fat
from lappet.tissue.uniaxial import prestretch_for

_DIGITS = 4  # of a prestretch


@dataclass(frozen=True)
class ModelChoice:
    """What may be chosen of a model.

    Parameters
    ----------
    shape
        The shape of the body; None for a neutral one of 25 years.
    skin
        Thickness of the skin in mm; None for the model's.
    laxity
        How slack the skin is: 0 for the tension of its preset, 1 for none.
    spacing
        Edge of the lattice's cells in mm; None for the model's.
    """

    shape: BodyShape | None = None
    skin: float | None = None
    laxity: float = 1.0
    spacing: float | None = None


def new_model(model: Model, choice: ModelChoice = ModelChoice()) -> Procedure:  # noqa: B008
    """Make the procedure of a model.

    Parameters
    ----------
    model
        The model.
    choice
        What is otherwise than usual.

    Returns
    -------
    Procedure
        The procedure, one frame long; its only events are landmarks.

    Raises
    ------
    RefusedError
        If a parameter is out of its range, the package is not there, or the thickness has no room; names the value.
    """
    thickness = _checked("skin", choice.skin if choice.skin is not None else model.skin.mm, 0.3, 5.0)
    laxity = _checked("laxity", choice.laxity, 0.0, 1.0)
    spacing = model.spacing if choice.spacing is None else _checked("spacing", choice.spacing, 0.05, 20.0)
    shape = choice.shape or usual_shape(model)
    around = body_surface(shape, model.surround, model.subdivision)
    skin = around.inside(model.region)
    tissue = model_sheet(skin, around, thickness + model.fat.mm, spacing, model.name)
    bed = BEDS[model.bed]
    tissue = replace(tissue, bed_stiffness=bed.normal, bed_shear=bed.shear)
    procedure = Procedure(
        tissue,
        events=tuple(place.event() for place in landmarks_on(skin, model.region)),
        skin_lines=lines_on(skin, model.region, model.lines),
    )
    return skin_over_fat(procedure, thickness, _skin_material(model, laxity), FAT.material)


def usual_shape(model: Model) -> BodyShape:
    """Choose the shape of a model that nobody chose.

    Parameters
    ----------
    model
        The model.

    Returns
    -------
    BodyShape
        The neutral body, or a woman's.
    """
    return BodyShape(sex=0.0) if model.female else BodyShape()


def _skin_material(model: Model, laxity: float) -> Material:
    """The preset's skin with the share of its tension that laxity leaves."""
    preset = PRESETS[model.preset]
    along, across = ((1.0 - laxity) * tension for tension in preset.tension)
    if along == 0.0 and across == 0.0:
        return preset.unstretched
    stretch = prestretch_for(preset.unstretched, along, across)
    return replace(preset.unstretched, prestretch=(round(stretch[0], _DIGITS), round(stretch[1], _DIGITS)))


def _checked(name: str, value: float, low: float, high: float) -> float:
    if not (np.isfinite(value) and low <= value <= high):
        raise refused(ProblemCode.MODEL_PARAMETER, name, f"{value:g}", name=name, low=f"{low:g}", high=f"{high:g}")
    return value
