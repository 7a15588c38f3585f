"""Every design of the flap library: its drawing fits together, on flat and curved skin; its operation is sound."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.checks.validation import check
from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.designs import FlapDesign, Row, Schedule, Technique, limberg
from lappet.designs.flat_curves import arc, bow, length, s_curve
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.library import DESIGNS, library_design
from lappet.designs.library_operation import (
    add_flap,
    flap_on_patch,
    landmark_place,
    skin_line_direction,
    thickness_at,
)
from lappet.designs.seam_sutures import sutures
from lappet.procedure import Excision, Hook, Incision, Landmark, Procedure, SkinLine, Suture, SutureRun
from lappet.suturing import with_single_sutures
from lappet.tissue.dome import dome_scalp
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_sheet import SkinSheet
from refusals import refuses

EVERY = pytest.mark.parametrize("name", DESIGNS)


def drawn(name: str, mirrored: bool = False, **values: float) -> FlapDesign:
    row = library_design(name)
    return row.draw(np.zeros(3), (1.0, 0.0, 0.0), mirrored=mirrored, **row.values(values))


def flat(points) -> NDArray[np.float64]:
    return np.array(points, np.float64)[:, :2]


def inside(outline: NDArray[np.float64], point: NDArray[np.float64]) -> bool:
    a = outline - point
    b = np.roll(a, -1, axis=0)
    cross, dot = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("ij,ij->i", a, b)
    return bool(abs(np.arctan2(cross, dot).sum()) > np.pi)


def area(outline: NDArray[np.float64]) -> float:
    turned = np.roll(outline, -1, axis=0)
    return 0.5 * float(np.sum(outline[:, 0] * turned[:, 1] - outline[:, 1] * turned[:, 0]))


def to_cuts(design: FlapDesign, point: NDArray[np.float64]) -> float:
    """Distance of a point to the nearest drawn line."""
    closed = [np.vstack([flat(cut.outline), flat(cut.outline[:1])]) for cut in design.excised]
    best = np.inf
    for curve in [*closed, *(flat(points) for points in design.incisions)]:
        start, way = curve[:-1], np.diff(curve, axis=0)
        share = np.einsum("ij,ij->i", point - start, way) / np.maximum(np.einsum("ij,ij->i", way, way), 1e-300)
        on = start + np.clip(share, 0.0, 1.0)[:, None] * way
        best = min(best, float(np.linalg.norm(on - point, axis=1).min()))
    return best


@EVERY
@pytest.mark.parametrize("mirrored", [False, True])
def test_what_is_excised_lies_around_its_seed_counterclockwise(name: str, mirrored: bool) -> None:
    for cut in drawn(name, mirrored).excised:
        assert area(flat(cut.outline)) > 1.0
        assert inside(flat(cut.outline), np.array(cut.seed)[:2])


@EVERY
@pytest.mark.parametrize("mirrored", [False, True])
def test_every_edge_lies_on_a_cut_and_its_tissue_is_not_excised(name: str, mirrored: bool) -> None:
    design = drawn(name, mirrored)
    for seam in design.seams:
        for edge in seam.edges:
            points = flat(edge.points)
            way = np.diff(points, axis=0)
            middle = 0.5 * (points[:-1] + points[1:])
            left = np.column_stack([-way[:, 1], way[:, 0]]) / np.linalg.norm(way, axis=1)[:, None] * edge.side
            for at, beside in zip(middle, middle + 0.25 * left, strict=True):
                assert to_cuts(design, at) < 0.1
                assert not any(inside(flat(cut.outline), beside) for cut in design.excised)


@EVERY
def test_the_two_edges_of_a_seam_are_of_like_length(name: str) -> None:
    """As surgeons can gather them: a flap's edge and its wound's differ by at most half."""
    for seam in drawn(name).seams:
        one, other = (length(np.array(edge.points)) for edge in seam.edges)
        assert max(one, other) / min(one, other) < 1.55, seam.name


@EVERY
def test_seams_use_every_cut_on_both_its_sides(name: str) -> None:
    """Each drawn cut is sewn on both lips, and each rim of what is excised on its outer one, but for short ends."""
    design = drawn(name)
    sewn = sum(length(np.array(edge.points)) for seam in design.seams for edge in seam.edges)
    rims = sum(length(np.array([*cut.outline, cut.outline[0]])) for cut in design.excised)
    lips = sum(2.0 * length(np.array(curve)) for curve in design.incisions)
    bases = sum(_base(design, cut.name) for cut in design.excised)
    assert sewn == pytest.approx(rims + lips - 2.0 * bases - _left_open(name), rel=0.03)


def _left_open(name: str) -> float:
    """Length of edges that a design at its defaults leaves unsewn in its first stage, mm."""
    value = {parameter.name: parameter.default for parameter in library_design(name).parameters}
    if name == "karapandzic":  # the defect's side along the mouth
        return value["width"]
    if name == "keystone-ii":  # the gap behind the island, for a graft
        radius = (value["length"] ** 2 + value["width"] ** 2) / (4.0 * value["width"])
        back = (radius + value["breadth"] * value["width"]) * 4.0 * np.arctan2(value["width"], value["length"])
        return float(2.0 * back + 2.0 * value["advance"] * value["width"])
    if name == "paramedian-forehead":
        r, half = 0.5 * value["diameter"], 0.5 * value["width"]
        joined = 2.0 * r * np.arcsin(half / r)  # of the defect's rim, where the pedicle leaves the paddle
        pedicle = value["distance"] + value["spare"] - np.sqrt(r**2 - half**2)
        donor = 2.0 * np.pi * r - joined  # the paddle's place, which heals by itself
        return float(joined + 2.0 * pedicle + 2.0 * value["stump"] + donor)
    return 0.0


def _base(design: FlapDesign, name: str) -> float:
    """Length of what is excised beside a lip and not sewn, counted half as its own rim and half as the lip, or 0."""
    seams = {seam.name: seam for seam in design.seams}
    if name not in seams or name == "defect":
        return 0.0
    first, second = (np.array(edge.points[0]) for edge in seams[name].edges)
    (cut,) = (cut for cut in design.excised if cut.name == name)
    if not cut.late:
        return float(np.linalg.norm(first - second))
    whole = length(np.array([*cut.outline, cut.outline[0]]))
    unsewn = whole - sum(length(np.array(edge.points)) for edge in seams[name].edges)
    rim = np.array(design.excised[0].outline)  # a dog-ear's base is a part of the defect's rim
    ends = sorted(int(np.linalg.norm(rim - end, axis=1).argmin()) for end in (first, second))
    along = length(rim[ends[0] : ends[1] + 1])
    return 0.5 * (unsewn + min(along, length(np.vstack([rim, rim[:1]])) - along))


@EVERY
def test_mirroring_turns_a_design_into_its_image(name: str) -> None:
    here, there = drawn(name), drawn(name, mirrored=True)
    for one, other in zip(here.seams, there.seams, strict=True):
        for a, b in zip(one.edges, other.edges, strict=True):
            assert np.array(b.points) == pytest.approx(np.array(a.points) * (1.0, -1.0, 1.0), abs=1e-9)
            assert b.side == -a.side


@EVERY
def test_on_a_dome_limbs_keep_their_lengths_and_the_design_its_place(name: str) -> None:
    """Geodesics from the middle: lengths across them shrink as sin(s / R) / (s / R), here at most by 7 %."""
    dome = dome_scalp(90.0, 75.0, 6.0, resolution=2.0)
    on_dome = flap_on_skin(dome, name, (0.0, 0.0, 90.0), (1.0, 0.0, 0.0))
    plane = drawn(name)
    for one, other in zip(plane.seams, on_dome.seams, strict=True):
        for a, b in zip(one.edges, other.edges, strict=True):
            assert length(np.array(b.points)) == pytest.approx(length(np.array(a.points)), rel=0.07)
            assert np.linalg.norm(np.array(b.points), axis=1) == pytest.approx(90.0, abs=0.1)


@EVERY
def test_the_operation_of_a_design_at_its_defaults_has_no_problem(name: str) -> None:
    procedure = flap_on_patch(name, spacing=2.0)
    assert [str(each) for each in check(procedure) if each.severity == "error"] == []
    kinds = {type(event) for event in procedure.events}
    design = drawn(name)
    assert SutureRun in kinds
    assert Suture not in kinds
    assert (Excision in kinds) == bool(design.excised)
    hooks = [event for event in procedure.events if isinstance(event, Hook)]
    assert len(hooks) == len(design.carries)
    assert all(event.time >= procedure.start_time for event in procedure.events if isinstance(event, Incision))
    sutures = [event for event in procedure.events if isinstance(event, Suture)]
    assert all(event.start + event.duration <= procedure.end_time for event in sutures)


def test_the_z_of_60_degrees_gains_73_percent() -> None:
    """D. W. Furnas and G. W. Fischer 1971: the long diagonal is sqrt(3) limbs."""
    corners = {corner.name: corner for corner in drawn("z-plasty").corners}
    ends = [np.array(corners[name].wound.point) for name in ("first", "second")]
    assert np.linalg.norm(ends[0] - ends[1]) == pytest.approx(np.sqrt(3.0) * 20.0)


def test_zitellis_lobes_turn_about_the_pivot_by_about_a_hundred_degrees() -> None:
    design = drawn("bilobed")
    pivot = np.array(design.carries[0].pivot)
    way = [np.array(carry.corner.point) - pivot for carry in design.carries]
    lay = [np.array(carry.lay.point) - pivot for carry in design.carries]

    def turn(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
        return float(np.degrees(np.arccos(a @ b / np.linalg.norm(a) / np.linalg.norm(b))))

    both = sum(turn(a, b) for a, b in zip(way, lay, strict=True))
    assert 90.0 < both < 110.0  # Zitelli 1989
    # The first lobe reaches as far from the pivot as the defect's far side, three radii.
    assert np.linalg.norm(way[0]) == pytest.approx(18.0, rel=0.03)


def test_an_island_fits_its_defect_when_it_has_moved_by_the_defects_height() -> None:
    design = drawn("island-v-y", width=20.0, height=0.5)
    seams = {seam.name: [flat(edge.points) for edge in seam.edges] for seam in design.seams}
    base, far = seams["defect"]
    assert far - base == pytest.approx(np.tile([10.0, 0.0], (len(base), 1)), abs=1e-3)
    for side in ("left", "right"):
        island, lip = (length(edge) for edge in seams[side])
        assert lip == pytest.approx(island, abs=0.1)
    assert length(seams["donor_stem"][0]) == pytest.approx(10.0, abs=0.1)


def test_a_dorsal_nasal_flaps_incisions_meet_in_the_glabella_at_some_thirty_degrees() -> None:
    """A blunter angle leaves a dog-ear there: absent below 30° (Chen), and a V–Y's tip is 20° to 60°."""
    (cut,) = (flat(curve) for curve in drawn("dorsal-nasal").incisions)
    apex = int(cut[:, 0].argmax())
    one, other = (cut[apex + k] - cut[apex] for k in (-3, 3))
    angle = np.degrees(np.arccos(one @ other / (np.linalg.norm(one) * np.linalg.norm(other))))
    assert 25.0 < angle < 36.0


