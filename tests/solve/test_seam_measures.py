"""What is measured at seams, against shapes whose lengths, areas, steps and bumps are known."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from fusiform_scene import KERF, TOP, WIDTH, closed_fusiform
from lappet.daemon.solved_frame import SolvedFrame
from lappet.procedure import Excision, Incision, Procedure, Suture
from lappet.procedure.stitches import Station, deep_dermal, running, vertical_mattress
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.solve.seam_measures import SeamGauges, SeamMeasure, SeamState
from lappet.solve.suture_forces import SutureForce
from lappet.tissue.patch import flat_patch
from small_procedure import small_procedure

RATIO = 3.0
LENGTH = RATIO * WIDTH
RADIUS = (LENGTH**2 + WIDTH**2) / (4.0 * WIDTH)
HALF = 2.0 * math.atan2(WIDTH, LENGTH)  # half the opening angle of an arc
Points = NDArray[np.float64]


def rotation(axis: Sequence[float], angle: float) -> NDArray[np.float64]:
    return np.asarray(Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis)).as_matrix())


@cache
def compiled(procedure: Procedure) -> Program:
    return compile_program(procedure)


def states(
    procedure: Procedure, move: Callable[[Points], Points], forces: Sequence[SutureForce] = ()
) -> list[SeamState]:
    """The seams of the last frame with the surface moved so."""
    program = compiled(procedure)
    last = program.frames[-1]
    points = move(program.epochs[last.epoch].surface.points.copy()).astype(np.float32)
    return SeamGauges(program).measure(SolvedFrame(last.time, points), forces)


def measures(
    procedure: Procedure, move: Callable[[Points], Points] = lambda x: x, **more: Any
) -> dict[str, SeamMeasure]:
    return {state.measure.seam: state.measure for state in states(procedure, move, **more)}


@cache
def ellipse() -> Procedure:
    return closed_fusiform(RATIO)


def drawn_together(points: Points) -> Points:
    """Both edges of the fusiform on its axis: each side moves in by its half width."""
    x, y = points[:, 0], points[:, 1]
    reach = np.sqrt(np.maximum((RADIUS + 0.5 * KERF) ** 2 - x**2, 0.0)) - (RADIUS - 0.5 * WIDTH)
    points[:, 1] = np.sign(y) * np.maximum(np.abs(y) - np.maximum(reach, 0.0), 0.0)
    return points


def test_the_edges_of_an_open_fusiform_are_its_arcs_and_its_area_is_open() -> None:
    (found,) = measures(ellipse()).values()
    arc, area = 2.0 * RADIUS * HALF, RADIUS**2 * (2.0 * HALF - math.sin(2.0 * HALF))
    assert found.first_edge_mm == pytest.approx(arc, rel=4e-3)
    assert found.second_edge_mm == pytest.approx(arc, rel=4e-3)
    assert found.edge_difference_mm < 0.01
    assert found.open_area_mm2 == pytest.approx(area + KERF * arc, rel=2e-3)
    assert found.greatest_gap_mm == pytest.approx(WIDTH + KERF, abs=0.01)
    assert found.scar_length_mm == pytest.approx(LENGTH, rel=4e-3)
    assert found.closed_share < 0.03
    assert found.tension_n_per_mm is None


@pytest.mark.parametrize("wide", [5, 17])
def test_an_island_that_is_sewn_all_around_is_closed_wherever_its_sutures_are_farthest_apart(wide: int) -> None:
    """The widest gap between two sutures is elsewhere on the island than on the rim around it."""
    turns = np.arange(24) / 24.0

    def around(radius: float, wider: int) -> list[tuple[float, float, float]]:
        angles = 2.0 * np.pi * (turns + 0.008 * (np.arange(24) >= wider) - 0.008 * np.arange(24) / 24.0)
        return [(radius * math.cos(angle), radius * math.sin(angle), TOP) for angle in angles]

    circle = tuple((12.0 * math.cos(a), 12.0 * math.sin(a), TOP) for a in np.linspace(0.0, 2.0 * np.pi, 120)[:-1])
    sutures = [
        Suture(f"ring/{k}", ends, 3.0) for k, ends in enumerate(zip(around(11.0, 11), around(13.0, wide), strict=True))
    ]
    tissue = flat_patch((60.0, 60.0, TOP), resolution=2.0, spacing=2.0)
    events = (Incision("ring_cut", 2.0, circle, kerf=KERF, closed=True), *sutures)
    (found,) = measures(replace(ellipse(), tissue=tissue, events=events, end_time=4.0)).values()
    assert found.scar_length_mm > 0.9 * 24.0 * math.pi
    assert found.closed_share > 0.98
    assert found.open_area_mm2 < 2.0 * KERF * 24.0 * math.pi


def test_a_closed_fusiform_is_a_scar_as_long_as_its_axis() -> None:
    (found,) = measures(ellipse(), drawn_together).values()
    assert found.scar_length_mm == pytest.approx(LENGTH, rel=4e-3)
    assert found.first_edge_mm == pytest.approx(LENGTH, rel=4e-3)
    assert found.open_area_mm2 < 0.05
    assert found.greatest_gap_mm < 0.02
    assert found.closed_share == 1.0
    assert found.step_off_mm == pytest.approx(0.0, abs=1e-3)
    assert found.edge_mismatch_mm == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (1.0, 2.0, 0.5), (-1.0, 0.3, -0.4)])
def test_one_side_shifted_is_a_gap_a_mismatch_and_a_step_of_that_size_however_the_patch_lies(
    axis: tuple[float, float, float],
) -> None:
    turn = rotation(axis, 1.1)

    def move(shift: tuple[float, float, float]) -> Callable[[Points], Points]:
        def moved(points: Points) -> Points:
            upper = points[:, 1] > 0.0
            points = drawn_together(points)
            points[upper] += shift
            return points @ turn.T + (3.0, -20.0, 7.0)

        return moved

    for shift in ((0.8, 0.0, 0.0), (0.0, 0.0, 1.5), (-0.4, 0.0, -0.6)):
        (state,) = states(ellipse(), move(shift))
        inside = slice(6, -6)  # at the tips one edge goes over into the other
        assert np.abs(np.abs(state.mismatch[inside]) - abs(shift[0])).max() < 0.02
        assert np.abs(np.abs(state.step[inside]) - abs(shift[2])).max() < 0.02
        assert np.ptp(state.mismatch[inside]) < 0.02
        assert np.ptp(state.step[inside]) < 0.02
        found = state.measure  # over all of the seam, with the tips that the shift tears open
        assert found.step_off_mm == pytest.approx(abs(shift[2]), abs=0.03)
        assert found.edge_mismatch_mm == pytest.approx(abs(shift[0]), abs=0.1)
    (state,) = states(ellipse(), move((0.0, 2.0, 0.0)))
    assert np.abs(state.gap[6:-6] - 2.0).max() < 0.02
    half_open_ends = 2.0 * LENGTH / 64.0  # the tips stay closed: the first and the last piece are triangles
    assert state.measure.open_area_mm2 == pytest.approx(2.0 * LENGTH - half_open_ends, rel=0.01)
    (state,) = states(ellipse(), move((0.0, -0.25, 0.0)))
    assert np.abs(state.gap[6:-6] + 0.25).max() < 0.02
    assert state.measure.open_area_mm2 < 0.1
    assert state.measure.closed_share == 1.0


def slit(*sutures: Suture) -> Procedure:
    """A cut from x = -6 to 6."""
    return small_procedure(events=(Incision("slit", 3.0, ((-6.0, 0.0, 2.0), (6.0, 0.0, 2.0)), kerf=0.1), *sutures))


def stitch(name: str, x: float, *, reach: float = 1.0, z: float = 2.0, turned: bool = False) -> Suture:
    ends = ((x, -reach, z), (x, reach, z))
    return Suture(name, ends[::-1] if turned else ends, 5.0, 2.0)


def test_closures_over_each_other_are_one_seam_whatever_the_order_and_the_side_they_are_drawn_from() -> None:
    rows = (
        *(stitch(f"deep_{k}", x, reach=0.05, z=0.7) for k, x in ((1, 3.0), (2, 0.5), (3, -3.5))),
        *(stitch(f"top_{k}", x, turned=k == 2) for k, x in ((1, -4.0), (2, 0.0), (3, 4.0))),
    )
    (state,) = states(slit(*rows), lambda x: x)
    assert state.measure.seam == "top"
    assert state.measure.first_edge_mm == pytest.approx(12.0, abs=0.15)
    assert state.measure.scar_length_mm == pytest.approx(12.0, abs=0.15)
    assert state.gap.max() == pytest.approx(0.1, abs=1e-3)
    assert state.measure.edge_mismatch_mm == pytest.approx(0.0, abs=0.06)


def test_threads_of_many_bites_close_a_seam_with_all_their_passes() -> None:
    """A running suture over buried stitches and two mattress stitches between its ends: one seam, all that it is of."""
    places = (-4.0, -2.0, 0.0, 2.0, 4.0)
    stations = [Station((x, 0.0, 2.0), (0.0, 1.0, 0.0), gap=0.1) for x in places]
    threads = [
        running(stations, 2.0, 1.0).suture("running", 5.0),
        *(vertical_mattress(stations[k], 1.5, 3.0).suture(f"mattress_{k}", 5.0) for k in (1, 3)),
        *(deep_dermal(stations[k], 1.5, 1.0, 1.5).suture(f"dermal_{k}", 5.0) for k in (0, 2, 4)),
    ]
    procedure = slit(*threads)
    (state,) = states(procedure, lambda x: x)
    assert state.measure.seam == "running"
    assert set(state.closures) == {"running", "mattress", "dermal"}
    assert state.measure.scar_length_mm == pytest.approx(12.0, abs=0.15)
    assert state.measure.edge_mismatch_mm == pytest.approx(0.0, abs=0.06)


def test_two_seams_of_one_cut_share_its_length_half_way_between_them() -> None:
    found = measures(
        slit(stitch("left_1", -5.0), stitch("left_2", -2.0), stitch("right_1", 1.0), stitch("right_2", 4.0))
    )
    assert found["left"].scar_length_mm == pytest.approx(-0.5 + 6.0, abs=0.1)
    assert found["right"].scar_length_mm == pytest.approx(6.0 + 0.5, abs=0.1)


def test_a_seam_through_the_whole_tissue_ends_at_its_rim() -> None:
    cuts = [Incision(f"cut_{k}", 3.0, ((x, -10.0, 2.0), (x, 10.0, 2.0))) for k, x in enumerate((-1.5, 1.5))]
    sutures = [Suture(f"row_{k}", ((-2.0, y, z), (2.0, y, z)), 5.0) for k, (y, z) in enumerate(
        (y, z) for y in (-6.0, 0.0, 6.0) for z in (0.5, 1.5))]  # fmt: skip
    procedure = small_procedure(events=(*cuts, Excision("piece", 3.0, ((0.0, 0.0, 2.0),)), *sutures))
    (found,) = measures(procedure).values()
    assert found.scar_length_mm == pytest.approx(16.0, abs=1e-3)
    assert found.open_area_mm2 == pytest.approx(16.0 * 3.05, rel=0.01)
    (shut,) = measures(procedure, lambda points: points - np.sign(points) * (1.525, 0.0, 0.0)).values()
    assert shut.open_area_mm2 < 0.01
    assert shut.greatest_gap_mm == pytest.approx(0.0, abs=5e-3)


def test_sutures_away_from_any_cut_or_across_two_are_no_seam() -> None:
    assert measures(small_procedure(events=(stitch("near_1", 0.0),))) == {}
    apart = flat_patch((80.0, 60.0, 2.0), resolution=2.0, spacing=2.0)
    cuts = tuple(
        Incision(f"slit_{k}", 3.0, ((-6.0, y, 2.0), (6.0, y, 2.0)), kerf=0.1) for k, y in enumerate((-15.0, 15.0))
    )
    one = Suture("far", ((0.0, -14.0, 2.0), (0.0, 29.0, 2.0)), 5.0)
    two = (
        Suture("s_1", ((-2.0, 14.0, 2.0), (-2.0, 16.0, 2.0)), 5.0),
        Suture("s_2", ((2.0, -16.0, 2.0), (2.0, -14.0, 2.0)), 5.0),
    )
    assert measures(small_procedure(tissue=apart, events=(*cuts, one))) == {}
    assert measures(small_procedure(tissue=apart, events=(*cuts, *two))) == {}


def test_before_the_cut_there_is_no_seam_and_before_the_sutures_there_is() -> None:
    procedure = slit(stitch("top_1", -3.0), stitch("top_2", 3.0))
    program = compiled(procedure)
    frames = [
        SolvedFrame(each.time, program.epochs[each.epoch].surface.points.astype(np.float32)) for each in program.frames
    ]
    gauges = SeamGauges(program)
    found = [state for frame in frames for state in gauges.measure(frame, [])]
    assert [state.measure.time for state in found] == [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]


def row(suture: str, force: float, *, resolved: bool = True) -> SutureForce:
    return SutureForce(
        8.0, suture, suture.rpartition("_")[0], 0.0, force, 0.0, force, 0.0, 0.0, 0.0, 5000.0, resolved, force, force
    )


def test_the_tension_of_a_seam_is_what_all_its_closures_pull_over_its_length() -> None:
    sutures = [stitch(f"top_{k}", x) for k, x in enumerate((-4.0, 0.0, 4.0))]
    sutures += [stitch(f"deep_{k}", x, reach=0.05, z=0.7) for k, x in enumerate((-2.0, 2.0))]
    procedure = slit(*sutures)
    pulls = [row("top_0", 10.0), row("top_1", 40.0), row("top_2", 10.0), row("deep_0", 60.0), row("deep_1", 60.0)]
    found = measures(procedure, forces=pulls)["top"]
    assert found.force_mn == pytest.approx(180.0)
    assert found.tension_n_per_mm == pytest.approx(0.180 / found.scar_length_mm)
    # One of two that is not resolved takes half of its closure's length with it.
    unresolved = [*pulls[:4], row("deep_1", 700.0, resolved=False)]
    found = measures(procedure, forces=unresolved)["top"]
    assert found.force_mn == pytest.approx(120.0)
    assert found.tension_n_per_mm == pytest.approx((0.060 + 2 * 0.060) / found.scar_length_mm)
    none = [replace(each, resolved=False) for each in pulls]
    assert measures(procedure, forces=none)["top"].tension_n_per_mm is None


def cone(height: float, wide: float, x: float) -> Callable[[Points], Points]:
    """A cone on the skin at (x, 0)."""

    def moved(points: Points) -> Points:
        away = np.hypot(points[:, 0] - x, points[:, 1])
        points[:, 2] += height * np.maximum(1.0 - away / wide, 0.0)
        return points

    return moved


def test_a_bump_at_the_end_of_a_seam_is_a_dog_ear_of_its_height_on_flat_and_on_curved_skin() -> None:
    tip = 0.5 * LENGTH
    (found,) = measures(ellipse(), cone(2.5, 7.0, tip)).values()
    heights = sorted([found.start_dog_ear_mm or 0.0, found.end_dog_ear_mm or 0.0])
    assert heights == pytest.approx([0.0, 2.5], abs=0.06)

    def bent(points: Points) -> Points:
        x, y = points[:, 0], points[:, 1]
        points = cone(2.5, 7.0, tip)(points)
        points[:, 2] += 0.002 * x**2 - 0.003 * y**2 + 0.001 * x * y + 0.1 * x
        return points @ rotation((0.6, 0.0, 0.8), 0.7).T

    (found,) = measures(ellipse(), bent).values()
    heights = sorted([found.start_dog_ear_mm or 0.0, found.end_dog_ear_mm or 0.0])
    assert heights == pytest.approx([0.0, 2.5], abs=0.15)


def test_what_stands_out_at_rest_and_only_moves_along_is_no_dog_ear() -> None:
    procedure = ellipse()
    hill = cone(2.0, 9.0, 0.5 * LENGTH)
    raised = replace(procedure.tissue, points=hill(np.array(procedure.tissue.points)))
    assert raised.points[:, 2].max() > TOP + 1.0
    lifted = tuple(
        replace(event, anchors=tuple(hill(np.array([end]))[0] for end in event.anchors))
        if isinstance(event, Suture)
        else event
        for event in procedure.events
    )
    hilly = replace(procedure, tissue=raised, events=lifted)
    turn = rotation((0.0, 1.0, 0.0), 0.4)
    (found,) = measures(hilly, lambda points: points @ turn.T).values()
    assert found.start_dog_ear_mm == pytest.approx(0.0, abs=1e-3)
    assert found.end_dog_ear_mm == pytest.approx(0.0, abs=1e-3)
    (found,) = measures(hilly, lambda points: cone(1.0, 7.0, 0.5 * LENGTH)(points)).values()
    assert max(found.start_dog_ear_mm or 0.0, found.end_dog_ear_mm or 0.0) == pytest.approx(1.0, abs=0.05)


def test_near_the_rim_of_the_tissue_no_dog_ear_is_measured() -> None:
    short = flat_patch((48.0, 80.0, TOP), resolution=2.0, spacing=2.0)
    (found,) = measures(replace(ellipse(), tissue=short)).values()
    assert found.start_dog_ear_mm is None
    assert found.end_dog_ear_mm is None


def test_skin_that_a_flap_has_carried_away_from_the_end_of_a_seam_does_not_count() -> None:
    tip = 0.5 * LENGTH

    def carried(points: Points) -> Points:
        away = (points[:, 0] > tip + 3.0) & (points[:, 1] > 1.0)
        points = cone(2.5, 7.0, tip)(points)
        points[away] += (0.0, 0.0, 80.0)
        return points

    (found,) = measures(ellipse(), carried).values()
    heights = sorted([found.start_dog_ear_mm or 0.0, found.end_dog_ear_mm or 0.0])
    assert heights == pytest.approx([0.0, 2.5], abs=0.3)

    def all_carried(points: Points) -> Points:
        points[np.hypot(points[:, 0] - tip, points[:, 1]) > 3.0] += (0.0, 0.0, 80.0)
        return points

    (found,) = measures(ellipse(), all_carried).values()
    assert None in (found.start_dog_ear_mm, found.end_dog_ear_mm)
