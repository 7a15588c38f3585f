"""The whole body: its cavities, its muscles, and how its arm bends."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from lappet import check
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.geometry.rigid_motion import RigidMotion
from lappet.geometry.surface_check import signed_volume
from lappet.models.body_mesh import BODY, body_mesh
from lappet.models.body_shape import NEUTRAL, shaped
from lappet.models.body_skin import BodySkin, apart
from lappet.models.joints import joints
from lappet.models.model_choice import ModelChoice
from lappet.models.muscle_plans import MUSCLES
from lappet.models.new_model import new_model
from lappet.models.skeleton import skeleton
from lappet.procedure import Procedure, Retractor
from lappet.usd.stage import read_procedure, write_procedure


@cache
def body() -> Procedure:
    return new_model("body")


@cache
def skin() -> BodySkin:
    quads = body_mesh().faces_of(BODY)
    used, faces = np.unique(np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]), return_inverse=True)
    faces = faces.reshape(-1, 3)
    return BodySkin.of(apart(shaped(NEUTRAL)[used], faces), faces)


def test_the_body_has_no_error_and_is_as_it_was_after_a_file(tmp_path: Path) -> None:
    assert [each for each in check(body()) if each.severity == "error"] == []
    write_procedure(body(), tmp_path / "body.usda")
    assert read_procedure(tmp_path / "body.usda") == body()


def test_its_tissue_is_the_body_less_its_bones() -> None:
    bones = skeleton(joints(shaped(NEUTRAL)), skin())
    whole = sum(np.einsum("i,i", np.cross(a, b), c) for a, b, c in skin().corners) / 6.0
    tissue = body().tissue
    volume = signed_volume(tissue.points, tissue.face_vertex_indices.reshape(-1, 3))
    assert volume == pytest.approx(whole - sum(solid.volume() for solid in bones.values()), rel=1e-3)


def test_twenty_pairs_of_muscles_and_more_lie_below_the_skin() -> None:
    assert len(MUSCLES) >= 20
    assert len(body().muscles) == 2 * len(MUSCLES)
    for muscle in body().muscles:
        for strand in muscle.strands:
            depth = skin().depth(np.array(strand.points))[0]
            assert (depth > np.array(strand.radii) + 1.0).all(), muscle.name


def test_left_and_right_mirror_each_other() -> None:
    by_name = {muscle.name: muscle for muscle in body().muscles}
    for plan in MUSCLES:
        right, left = by_name[f"{plan.name}_r"], by_name[f"{plan.name}_l"]
        for one, other in zip(right.strands, left.strands, strict=True):
            assert np.abs(np.array(one.points) * (-1, 1, 1) - np.array(other.points)).max() < 1e-6, plan.name


def test_the_elbow_bends_by_25_degrees_and_stays_where_it_is() -> None:
    [bent] = body().events
    assert isinstance(bent, Retractor)
    motion = RigidMotion(bent.motion).between(1.0, body().end_time)
    angle = np.degrees(np.arccos(0.5 * (np.trace(motion[:3, :3]) - 1.0)))
    places = joints(shaped(NEUTRAL))
    elbow, hand, shoulder = (np.append(places[name], 1.0) for name in ("r-elbow", "r-hand", "r-shoulder"))
    assert angle == pytest.approx(25.0)
    assert motion @ elbow == pytest.approx(elbow)
    assert np.linalg.norm(motion @ hand - shoulder) < np.linalg.norm(hand - shoulder) - 40.0


def test_an_excision_is_refused() -> None:
    with pytest.raises(RefusedError) as refused:
        new_model("body", ModelChoice(excision=True))
    assert refused.value.problems[0].code == ProblemCode.MODEL_NO_BODY