def test_the_teeth_of_a_w_plasty_fit_into_each_other() -> None:
    one, other = (np.array(edge.points) for edge in drawn("w-plasty").seams[0].edges)
    inner = np.abs(one[:, 0]) < 20.0
    assert (other - one)[inner] == pytest.approx(np.tile([0.0, 8.0, 0.0], (inner.sum(), 1)), abs=1e-9)


def test_an_o_z_is_its_own_image_when_turned_by_half() -> None:
    first, second = (np.array(curve) for curve in drawn("o-z").incisions)
    assert second == pytest.approx(-first, abs=1e-9)


def test_curves_have_their_lengths() -> None:
    assert length(arc((0.0, 0.0), 10.0, 0.0, 90.0, 0.1)) == pytest.approx(5.0 * np.pi, rel=1e-4)
    assert length(bow((-5.0, 0.0), (5.0, 0.0), 5.0, step=0.1)) == pytest.approx(5.0 * np.pi, rel=1e-3)
    assert length(s_curve(40.0, 120.0, 60.0)) == pytest.approx(40.0, rel=0.01)


@pytest.mark.parametrize(
    ("name", "values", "code"),
    [
        ("limburg", {}, ProblemCode.DESIGN_UNKNOWN),
        ("limberg", {"radius": 3.0}, ProblemCode.DESIGN_PARAMETER),
        ("limberg", {"side": 600.0}, ProblemCode.DESIGN_RANGE),
        ("limberg", {"side": float("nan")}, ProblemCode.DESIGN_RANGE),
        ("o-z", {"advance": 0.75, "diameter": 3.0, "arc": 5.0, "turn": 170.0}, None),
        ("fusiform", {"length": 10.0, "width": 20.0}, ProblemCode.DESIGN_OVAL),
        ("w-plasty", {"length": 6.0, "side": 12.0}, ProblemCode.DESIGN_TEETH),
        ("rotation", {"width": 30.0, "length": 16.0}, ProblemCode.DESIGN_ANGLE),
    ],
)
def test_a_design_that_does_not_exist_or_fit_is_refused(name: str, values: dict, code: ProblemCode | None) -> None:
    if code is None:
        assert flap_on_patch(name, values, spacing=2.0).events
        return
    with refuses(code):
        flap_on_patch(name, values, spacing=2.0)


