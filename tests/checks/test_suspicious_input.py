"""Each suspicious input gives exactly its warning, with its place; what surgeons do gives none."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.checks.suspicious_cuts import crossings
from lappet.checks.validation import check
from lappet.core.problem import Problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import (
    Event,
    Excision,
    Hook,
    Incision,
    Material,
    Point,
    Procedure,
    Region,
    Suture,
    Tissue,
    Undermine,
)
from lappet.tissue.patch import flat_patch
from lappet.usd.stage import read_procedure

TOP = 4.0
TIMELINE = "/Procedure/Timeline/"


def on_top(*points: tuple[float, float]) -> tuple[Point, ...]:
    """Points of the patch's skin."""
    return tuple((x, y, TOP) for x, y in points)


def patch(*events: Event, size: tuple[float, float, float] = (100.0, 80.0, TOP), spacing: float = 1.0) -> Procedure:
    """A patch about the origin."""
    return Procedure(flat_patch(size, resolution=10.0, spacing=spacing), events=events, end_time=9.0)


def slit(name: str = "slit", **changes: object) -> Incision:
    """A straight incision of 40 mm."""
    values = {"name": name, "time": 2.0, "points": on_top((-20, 0), (20, 0)), **changes}
    return Incision(**values)  # type: ignore[arg-type]


def hook(target: Point, start: float = 3.0) -> Hook:
    """A hook beside the slit."""
    return Hook("hook", (0.0, 2.0, TOP), ((start, (0.0, 2.0, TOP)), (8.0, target)), start, 9.0)


def only(procedure: Procedure) -> Problem:
    """The one problem of a procedure, which does not keep it from being solved."""
    (found,) = check(procedure)
    assert found.severity == "warning"
    return found


def test_a_hook_without_a_target_is_refused(tmp_path: Path) -> None:
    from lappet.usd.stage import write_procedure

    write_procedure(patch(hook((0.0, 9.0, 8.0))), tmp_path / "hook.usda")
    text = (tmp_path / "hook.usda").read_text()
    lines = text.splitlines(keepends=True)
    first = next(i for i, line in enumerate(lines) if "xformOp:translate.timeSamples" in line)
    last = next(i for i in range(first, len(lines)) if "xformOpOrder" in lines[i])
    (tmp_path / "hook.usda").write_text("".join(lines[:first] + lines[last + 1 :]))
    (found,) = check(read_procedure(tmp_path / "hook.usda"))
    assert (found.code, found.severity, found.prim) == (ProblemCode.EVENT_NO_SAMPLES, "error", f"{TIMELINE}hook")


def test_a_target_a_meter_away_is_told_with_its_place_and_the_way_there() -> None:
    found = only(patch(slit(), hook((0.0, 2.0, 1000.0))))
    assert (found.code, found.prim) == (ProblemCode.HOOK_TARGET_FAR, f"{TIMELINE}hook")
    assert found.value == "996"
    assert found.place is not None
    assert found.place.points[0] == (0.0, 2.0, 1000.0)


def test_a_target_half_a_diagonal_away_is_told_and_a_nearer_one_is_not() -> None:
    far = 0.5 * math.hypot(100.0, 80.0, TOP)
    assert check(patch(slit(), hook((0.0, 2.0, TOP + 0.99 * far)))) == []
    assert only(patch(slit(), hook((0.0, 2.0, TOP + 1.01 * far)))).code == ProblemCode.HOOK_TARGET_FAR


def test_freed_skin_may_be_carried_twice_as_far_as_it_turns_about_its_base() -> None:
    far = 0.5 * math.hypot(100.0, 80.0, TOP)
    freed = Undermine("freed", 2.0, on_top((-20, -20), (20, -20), (20, 20), (-20, 20)))
    assert check(patch(slit(), freed, hook((0.0, 2.0, TOP + 1.9 * far)))) == []
    assert only(patch(slit(), freed, hook((0.0, 2.0, TOP + 2.1 * far)))).code == ProblemCode.HOOK_TARGET_FAR
    early = hook((0.0, 2.0, TOP + 1.9 * far), start=1.0)
    assert only(patch(slit(), freed, early)).code == ProblemCode.HOOK_TARGET_FAR


def test_a_suture_of_what_a_hook_brings_together_is_not_too_long() -> None:
    far = ((-45.0, 0.0, TOP), (45.0, 0.0, TOP))
    suture = Suture("suture", far, start=8.0, duration=1.0)
    assert only(patch(slit(), suture)).code == ProblemCode.SUTURE_LONG
    carries = Hook("carries", (-44.0, 0.0, TOP), ((3.0, far[0]), (8.0, (0.0, 0.0, TOP))), 3.0, 9.0)
    assert check(patch(slit(), carries, suture)) == []
    assert only(patch(slit(), replace(carries, start=8.5), suture)).code == ProblemCode.SUTURE_LONG


