from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from lappet import check
from lappet.anatomy.tissue_layers import layer_search
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.cutting.epochs import build_epochs
from lappet.geometry.closest_point import closest_points
from lappet.geometry.labeled_surface import FaceOrigin
from lappet.geometry.triangles import areas
from lappet.models.body_shape import BodyShape
from lappet.models.catalogue import BODY_MODELS
from lappet.models.deep_layer import DEEP_LAYERS
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import MODELS, new_model
from lappet.procedure import Procedure
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import read_procedure, write_procedure


@cache
def made(name: str) -> Procedure:
    return new_model(name, ModelChoice(excision=True))


@pytest.mark.parametrize("name", list(MODELS))
def test_every_model_with_its_excision_has_no_problem(name: str) -> None:
    assert check(made(name)) == []


@pytest.mark.parametrize("name", ["ear", "eyelids"])
def test_beside_a_rim_the_excision_parts_the_skin_that_it_undermines_from_the_rest(name: str) -> None:
    surface = build_epochs(made(name))[-1].surface
    assert 0 < np.count_nonzero(surface.resting) < 0.2 * np.count_nonzero(surface.origin == FaceOrigin.UNDERSIDE)


@pytest.mark.parametrize("name", list(BODY_MODELS))
def test_skin_lines_and_landmarks_lie_on_the_skin(name: str) -> None:
    procedure = made(name)
    skin = SkinSheet.of(procedure.tissue)
    assert procedure.skin_lines
    for line in procedure.skin_lines:
        on_skin = skin.place(line.points)
        assert np.linalg.norm(on_skin - line.points, axis=1).max() < 0.05, line.name
    for event in procedure.events:
        if event.kind == "Landmark":
            assert np.linalg.norm(skin.place(event.points) - event.points) < 0.05, event.name


@pytest.mark.parametrize("name", ["face", "lips", "eyelids", "nose"])
def test_tissue_is_held_at_its_border_and_free_at_the_openings(name: str) -> None:
    tissue = made(name).tissue
    faces = tissue.face_vertex_indices.reshape(-1, 3)
    held = np.zeros(len(faces), bool)
    held[tissue.subsets["fixed"]] = True
    free = np.setdiff1d(tissue.subsets["rim"], tissue.subsets["fixed"])
    assert len(free) > 100
    assert not np.intersect1d(faces[held], faces[free]).size
    region = BODY_MODELS[name].region
    assert region.level(tissue.points[faces[free]].mean(axis=1)).max() < -0.5


def test_most_of_the_cheek_is_as_thick_as_the_catalogue_says() -> None:
    tissue = made("cheek").tissue
    faces = tissue.face_vertex_indices.reshape(-1, 3)
    under = faces[tissue.subsets["underside"]]
    skin = SkinSheet.of(tissue)
    below = tissue.points[np.unique(under)]
    away = np.linalg.norm(skin.place(below) - below, axis=1)
    wanted = BODY_MODELS["cheek"].thickness
    assert np.median(away) == pytest.approx(wanted, rel=0.05)
    assert away.max() < 1.02 * wanted


@pytest.mark.parametrize("name", ["nose", "hand"])
def test_scenery_begins_where_the_tissue_ends(name: str) -> None:
    procedure = made(name)
    (around,) = (each for each in procedure.scenery if each.kind == "skin")
    faces = procedure.tissue.face_vertex_indices.reshape(-1, 3)
    border = np.intersect1d(faces[procedure.tissue.subsets["fixed"]], faces[_skin(procedure)])
    away = closest_points(procedure.tissue.points[border], around.points, around.face_vertex_indices.reshape(-1, 3))[2]
    assert len(border) > 50
    assert away.max() < 0.02  # the scenery is rounded to 0.01 mm


def test_the_lining_of_a_lip_with_a_cleft_has_no_bed() -> None:
    tissue = made("cleft-lip").tissue
    assert len(tissue.subsets["lining"]) > 200
    assert not np.intersect1d(tissue.subsets["lining"], tissue.subsets["bed"]).size


@cache
def deep(name: str) -> Procedure:
    return new_model(name, ModelChoice(deep=True, scenery=False))


def test_a_layer_below_the_fat_makes_the_tissue_thicker_by_itself() -> None:
    procedure, layer = deep("cheek"), DEEP_LAYERS["cheek"]
    skin, tissue = SkinSheet.of(procedure.tissue), procedure.tissue
    below = tissue.points[np.unique(tissue.face_vertex_indices.reshape(-1, 3)[tissue.subsets["underside"]])]
    away = np.linalg.norm(skin.place(below) - below, axis=1)
    assert np.median(away) == pytest.approx(BODY_MODELS["cheek"].thickness + layer.depth.mm, rel=0.05)
    assert layers_of(procedure) == [("cheek", 0.0), ("fat", 1.2), ("smas", 4.0)]


