"""The models that are no part of a body: a flat patch and a dome."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.deep_layer import deep_layer
from lappet.models.model import Trial
from lappet.models.model_choice import SKIN_RANGE, SPACING_RANGE, ModelChoice, checked
from lappet.models.trial_excision import with_excision
from lappet.procedure import Procedure, Tissue
from lappet.tissue.dome import dome_bone, dome_scalp
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import FAT, SKIN, skin_over_fat

_FAT = 2.5  # mm
_BELOW = 0.5  # mm between the tissue of the dome and its bone


@dataclass(frozen=True)
class PlainModel:
    """A model that is no part of a body.

    Parameters
    ----------
    name
        What the command line and Blender call it.
    title
        What it shows, in a few words.
    skin
        Thickness of its skin in mm.
    spacing
        Edge of the lattice's cells in mm by default.
    tissue
        Makes its tissue from its thickness and the spacing in mm.
    radius
        Radius in mm of the bone below, 0 for none.
    trial
        The excision with which it was tried.
    """

    name: str
    title: str
    skin: float
    spacing: float
    tissue: Callable[[float, float], Tissue]
    radius: float
    trial: Trial


def _patch(thickness: float, spacing: float) -> Tissue:
    return flat_patch((100.0, 80.0, thickness), spacing=spacing)


def _dome(thickness: float, spacing: float) -> Tissue:
    return dome_scalp(80.0, 50.0, thickness, spacing=spacing)


_MODELS = (
    PlainModel(
        "patch", "a flat patch of 100 by 80 mm", 1.5, 1.0, _patch, 0.0, Trial((0.0, 0.0, 4.0), (1.0, 0.0, 0.0), 36.0)
    ),
    PlainModel(
        "dome",
        "a dome over bone, of 80 mm radius",
        1.5,
        1.0,
        _dome,
        80.0,
        Trial((0.0, 0.0, 80.0), (1.0, 0.0, 0.0), 36.0),
    ),
)
PLAIN_MODELS = {model.name: model for model in _MODELS}


def plain_model(model: PlainModel, choice: ModelChoice) -> Procedure:
    """Make the procedure of such a model.

    Parameters
    ----------
    model
        The model.
    choice
        What is otherwise than usual; its laxity and scenery do nothing.

    Returns
    -------
    Procedure
        The procedure.

    Raises
    ------
    RefusedError
        If a parameter is out of its range, or the shape of a body, a reach or a deeper layer is asked for.
    """
    if choice.shape is not None:
        raise refused(ProblemCode.MODEL_NO_BODY, model.name, "the shape of a body")
    if choice.reach != 1.0:
        raise refused(ProblemCode.MODEL_NO_BODY, model.name, "a reach")
    if choice.deep:
        deep_layer(model.name)
    skin = checked("skin", choice.skin if choice.skin is not None else model.skin, *SKIN_RANGE)
    spacing = checked("spacing", choice.spacing if choice.spacing is not None else model.spacing, *SPACING_RANGE)
    thickness = skin + _FAT
    bones = (dome_bone(model.radius - thickness - _BELOW, 55.0),) if model.radius else ()
    procedure = skin_over_fat(
        Procedure(model.tissue(thickness, spacing), bones=bones), skin, SKIN.material, FAT.material
    )
    return with_excision(procedure, model.trial, model.trial.at) if choice.excision else procedure
