"""Vessels and nerves of the models: they lie in the tissue where anatomists say, and cuts there divide them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet import check
from lappet.designs.library_operation import add_flap
from lappet.geometry.closest_point import ClosestPoint
from lappet.models.body_package import is_fetched
from lappet.models.body_shape import BodyShape
from lappet.models.catalogue import BODY_MODELS
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import new_model
from lappet.models.sources import CHOSEN, SOURCES
from lappet.models.vessel_plans import COURSES
from lappet.procedure import Incision, Landmark, Procedure, Vessel
from lappet.program.compile import compile_program

pytestmark = pytest.mark.skipif(not is_fetched(), reason="the models' package is not there: lappet models fetch")


@pytest.fixture(scope="module")
def face() -> Procedure:
    return new_model("face")


def vessel(procedure: Procedure, name: str) -> Vessel:
    (found,) = (each for each in procedure.vessels if each.name == name)
    return found


def landmark(procedure: Procedure, name: str) -> np.ndarray:
    (found,) = (each for each in procedure.events if isinstance(each, Landmark) and each.name == name)
    return np.array(found.points[0])


def depths(procedure: Procedure, of: Vessel, faces: str) -> np.ndarray:
    """Distances of a vessel's points in mm from the underside, or from the outer skin: neither rim nor underside."""
    tissue = procedure.tissue
    triangles = tissue.face_vertex_indices.reshape(-1, 3)
    chosen = np.zeros(len(triangles), bool)
    chosen[tissue.subsets["underside"]] = True
    if faces == "skin":
        chosen[tissue.subsets["rim"]] = True
        chosen = ~chosen
    return np.asarray(ClosestPoint(tissue.points, triangles[chosen]).query(np.array(of.points))[2])


@pytest.mark.parametrize("name", ["face", "nose", "midface", "temple", "eyelids"])
def test_every_course_lies_in_the_tissue_and_is_a_typical_one(name: str, face: Procedure) -> None:
    procedure = face if name == "face" else new_model(name, ModelChoice(scenery=False))
    assert procedure.vessels
    assert [str(each) for each in check(procedure) if "Anatomy" in each.prim] == []
    assert all(each.typical_course for each in procedure.vessels)
    assert len({each.name for each in procedure.vessels}) == len(procedure.vessels)


def test_a_model_far_from_every_course_has_no_vessel() -> None:
    assert new_model("cheek", ModelChoice(scenery=False)).vessels == ()


def test_the_supratrochlear_artery_leaves_the_orbit_at_the_inner_canthus_or_lateral_of_it(face: Procedure) -> None:
    # Onerci Altunay 2024: on none of 36 sides medial of the vertical through the canthus
    for side, sign in (("left", -1.0), ("right", 1.0)):
        start = np.array(vessel(face, f"supratrochlear_artery_{side}").points[0])
        canthus = landmark(face, f"endocanthion_{side}")
        assert sign * start[0] > 18.0  # mm from the midline, the canthus of the neutral body
        assert abs(start[0] - canthus[0]) < 5.0
        assert start[2] > canthus[2] + 10.0


def test_arteries_of_the_forehead_come_up_through_the_fat_and_never_into_the_skin(face: Procedure) -> None:
    skin, below = BODY_MODELS["face"].skin.mm, BODY_MODELS["face"].fat.mm
    for name in ("supratrochlear_artery_left", "supraorbital_artery_right"):
        at = depths(face, vessel(face, name), "skin")
        assert at.min() > skin
        assert at[0] == pytest.approx(skin + 0.92 * below, abs=0.35)
        assert at[-1] < at[0] - 0.25 * below
        assert depths(face, vessel(face, name), "underside").min() > 0.05


def test_vessels_follow_the_shape_of_the_body() -> None:
    usual = new_model("nose", ModelChoice(scenery=False))
    humped = BodyShape(targets=(("nose/nose-hump-incr", 1.0),))
    other = new_model("nose", ModelChoice(shape=humped, scenery=False))
    a, b = (np.array(vessel(each, "dorsal_nasal_artery_left").points) for each in (usual, other))
    moved = np.linalg.norm(a[: len(b)] - b[: len(a)], axis=1)
    assert moved.max() > 0.5
    assert [each for each in check(other) if "Anatomy" in each.prim] == []


def test_an_incision_across_the_forehead_is_told_to_divide_its_arteries(face: Procedure) -> None:
    cut = Incision("brow_to_brow", 2.0, tuple((x, 142.0, 768.0) for x in np.linspace(-24.0, 24.0, 25)))
    coarse = replace(face, tissue=replace(face.tissue, spacing=4.0))
    said = [str(each) for each in compile_program(coarse.with_events(cut)).notes]
    for name in ("supratrochlear artery left", "supratrochlear nerve right"):
        assert any("crosses" in each and name in each for each in said)
    assert not any("dorsal nasal" in each for each in said)


def test_a_forehead_flap_that_carries_its_artery_may_be_long_and_one_beside_it_is_warned_of(face: Procedure) -> None:
    measures = {"diameter": 14.0, "distance": 34.0, "width": 9.0, "spare": 5.0}
    on = add_flap(
        face, "paramedian-forehead", (18.5, 139, 749), (0.66, 0, 0.75), {**measures, "turn": 140}, mirrored=True
    )
    beside = add_flap(face, "paramedian-forehead", (6.0, 142, 748), (0.2, 0, 1), measures, mirrored=True)
    warned = [[str(each.code) for each in check(flap)] for flap in (on, beside)]
    assert "flap-narrow-base" not in warned[0]
    assert "flap-narrow-base" in warned[1]


def test_every_course_has_its_source() -> None:
    for course in COURSES:
        assert course.source in (*SOURCES, CHOSEN)
        assert len(course.way) > 2
        assert all(0.0 < share < 1.0 for *_, share in course.way)
