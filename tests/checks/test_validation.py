"""`lappet.checks.validation` beyond the corpus: valid procedures pass, estimates hold, everything is said at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from lappet.checks.lattice_size import TissueMeasure
from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    MODELS,
    Excision,
    Hook,
    Incision,
    Landmark,
    Material,
    Procedure,
    Region,
    Suture,
    Thin,
    Tissue,
    Undermine,
)
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import PRESETS, skin_over_fat
from lappet.tissue.rest_space import RestSpace

RING = ((-5, -5, 4), (5, -5, 4), (5, 5, 4), (-5, 5, 4))
GOOD = Procedure(flat_patch((60, 40, 4), 4.0), end_time=20.0).with_events(
    Incision("cut", 2.0, RING, closed=True),
    Excision("piece", 3.0, ((0, 0, 2),)),
    Undermine("free", 4.0, ((-20, -15, 4), (20, -15, 4), (20, 15, 4), (-20, 15, 4))),
    Hook("hook", (-7, 0, 4), ((5.0, (-7, 0, 4)), (9.0, (0, 0, 6))), 5.0, 10.0),
    Suture("stitch", ((-6, 0, 4), (6, 0, 4)), 10.0, 4.0),
    Landmark("edge", ((-6, 1, 4),), "edge"),
)


def test_a_sound_procedure_has_no_problem() -> None:
    assert check(GOOD) == []


def test_a_thinning_is_warned_about_that_leaves_less_than_the_skin_or_a_cell_and_refused_below_nothing() -> None:
    layered = skin_over_fat(Procedure(flat_patch((60, 40, 4), 4.0, spacing=1.0), end_time=20.0), 1.5)

    def codes(**changed: float) -> list[ProblemCode]:
        thin = replace(Thin("thin", 4.0, RING, 2.0), **changed)
        return [each.code for each in check(layered.with_events(thin))]

    assert codes() == codes(thickness=1.5) == []
    assert codes(thickness=1.2) == [ProblemCode.THIN_INTO_SKIN]
    assert codes(thickness=0.9) == [ProblemCode.THIN_INTO_SKIN, ProblemCode.THIN_BELOW_CELLS]
    assert codes(thickness=0.0) == codes(thickness=float("nan")) == [ProblemCode.THIN_THICKNESS]
    assert codes(dressing=-1.0) == codes(duration=-1.0) == [ProblemCode.THIN_NUMBER]
    assert codes(time=30.0) == [ProblemCode.EVENT_AFTER_END]
    off = replace(Thin("thin", 4.0, RING, 2.0), points=tuple((x, y, z + 40.0) for x, y, z in RING))
    assert [each.code for each in check(layered.with_events(off))] == [ProblemCode.CURVE_OFF_TISSUE]


def test_a_run_off_curve_and_a_seed_inside_the_tissue_are_fine() -> None:
    block = Procedure(flat_patch((60, 40, 40), 10.0), end_time=9.0).with_events(
        Incision("cut", 2.0, ((-40, 0, 40), (40, 0, 40))), Excision("half", 3.0, ((0, 10, 20),))
    )
    assert check(block) == []


def test_a_thread_must_be_known_and_none_of_its_numbers_negative() -> None:
    stitch = GOOD.events[4]
    assert isinstance(stitch, Suture)
    thread = replace(stitch, mode="thread", thread="silk 4-0", length=1.0, tension=200.0, pull_through=900.0)
    assert check(replace(GOOD, events=(thread,))) == []
    wrong = replace(thread, mode="glued", thread="hemp 4-0", length=-1.0, tension=float("nan"))  # type: ignore[arg-type]
    found = check(replace(GOOD, events=(wrong,)))
    codes = ProblemCode.SUTURE_MODE, ProblemCode.SUTURE_THREAD, ProblemCode.SUTURE_NUMBER, ProblemCode.SUTURE_NUMBER
    assert tuple(each.code for each in found) == codes
    assert all(each.prim == "/Procedure/Timeline/stitch" for each in found)


def test_a_thread_may_have_many_bites_and_end_where_it_begins() -> None:
    stitch = next(event for event in GOOD.events if isinstance(event, Suture))
    loop = ((-6, 0, 4), (-6, 0, 2), (6, 0, 2), (6, 0, 4), (-6, 0, 4))
    assert check(replace(GOOD, events=(replace(stitch, anchors=loop, mode="thread"),))) == []
    short = check(replace(GOOD, events=(replace(stitch, anchors=loop[:1]),)))
    assert [each.code for each in short] == [ProblemCode.SUTURE_ANCHORS]
    backwards = replace(stitch, name="again", anchors=loop[1::-1], mode="thread")
    forwards = replace(stitch, anchors=loop[:2], mode="thread")
    twice = check(replace(GOOD, events=(forwards, backwards)))
    assert [each.code for each in twice] == [ProblemCode.SUTURE_TWICE]


def test_several_hooks_may_follow_each_other_on_one_point() -> None:
    first = GOOD.events[3]
    assert isinstance(first, Hook)
    after = replace(first, name="later", start=10.0, release=12.0)
    assert check(GOOD.with_events(after)) == []
    overlapping = replace(after, start=9.5)
    assert [problem.prim for problem in check(GOOD.with_events(overlapping))] == ["/Procedure/Timeline/later"]


@pytest.mark.parametrize("model", MODELS)
def test_every_model_may_have_fibers_muscle_and_prestretch(model: str) -> None:
    rich = Material(
        model=model,
        mooney_ratio=0.5,
        fiber_k1=10.0,
        fiber_k2=1.0,
        fiber_dispersion=1 / 3,
        prestretch=(1.2, 0.9),
        muscle_stress=300.0,
        muscle_activation=((1.0, 0.0), (5.0, 1.0)),
    )
    assert check(replace(GOOD, materials=(rich,))) == []
    fat = replace(rich, name="fat", poissons_ratio=0.5)  # not in use, but wrong
    assert len(check(replace(GOOD, materials=(rich, fat)))) == 1


def test_skin_over_fat_is_sound_and_the_regions_before_it_still_win() -> None:
    layered = skin_over_fat(GOOD, 2.0)
    assert check(layered) == []
    assert [material.name for material in layered.materials_in_use()] == ["skin", "fat"]
    scar = replace(
        layered.tissue,
        subsets={**layered.tissue.subsets, "scar": layered.tissue.subsets["fat_below"][:3]},
        regions=(*layered.tissue.regions, Region("scar", "skin", 0.0, 3.0)),
    )
    again = skin_over_fat(replace(layered, tissue=scar), 1.5)
    assert [region.faces for region in again.tissue.regions] == ["fat_below", "scar"]
    assert again.tissue.regions[0].depth_from == 1.5
    assert len(again.materials) == 2


def test_every_preset_is_sound_and_says_its_source() -> None:
    for name, preset in PRESETS.items():
        assert preset.material.name == name
        assert check(replace(GOOD, materials=(replace(preset.material, name="skin"),))) == []
        assert preset.source.startswith(preset.summary)
        assert "Chosen: " in preset.source


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_no_number_may_be_infinite_or_nan(value: float) -> None:
    broken = [
        replace(GOOD, materials=(replace(Material(), **{name: value}),))
        for name in (
            "youngs_modulus",
            "poissons_ratio",
            "mooney_ratio",
            "fiber_k1",
            "fiber_k2",
            "fiber_slack",
            "fiber_angle",
            "density",
            "muscle_stress",
        )
    ]
    broken += [
        replace(GOOD, tissue=replace(GOOD.tissue, **{name: value}))
        for name in ("spacing", "gravity", "bed_stiffness", "bed_shear")
    ]
    broken += [replace(GOOD, **{name: value}) for name in ("start_time", "end_time", "fps")]
    muscle = Material(muscle_stress=300.0)
    broken += [
        replace(GOOD, materials=(replace(muscle, muscle_activation=(sample,)),))
        for sample in ((value, 0.5), (2.0, value))
    ]
    broken.append(replace(GOOD, materials=(Material(prestretch=(1.0, value)),)))
    layered = skin_over_fat(GOOD, 2.0)
    bad = replace(layered.tissue.regions[0], depth_from=value)
    broken.append(replace(layered, tissue=replace(layered.tissue, regions=(bad,))))
    for i, event in enumerate(GOOD.events):
        for name in ("time", "kerf", "depth", "start", "release", "duration", "stiffness"):
            if hasattr(event, name):
                events = [*GOOD.events]
                events[i] = replace(event, **{name: value})
                broken.append(replace(GOOD, events=tuple(events)))
        for name in ("points", "seeds", "anchors"):
            if hasattr(event, name):
                first, *others = getattr(event, name)
                events = [*GOOD.events]
                events[i] = replace(event, **{name: ((first[0], value, first[2]), *others)})
                broken.append(replace(GOOD, events=tuple(events)))
    assert len(broken) == 9 + 5 + 3 + 3 + 3 + 1 + 1 + 3 + 3 + 5
    for procedure in broken:
        problems = check(procedure)
        assert any(problem.severity == "error" for problem in problems), repr(procedure)


def test_the_estimate_of_cells_is_exact_for_an_aligned_box_up_to_its_rim() -> None:
    patch = flat_patch((100, 80, 4), 2.0, triangles=True)
    triangles = patch.face_vertex_indices.reshape(-1, 3)
    measure = TissueMeasure(patch.points, triangles)
    assert measure.volume == pytest.approx(32000.0)
    assert 32000 <= measure.lattice(1.0).cells <= 32000 * 1.6
    least = measure.least_spacing(1 << 30)
    assert measure.lattice(least).bytes <= 1 << 30 < measure.lattice(least / 1.2).bytes


def test_a_mended_spacing_is_accepted() -> None:
    fine = replace(GOOD, tissue=replace(GOOD.tissue, spacing=0.02))
    (problem,) = check(fine)
    least = float(problem.remedy.split()[-2])
    assert check(fine, spacing=least) == []


def test_inside_and_outside_agree_with_the_formula_of_a_torus() -> None:
    mesh = trimesh.creation.torus(20.0, 6.0, major_sections=96, minor_sections=48)
    queries = np.random.default_rng(3).uniform(-30, 30, (60, 3)) * [1, 1, 0.3]
    rest = RestSpace(np.asarray(mesh.vertices), mesh.faces)
    outside = np.hypot(np.hypot(queries[:, 0], queries[:, 1]) - 20.0, queries[:, 2]) - 6.0
    clear = np.abs(outside - rest.margin) > 0.05  # the facets are that far from the torus
    assert clear.sum() > 50
    expected = np.where(outside > rest.margin, outside, 0.0)
    assert rest.off(queries)[clear] == pytest.approx(expected[clear], abs=0.05)


def test_a_large_tissue_is_checked_in_a_few_seconds() -> None:
    patch = flat_patch((200, 200, 4), 1.0)
    procedure = Procedure(replace(patch, subsets={"fixed": patch.subsets["fixed"]}), end_time=9.0)
    assert len(patch.face_vertex_counts) > 80_000
    assert check(procedure) == []


def test_a_mobius_strip_is_refused_as_one_sided() -> None:
    n = 24
    angle = np.arange(n) * 2 * np.pi / n
    rings = [np.stack([(10 + w * np.cos(angle / 2)) * np.cos(angle), (10 + w * np.cos(angle / 2)) * np.sin(angle),
                       w * np.sin(angle / 2)], axis=1) for w in (-2.0, 2.0)]  # fmt: skip
    quads = [[i, i + 1, n + i + 1, n + i] for i in range(n - 1)] + [[n - 1, n, 0, 2 * n - 1]]
    strip = Tissue(np.concatenate(rings), np.full(n, 4), np.array(quads).ravel())
    said = [problem.message for problem in check(Procedure(strip)) if problem.severity == "error"]
    assert any("open" in sentence for sentence in said)
    assert any("oriented" in sentence for sentence in said)