def test_tissue_that_reaches_farther_holds_the_same_skin_and_more_around_it() -> None:
    usual, wider = (new_model("cheek", ModelChoice(reach=reach, scenery=False)) for reach in (1.0, 1.2))
    sheets = [SkinSheet.of(each.tissue) for each in (usual, wider)]
    inner, outer = (sheet.points[np.unique(sheet.triangles)] for sheet in sheets)
    away = sheets[1].place(inner) - inner
    assert np.linalg.norm(away, axis=1).max() < 1e-3
    (low, high), (lower, higher) = ((points.min(axis=0), points.max(axis=0)) for points in (inner, outer))
    assert (lower < low - 2.0).any()
    assert (higher > high + 2.0).any()
    assert (lower <= low + 1e-3).all()
    assert (higher >= high - 1e-3).all()


def test_the_galea_is_the_deepest_of_the_scalp() -> None:
    procedure = deep("scalp")
    assert layers_of(procedure) == [("scalp", 0.0), ("fat", 1.6), ("galea", 4.1)]
    assert procedure.tissue.points == pytest.approx(new_model("scalp", ModelChoice(scenery=False)).tissue.points)


def test_the_nose_has_cartilage_below_its_tip_and_sidewalls_only() -> None:
    tissue = deep("nose").tissue
    (region,) = (each for each in tissue.regions if each.material == "cartilage")
    own = tissue.subsets[region.faces]
    assert np.isin(tissue.subsets["subunit_nasal_tip"], own).all()
    assert not np.isin(tissue.subsets["subunit_ala_left"], own).any()


@pytest.mark.parametrize(
    ("part", "material", "least"),
    [
        *((part, "cartilage", 1.0) for part in ("concha", "antihelix", "antitragus", "triangular_fossa")),
        *((part, "cartilage", 0.85) for part in ("helix", "scapha", "tragus")),  # at their edges other skin is nearer
        *((part, "fat", 0.9) for part in ("lobule", "preauricular", "back_of_auricle", "retroauricular")),
    ],
)
def test_the_auricle_has_cartilage_below_the_skin_of_its_front_and_none_in_its_lobule(
    part: str, material: str, least: float
) -> None:
    upper, lower = materials_below("ear", f"subunit_{part}_left").T
    assert (upper == "face").all()
    assert np.mean(lower == material) >= least
    assert part in ("lobule", "preauricular") or material == "cartilage" or not (lower == "cartilage").any()


def materials_below(name: str, faces: str) -> np.ndarray:
    """Materials a quarter and nine tenths of the way down below skin faces, (n, 2), as the nearest skin has them."""
    tissue = deep(name).tissue
    triangles = tissue.face_vertex_indices.reshape(-1, 3)
    skin = _skin(deep(name))
    own, under = tissue.subsets[faces], triangles[tissue.subsets["underside"]][:, ::-1]
    number = np.searchsorted(skin, own)  # the underside's triangles are in the skin's order
    top, bottom = (tissue.points[part].mean(axis=1) for part in (triangles[own], under[number]))
    found = np.full((len(own), 2), tissue.material, object)
    for column, share in enumerate((0.25, 0.9)):
        nearest, _, away = closest_points(top + share * (bottom - top), tissue.points, triangles[skin])
        for region in tissue.regions:
            held = np.isin(skin[nearest], tissue.subsets[region.faces])
            found[held & (away >= region.depth_from) & (away < region.depth_to), column] = region.material
    return found


def test_the_cartilage_of_the_ear_is_as_thick_as_it_was_measured_wherever_the_auricle_has_room() -> None:
    tissue = deep("ear").tissue
    triangles = tissue.face_vertex_indices.reshape(-1, 3)
    own = tissue.subsets["deep_layer"]
    under = triangles[tissue.subsets["underside"]][np.searchsorted(_skin(deep("ear")), own)][:, ::-1]
    thick = np.linalg.norm(tissue.points[triangles[own]] - tissue.points[under], axis=2).mean(axis=1)
    cartilage = thick - BODY_MODELS["ear"].skin.mm
    assert np.quantile(cartilage, 0.15) == pytest.approx(DEEP_LAYERS["ear"].depth.mm, rel=0.03)
    assert cartilage.max() == pytest.approx(DEEP_LAYERS["ear"].depth.mm, rel=0.03)
    assert cartilage.min() > 0.3


@pytest.mark.parametrize("name", list(DEEP_LAYERS))
def test_nothing_is_told_of_a_model_with_the_layer_below_its_fat(name: str) -> None:
    assert check(deep(name)) == []


@pytest.mark.parametrize("name", ["ear", "nose"])
def test_the_excision_of_a_model_with_cartilage_cuts_through_it(name: str) -> None:
    procedure = new_model(name, ModelChoice(deep=True, excision=True, scenery=False))
    assert {each.severity for each in check(procedure)} <= {"note"}
    search = layer_search(procedure.tissue, procedure.materials)
    surface = build_epochs(procedure)[-1].surface
    found = search.of(surface)
    walls = np.flatnonzero(surface.origin == FaceOrigin.WOUND_WALL)
    depth = found.depth[surface.triangles[walls]].mean(axis=1)
    cut = np.array(search.layers.materials)[search.layers.layers_at(found.column[walls], depth)]
    size = areas(surface.points[surface.triangles[walls]])
    share = DEEP_LAYERS[name].depth.mm / (BODY_MODELS[name].thickness + DEEP_LAYERS[name].added)
    assert size[cut == "cartilage"].sum() / size.sum() == pytest.approx(share, rel=0.3)


