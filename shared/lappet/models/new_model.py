"""Make the procedure of a model of the catalogue."""

from __future__ import annotations

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_model import body_model
from lappet.models.catalogue import BODY_MODELS
from lappet.models.model import Model
from lappet.models.model_choice import ModelChoice
from lappet.models.plain_models import PLAIN_MODELS, PlainModel, plain_model
from lappet.procedure import Procedure

USUAL = ModelChoice()
MODELS: dict[str, Model | PlainModel] = {**BODY_MODELS, **PLAIN_MODELS}


def model_named(name: str) -> Model | PlainModel:
    """Look up a model.

    Parameters
    ----------
    name
        Its name.

    Returns
    -------
    Model | PlainModel
        The model.

    Raises
    ------
    RefusedError
        If there is none of that name.
    """
    if name not in MODELS:
        raise refused(ProblemCode.MODEL_UNKNOWN, name, name, known=", ".join(MODELS))
    return MODELS[name]


def new_model(name: str, choice: ModelChoice = USUAL) -> Procedure:
    """Make the procedure of a model.

    Parameters
    ----------
    name
        Name of the model.
    choice
        What is otherwise than usual.

    Returns
    -------
    Procedure
        The procedure.

    Raises
    ------
    RefusedError
        If there is no such model, a parameter is out of its range, the package is not there, or the thickness has no
        room.
    """
    model = model_named(name)
    return body_model(model, choice) if isinstance(model, Model) else plain_model(model, choice)