def test_an_incision_that_runs_50_mm_off_the_patch_is_told_with_where_it_ends() -> None:
    found = only(patch(slit(points=on_top((0, 0), (100, 0)))))
    assert (found.code, found.prim, found.value) == (ProblemCode.INCISION_RUNS_OFF, f"{TIMELINE}slit", "50")
    assert found.place is not None
    assert found.place.points[-1] == pytest.approx((100.0, 0.0, TOP))


def test_an_incision_that_ends_beyond_the_border_to_part_it_is_not_suspicious() -> None:
    assert check(patch(slit(points=on_top((-60, 0), (60, 0))))) == []


def test_the_same_incision_twice_is_told_once_with_the_other() -> None:
    found = only(patch(slit(), slit("again", time=3.0, points=on_top((20, 0.2), (-20, 0.2)))))
    assert (found.code, found.prim, found.value) == (ProblemCode.INCISION_TWICE, f"{TIMELINE}again", "100")
    assert "slit" in found.message


@pytest.mark.parametrize(
    "other",
    [
        slit("deeper", time=3.0, depth=None),
        slit("apart", time=3.0, points=on_top((-20, 0.6), (20, 0.6)), depth=1.0),
        slit("onward", time=3.0, points=on_top((5, 0), (45, 0)), depth=1.0),
        slit("across", time=3.0, points=on_top((0, -20), (0, 20)), depth=1.0),
    ],
    ids=lambda each: each.name,
)
def test_incisions_that_go_deeper_apart_onward_or_across_are_not_the_same(other: Incision) -> None:
    assert check(patch(slit(depth=1.0), other)) == []


def test_an_8_is_told_with_its_crossing() -> None:
    eight = on_top((-20, -10), (20, 10), (20, -10), (-20, 10))
    found = only(patch(slit(points=eight, closed=True)))
    assert (found.code, found.prim) == (ProblemCode.INCISION_CROSSES_ITSELF, f"{TIMELINE}slit")
    assert found.place is not None
    assert found.place.points == pytest.approx(np.array([(0.0, 0.0, TOP)]), abs=1e-9)
    smooth = slit(points=on_top((-20, -10), (0, 0), (20, 10), (20, -10), (0, 0), (-20, 10)), closed=True)
    assert only(patch(replace(smooth, basis="catmullRom"))).code == ProblemCode.INCISION_CROSSES_ITSELF


@pytest.mark.parametrize(
    "points",
    [
        ((-20, 0), (20, 0), (20, 20), (-20, 0)),
        ((-20, 0), (20, 0), (20, 20), (0, 20), (0, 0)),
        ((-20, 0), (-10, 1), (0, 0), (10, 1), (20, 0), (20, 0)),
        ((-20, 0), (20, 0.4), (-20, 0.8)),
    ],
    ids=["ring that ends where it begins", "six", "zigzag", "hairpin"],
)
def test_curves_that_touch_themselves_with_an_end_or_run_back_do_not_cross(
    points: tuple[tuple[float, float], ...],
) -> None:
    assert check(patch(slit(points=on_top(*points)))) == []


def test_crossings_are_found_on_curved_skin_where_chords_pass_over_each_other() -> None:
    turn = np.linspace(0.0, 2.0 * np.pi, 101)
    x, y = 20.0 * np.sin(turn), 10.0 * np.sin(2.0 * turn)
    dome = np.stack([x, y, np.sqrt(60.0**2 - x**2 - y**2)], axis=1)
    assert crossings(dome, True, 0.5) == pytest.approx(np.array([(0.0, 0.0, 60.0)]), abs=1e-3)
    assert len(crossings(dome[:50], False, 0.5)) == 0


def test_a_kerf_of_10_mm_is_told_and_one_of_a_scalpel_is_not() -> None:
    found = only(patch(slit(kerf=10.0)))
    assert (found.code, found.prim, found.value) == (ProblemCode.KERF_WIDE, f"{TIMELINE}slit", "10")
    assert check(patch(slit(kerf=0.4), spacing=0.25)) == []


def test_a_suture_across_the_patch_is_told_with_both_ends() -> None:
    found = only(patch(slit(), Suture("stitch", on_top((-40, 1), (40, -1)), 4.0)))  # type: ignore[arg-type]
    assert (found.code, found.prim) == (ProblemCode.SUTURE_LONG, f"{TIMELINE}stitch")
    assert found.place is not None
    assert found.place.points == on_top((-40, 1), (40, -1))


def two_patches(apart: tuple[float, float, float]) -> Tissue:
    """Two patches in one mesh, the second one a fifth as large."""
    large, small = flat_patch((50.0, 40.0, TOP), 10.0), flat_patch((10.0, 40.0, TOP), 10.0)
    faces, shift = len(large.face_vertex_counts), len(large.points)
    return replace(
        large,
        points=np.concatenate([large.points, small.points + np.array(apart)]),
        face_vertex_counts=np.concatenate([large.face_vertex_counts, small.face_vertex_counts]),
        face_vertex_indices=np.concatenate([large.face_vertex_indices, small.face_vertex_indices + shift]),
        subsets={name: np.concatenate([large.subsets[name], small.subsets[name] + faces]) for name in ("fixed", "bed")},
        uv=None,
    )