def test_muscles_run_across_the_skin_lines() -> None:
    (muscle,) = (each for each in deep("forehead").materials if each.name == "frontalis")
    assert muscle.fiber_angle == 90.0
    assert muscle.has_fibers


def layers_of(procedure: Procedure) -> list[tuple[str, float]]:
    layers = layer_search(procedure.tissue, procedure.materials).layers
    assert layers.columns == 1
    return [(name, pytest.approx(depth)) for name, depth in zip(layers.materials, layers.depth_from, strict=True)]


def _skin(procedure: Procedure) -> np.ndarray:
    tissue = procedure.tissue
    count = len(tissue.face_vertex_counts)
    return np.setdiff1d(np.arange(count), np.concatenate([tissue.subsets["rim"], tissue.subsets["underside"]]))


def test_the_head_around_a_nose_has_eyes_and_teeth() -> None:
    kinds = [each.kind for each in made("nose").scenery]
    assert sorted(kinds) == ["eye", "eye", "iris", "iris", "pupil", "pupil", "skin", "teeth"]
    assert new_model("nose", ModelChoice(scenery=False)).scenery == ()


def test_a_model_survives_its_file(tmp_path: Path) -> None:
    write_procedure(made("hand"), tmp_path / "hand.usdc")
    assert read_procedure(tmp_path / "hand.usdc") == made("hand")


def test_scenery_of_an_unknown_kind_is_refused_with_those_that_are_known(tmp_path: Path) -> None:
    procedure = made("hand")
    odd = replace(procedure, scenery=(replace(procedure.scenery[0], kind="hair"),))  # type: ignore[arg-type]
    write_procedure(odd, tmp_path / "hand.usda")
    with pytest.raises(RefusedError) as refused:
        read_procedure(tmp_path / "hand.usda")
    assert refused.value.problems[0].code == ProblemCode.SCENERY_KIND


def test_laxity_takes_the_tension_of_the_preset_away() -> None:
    stretch = [new_model("hand", ModelChoice(laxity=laxity)).materials[0].prestretch for laxity in (0.0, 0.5, 1.0)]
    assert stretch[0][0] > stretch[1][0] > stretch[2][0] == 1.0


@pytest.mark.parametrize(
    ("name", "choice", "code"),
    [
        ("nostril", ModelChoice(), ProblemCode.MODEL_UNKNOWN),
        ("hand", ModelChoice(deep=True), ProblemCode.MODEL_NO_DEEP_LAYER),
        ("patch", ModelChoice(deep=True), ProblemCode.MODEL_NO_DEEP_LAYER),
        ("body", ModelChoice(deep=True), ProblemCode.MODEL_NO_DEEP_LAYER),
        ("nose", ModelChoice(skin=0.0), ProblemCode.MODEL_PARAMETER),
        ("nose", ModelChoice(laxity=1.5), ProblemCode.MODEL_PARAMETER),
        ("nose", ModelChoice(spacing=float("nan")), ProblemCode.MODEL_PARAMETER),
        ("nose", ModelChoice(reach=3.5), ProblemCode.MODEL_PARAMETER),
        ("patch", ModelChoice(shape=BodyShape(age=60.0)), ProblemCode.MODEL_NO_BODY),
        ("patch", ModelChoice(reach=1.2), ProblemCode.MODEL_NO_BODY),
        ("body", ModelChoice(reach=1.2), ProblemCode.MODEL_NO_BODY),
    ],
)
def test_a_choice_that_makes_no_sense_is_refused(name: str, choice: ModelChoice, code: ProblemCode) -> None:
    with pytest.raises(RefusedError) as refused:
        new_model(name, choice)
    assert refused.value.problems[0].code == code


def test_the_nose_has_its_subunits_each_on_its_own_skin() -> None:
    tissue = made("nose").tissue
    units = {name: faces for name, faces in tissue.subsets.items() if name.startswith("subunit_")}
    wanted = ("nasal_tip", "nasal_dorsum", "ala_left", "ala_right", "nasal_sidewall_left", "columella")
    assert {f"subunit_{name}" for name in wanted} <= set(units)
    together = np.concatenate(list(units.values()))
    assert len(np.unique(together)) == len(together)
    assert not np.intersect1d(together, np.concatenate([tissue.subsets["rim"], tissue.subsets["underside"]])).size
    tip = next(event.points[0] for event in made("nose").events if event.name == "pronasale")
    middles = tissue.points[tissue.face_vertex_indices.reshape(-1, 3)].mean(axis=1)
    at = int(np.linalg.norm(middles - tip, axis=1).argmin())
    assert at in units["subunit_nasal_tip"]
    left, right = (middles[units[f"subunit_ala_{side}"]].mean(axis=0) for side in ("left", "right"))
    assert left[0] < -12.0 < 12.0 < right[0]
