"""Make the procedure of a model of the catalogue."""

from __future__ import annotations

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_model import body_model
from lappet.models.catalogue import BODY_MODELS
from lappet.models.model import Model
from lappet.models.model_choice import ModelChoice
from lappet.models.plain_models import PLAIN_MODELS, PlainModel, plain_model
from lappet.models.whole_body import WHOLE_BODY, WholeBodyModel, whole_body_model
from lappet.procedure import Procedure

USUAL = ModelChoice()
MODELS: dict[str, Model | PlainModel] = {**BODY_MODELS, **PLAIN_MODELS}  # those that Blender offers
# A scene of Blender has neither muscles nor bones that carry tissue.
WHOLE_BODIES = {WHOLE_BODY.name: WHOLE_BODY}


def model_named(name: str) -> Model | PlainModel | WholeBodyModel:
    """Look up a model.

    Parameters
    ----------
    name
        Its name.

    Returns
    -------
    Model | PlainModel | WholeBodyModel
        The model.

    Raises
    ------
    RefusedError
        If there is none of that name.
    """
    known = {**MODELS, **WHOLE_BODIES}
    if name not in known:
        raise refused(ProblemCode.MODEL_UNKNOWN, name, name, known=", ".join(known))
    return known[name]


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
    if isinstance(model, WholeBodyModel):
        return whole_body_model(model, choice)
    return body_model(model, choice) if isinstance(model, Model) else plain_model(model, choice)