def test_two_shells_are_told_with_the_faces_and_the_middle_of_the_smaller() -> None:
    tissue = two_patches((60.0, 0.0, 0.0))
    found = only(Procedure(tissue, end_time=2.0))
    assert (found.code, found.value) == (ProblemCode.TISSUE_SEPARATE, "2")
    assert found.place is not None
    assert min(found.place.faces) >= len(flat_patch((50.0, 40.0, TOP), 10.0).face_vertex_counts)
    assert found.place.points[0] == pytest.approx((60.0, 0.0, 0.5 * TOP))


def test_a_cavity_is_no_second_shell() -> None:
    outer, inner = flat_patch((60.0, 60.0, 60.0), 30.0), flat_patch((20.0, 20.0, 20.0), 10.0)
    turned = inner.face_vertex_indices.reshape(-1, 4)[:, ::-1].reshape(-1) + len(outer.points)
    hollow = replace(
        outer,
        points=np.concatenate([outer.points, inner.points + np.array((0.0, 0.0, 20.0))]),
        face_vertex_counts=np.concatenate([outer.face_vertex_counts, inner.face_vertex_counts]),
        face_vertex_indices=np.concatenate([outer.face_vertex_indices, turned.astype(np.int32)]),
        uv=None,
    )
    assert check(Procedure(hollow, end_time=2.0)) == []


def test_a_patch_60_m_wide_and_one_of_a_millimetre_are_told() -> None:
    wide = Procedure(flat_patch((60_000.0, 40.0, TOP), resolution=1000.0, spacing=2.0), end_time=2.0)
    assert (only(wide).code, only(wide).value) == (ProblemCode.TISSUE_LARGE, "60000")
    tiny = Procedure(flat_patch((1.0, 0.8, 0.04), resolution=0.1, spacing=0.02), end_time=2.0)
    assert only(tiny).code == ProblemCode.TISSUE_SMALL


def test_regions_whose_order_decides_are_told_as_a_note() -> None:
    tissue = patch().tissue
    skin = np.setdiff1d(np.arange(len(tissue.face_vertex_counts)), np.concatenate([*tissue.subsets.values()]))
    layered = replace(
        tissue,
        subsets={**tissue.subsets, "left": skin[:20], "right": skin[15:40]},
        regions=(Region("left", "fat", 1.0), Region("right", "scar", 0.0, 3.0)),
    )
    materials = (Material(), Material("fat"), Material("scar"))
    (found,) = check(Procedure(layered, materials=materials, end_time=2.0))
    assert (found.code, found.severity) == (ProblemCode.REGIONS_OVERLAP, "note")
    assert found.place is not None
    assert found.place.faces == tuple(skin[15:20].tolist())
    assert "5 faces, 1 to 3 mm deep" in found.message
    assert "of scar" in found.message, "the daemon lets the last region count"
    apart = replace(layered, regions=(Region("left", "fat", 3.0), Region("right", "scar", 0.0, 3.0)))
    assert check(Procedure(apart, materials=materials, end_time=2.0)) == []


@pytest.mark.parametrize(
    ("regions", "told"),
    [
        ((Region("wide", "fat", 1.0), Region("narrow", "scar", 2.0)), False),
        ((Region("wide", "fat", 1.0), Region("same", "scar", 2.0, 3.0)), False),
        ((Region("wide", "fat", 1.0), Region("narrow", "scar", 1.0)), False),
        ((Region("wide", "fat", 1.0), Region("narrow", "scar", 0.5)), True),
        ((Region("narrow", "scar", 2.0), Region("wide", "fat", 1.0)), True),
        ((Region("wide", "fat", 1.0), Region("same", "scar", 1.0)), True),
    ],
    ids=["within, deeper", "a layer of it", "below a part of it", "out above", "hidden by the wide one", "all of it"],
)
def test_a_region_that_is_a_part_of_one_before_it_is_meant(regions: tuple[Region, ...], told: bool) -> None:
    tissue = patch().tissue
    skin = np.setdiff1d(np.arange(len(tissue.face_vertex_counts)), np.concatenate([*tissue.subsets.values()]))
    faces = {"wide": skin[:20], "same": skin[:20], "narrow": skin[5:15]}
    in_order = {region.faces: faces[region.faces] for region in regions}
    layered = replace(tissue, subsets={**tissue.subsets, **in_order}, regions=regions)
    materials = (Material(), Material("fat"), Material("scar"))
    found = check(Procedure(layered, materials=materials, end_time=2.0))
    assert [each.code for each in found] == [ProblemCode.REGIONS_OVERLAP] * told


def test_what_is_wrong_is_not_suspicious_as_well() -> None:
    (found,) = check(patch(slit(kerf=math.inf), Excision("piece", 3.0, on_top((0, 30)))))
    assert found.severity == "error"
