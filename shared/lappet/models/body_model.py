"""Make the procedure of a body model: its tissue, materials, skin lines, landmarks and what is shown around it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lappet.geometry.labeled_surface import LINING
from lappet.models.body_scenery import body_scenery
from lappet.models.body_shape import BodyShape
from lappet.models.body_surface import body_surface
from lappet.models.cleft import in_lip
from lappet.models.deep_layer import deep_layer, trial_of, with_deep_layer
from lappet.models.landmarks import cleft_landmarks, landmarks_on
from lappet.models.model import Model
from lappet.models.model_choice import REACH_RANGE, SKIN_RANGE, SPACING_RANGE, ModelChoice, checked
from lappet.models.model_sheet import model_sheet
from lappet.models.skin_line_plans import lines_on
from lappet.models.subunits import UNITS, subunits
from lappet.models.trial_excision import with_excision
from lappet.models.vessel_plans import vessels_on
from lappet.procedure import Material, Procedure
from lappet.tissue.bed import BEDS
from lappet.tissue.presets import FAT, PRESETS, skin_over_fat
from lappet.tissue.uniaxial import prestretch_for

_DIGITS = 4  # of a prestretch and a bed's stiffness


def body_model(model: Model, choice: ModelChoice) -> Procedure:
    """Make the procedure of a body model.

    Parameters
    ----------
    model
        The model.
    choice
        What is otherwise than usual.

    Returns
    -------
    Procedure
        The procedure. Without an excision it is one frame long, and its only events are landmarks.

    Raises
    ------
    RefusedError
        If a parameter is out of its range, the package is not there, the thickness has no room, or the model has no
        deeper layer; names the value.
    """
    thickness = checked("skin", choice.skin if choice.skin is not None else model.skin.mm, *SKIN_RANGE)
    laxity = checked("laxity", choice.laxity, 0.0, 1.0)
    spacing = checked("spacing", choice.spacing if choice.spacing is not None else model.spacing, *SPACING_RANGE)
    model = replace(model, region=model.region.reaching(checked("reach", choice.reach, *REACH_RANGE)))
    layer = deep_layer(model.name) if choice.deep else None
    whole = thickness + model.fat.mm + (layer.added if layer is not None else 0.0)
    shape = choice.shape or usual_shape(model)
    around = body_surface(shape, model.surround, model.subdivision, model.cleft)
    skin = around.inside(model.region)
    tissue = model_sheet(skin, around, whole, spacing, model.name)
    if model.cleft is not None:
        bed = tissue.subsets["bed"]
        below = tissue.points[tissue.face_vertex_indices.reshape(-1, 3)[bed]].mean(axis=1)
        loose = in_lip(skin.on_neutral(below))
        free = {**tissue.subsets, "bed": bed[~loose], LINING: bed[loose]}
        moved = skin.cleft(model.cleft, tissue.points)
        tissue = replace(tissue, points=moved.astype(np.float32).astype(np.float64), subsets=free)
        skin = replace(skin, points=tissue.points[: len(skin.points)])  # the skin's vertices are the tissue's first
    if model.units:  # the skin's triangles are the tissue's first
        tissue = replace(tissue, subsets={**tissue.subsets, **subunits(skin, UNITS[model.units])})
    support = BEDS[model.bed]
    procedure = Procedure(
        replace(tissue, bed_stiffness=round(support.normal, _DIGITS), bed_shear=round(support.shear, _DIGITS)),
        events=(
            *(place.event() for place in landmarks_on(skin, model.region)),
            *(cleft_landmarks(skin) if model.cleft is not None else ()),
        ),
        skin_lines=lines_on(skin, model.region, model.lines),
        vessels=vessels_on(skin, model.region, tissue, (thickness, model.fat.mm)),
        scenery=body_scenery(shape, model) if choice.scenery else (),
    )
    procedure = skin_over_fat(procedure, thickness, _skin_material(model, laxity), FAT.material)
    if layer is not None:
        procedure = with_deep_layer(procedure, layer, whole - layer.depth.mm)
    trial = trial_of(model, layer)
    return with_excision(procedure, trial, skin.carried([trial.at])[0][0]) if choice.excision else procedure


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
