from __future__ import annotations

import numpy as np
import pytest

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.models.body_mesh import BODY, body_mesh, target, target_names
from lappet.models.body_shape import NEUTRAL, BodyShape, shaped, target_amount

SKIN = "universal-{}-{}-averagemuscle-averageweight"


def height(shape: BodyShape) -> float:
    points = shaped(shape)[np.unique(body_mesh().faces_of(BODY))]
    return float(np.ptp(points[:, 2]))


def test_x_runs_to_the_right_y_to_the_front_and_z_up() -> None:
    mesh = body_mesh()
    points = shaped(NEUTRAL)
    nose, crown = points[297], points[np.unique(mesh.faces_of(BODY))].max(axis=0)
    left_eye = points[np.unique(mesh.faces_of(("helper-l-eye",)))].mean(axis=0)
    assert nose[1] == pytest.approx(159.6, abs=0.1)
    assert abs(nose[0]) < 0.01
    assert left_eye[0] < -20.0
    assert crown[2] > nose[2] > 600.0


def test_adults_are_as_tall_as_people_are() -> None:
    assert 1550.0 < height(BodyShape(sex=0.0)) < 1750.0
    assert 1650.0 < height(BodyShape(sex=1.0)) < 1850.0
    assert height(BodyShape(age=1.0)) < height(BodyShape(age=10.0)) < height(BodyShape(age=25.0))


def test_between_two_ages_a_shape_is_the_mean() -> None:
    young, old = shaped(BodyShape(age=25.0)), shaped(BodyShape(age=90.0))
    assert np.allclose(shaped(BodyShape(age=57.5)), 0.5 * (young + old))


def test_a_child_of_ten_is_the_package_s_own_child() -> None:
    wanted = body_mesh().points + target(f"macrodetails/{SKIN.format('male', 'child')}")
    wanted = wanted + sum(target(f"macrodetails/{who}-male-child") for who in ("caucasian", "asian", "african")) / 3.0
    assert np.allclose(shaped(BodyShape(age=10.0, sex=1.0)), wanted)


def test_a_target_is_added_in_the_amount_that_is_asked_for() -> None:
    plain, hump = shaped(NEUTRAL), shaped(BodyShape(targets=(("nose/nose-hump-incr", 0.5),)))
    assert np.allclose(hump - plain, 0.5 * target("nose/nose-hump-incr"))
    assert "nose/nose-hump-incr" in target_names()
    assert target_amount("nose/nose-hump-incr=0.5") == ("nose/nose-hump-incr", 0.5)


@pytest.mark.parametrize(
    ("shape", "code"),
    [
        (BodyShape(age=0.5), ProblemCode.MODEL_PARAMETER),
        (BodyShape(sex=1.5), ProblemCode.MODEL_PARAMETER),
        (BodyShape(weight=float("nan")), ProblemCode.MODEL_PARAMETER),
        (BodyShape(targets=(("nose/nose-hump-incr", 3.0),)), ProblemCode.MODEL_PARAMETER),
        (BodyShape(targets=(("nose/none", 0.5),)), ProblemCode.MODEL_TARGET_UNKNOWN),
    ],
)
def test_a_shape_out_of_range_is_refused(shape: BodyShape, code: ProblemCode) -> None:
    with pytest.raises(RefusedError) as refused:
        shaped(shape)
    assert refused.value.problems[0].code == code