def test_a_design_larger_than_the_skin_is_refused_with_the_place_and_what_fits() -> None:
    patch = flat_patch((60.0, 60.0, 4.0), spacing=2.0)
    with pytest.raises(RefusedError) as found:
        flap_on_skin(patch, "limberg", (20.0, 0.0, 4.0), (1.0, 0.0, 0.0))
    (problem,) = found.value.problems
    assert problem.code == ProblemCode.DESIGN_OFF_SKIN
    assert problem.place is not None
    assert problem.place.points[0][0] == pytest.approx(30.0, abs=0.6)
    # The tip lies 27 mm ahead of the defect's middle and the border 10: at most 37 % fits.
    assert "37 %" in problem.remedy
    smaller = flap_on_skin(patch, "limberg", (20.0, 0.0, 4.0), (1.0, 0.0, 0.0), {"side": 0.35 * 18.0})
    assert smaller.excised


def test_a_second_flap_has_names_of_its_own_and_begins_where_the_first_ends() -> None:
    patch = Procedure(flat_patch((140.0, 80.0, 4.0), spacing=2.0), start_time=1, end_time=1)
    one = add_flap(patch, "z-plasty", (-35.0, 0.0, 4.0), (0.0, 1.0, 0.0))
    two = add_flap(one, "z-plasty", (35.0, 0.0, 4.0), (0.0, 1.0, 0.0), {"limb": 12.0})
    three = add_flap(two, "fusiform", (0.0, 0.0, 4.0), (0.0, 1.0, 0.0), {"length": 20.0, "width": 6.0}, start=1)
    for procedure in (two, three):
        names = [event.name for event in procedure.events]
        assert len(set(names)) == len(names)
        labels = [event.label for event in procedure.events if isinstance(event, Landmark)]
        assert len(set(labels)) == len(labels)
    later = [event for event in two.events[len(one.events) :] if isinstance(event, Incision)]
    assert min(event.time for event in later) > one.end_time
    assert two.end_time == 2.0 * one.end_time - 1.0
    assert three.end_time == two.end_time


def test_a_place_and_a_direction_can_be_named() -> None:
    patch = flat_patch((80.0, 60.0, 4.0), spacing=2.0)
    line = SkinLine("line", ((-40.0, -40.0, 4.0), (40.0, 40.0, 4.0)))
    mark = Landmark("mole", ((5.0, 6.0, 4.0),), "the mole")
    procedure = Procedure(patch, events=(mark,), skin_lines=(line,))
    assert landmark_place(procedure, "the mole") == landmark_place(procedure, "mole") == (5.0, 6.0, 4.0)
    along = skin_line_direction(procedure, (5.0, 6.0, 4.0))
    assert abs(along @ np.array([1.0, 1.0, 0.0])) == pytest.approx(np.sqrt(2.0))
    across = skin_line_direction(procedure, (5.0, 6.0, 4.0), across=True)
    assert abs(across @ along) < 1e-12
    fibers = skin_line_direction(Procedure(patch), (0.0, 0.0, 4.0))
    assert abs(fibers[0]) == pytest.approx(1.0)
    with refuses(ProblemCode.DESIGN_LANDMARK):
        landmark_place(procedure, "the ala")


def test_the_thickness_is_that_above_the_bed() -> None:
    assert thickness_at(flat_patch((40.0, 40.0, 3.0)), (1.0, 2.0, 3.0)) == pytest.approx(3.0)
    assert thickness_at(dome_scalp(90.0, 40.0, 6.0), (0.0, 0.0, 90.0)) == pytest.approx(6.0, abs=0.1)


def test_a_seam_too_short_for_two_sutures_gets_one_in_its_middle() -> None:
    skin = SkinSheet.of(flat_patch((120.0, 100.0, 4.0)))
    design = limberg((0.0, 0.0, 4.0), (1.0, 0.0, 0.0), 18.0)
    placed = sutures(design, skin, Schedule(), Technique(apart=30.0, rows=(Row("skin", 0.0),)))
    for seam in design.seams:
        (own,) = [
            suture for suture in placed if suture.name.startswith(f"skin_{seam.name}_") and "corner" not in suture.name
        ]
        middle = np.array(seam.edges[0].points).mean(axis=0)
        assert np.linalg.norm(own.anchors[0] - middle) < 0.2


@EVERY
def test_sutures_of_a_design_lie_in_tissue_that_is_left(name: str) -> None:
    procedure = flap_on_patch(name, spacing=2.0)
    design = drawn(name)
    skin = SkinSheet.of(procedure.tissue)
    for event in with_single_sutures(procedure).events:
        if isinstance(event, Suture):
            for anchor in event.anchors:
                at = skin.place([anchor])[0][:2]
                assert not any(inside(flat(cut.outline), at) for cut in design.excised), event.name
