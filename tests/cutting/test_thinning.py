"""Thinning: how much tissue goes, how much is left, and that nothing else changes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.geometry.closest_point import ClosestPoint
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Event, Excision, Incision, Procedure, Thin, Tissue, Undermine
from lappet.tissue.patch import flat_patch
from refusals import refuses
from surface_measures import areas, assert_closed, spherical_cap, volume

TOP, RADIUS = 4.0, 7.0
SIZE = (40.0, 30.0, TOP)
Ring = tuple[tuple[float, float, float], ...]


def ring(radius: float = RADIUS, count: int = 80) -> Ring:
    turn = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return tuple((radius * float(np.cos(t)), radius * float(np.sin(t)), TOP) for t in turn)


def area(outline: Ring) -> float:
    x, y = np.array(outline)[:, 0], np.array(outline)[:, 1]
    return 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))


def epochs(*events: Event, tissue: Tissue | None = None) -> list[Epoch]:
    found = build_epochs(Procedure(tissue or flat_patch(SIZE, spacing=1.0), events=events, end_time=100.0))
    for epoch in found:
        assert_closed(epoch.surface)
    return found


def underside(surface: Surface) -> np.ndarray:
    """Corners of the faces that rest on the ground, (k, 3, 3)."""
    return surface.points[surface.triangles[surface.resting]]


@pytest.mark.parametrize("left", [0.8, 2.0, 3.5])
@pytest.mark.parametrize("spacing", [0.7, 2.0])
def test_what_is_removed_is_the_area_times_the_depth(left: float, spacing: float) -> None:
    before, after = epochs(Thin("thin", 3.0, ring(), left), tissue=flat_patch(SIZE, spacing=spacing))
    (gone,) = after.thinned
    expected = area(ring()) * (TOP - left)
    assert gone.volume == pytest.approx(expected, rel=0.005)
    assert volume(before.surface) - volume(after.surface) == pytest.approx(gone.volume, rel=1e-4)
    assert gone.area == pytest.approx(area(ring()), rel=0.06 * spacing)  # in faces of the skin, which are not divided
    assert before.thinned == ()


def test_the_stated_thickness_is_left_and_nothing_outside_of_the_area_is_touched() -> None:
    before, after = epochs(Undermine("free", 2.0, ring(12.0)), Thin("thin", 3.0, ring(), 1.5))[-2:]
    new = underside(after.surface)
    roof = new[np.ptp(new[:, :, 2], axis=1) < 1e-6]
    thinned = np.abs(roof[:, :, 2] - (TOP - 1.5)).max(axis=1) < 1e-9
    assert (np.linalg.norm(roof[thinned][:, :, :2], axis=2) < RADIUS + 1e-6).all()
    assert (roof[~thinned][:, :, 2] == 0.0).all()  # undermined, but not thinned
    assert (np.linalg.norm(roof[~thinned].mean(axis=1)[:, :2], axis=1) > RADIUS - 1e-6).all()
    skin = [areas(each.surface)[each.surface.origin == FaceOrigin.SKIN].sum() for each in (before, after)]
    assert skin[0] == pytest.approx(skin[1], rel=1e-12)
    old, now = ({tuple(point) for point in each.surface.points.tolist()} for each in (before, after))
    far = {point for point in old if np.hypot(point[0], point[1]) > RADIUS + 2.0}
    assert far <= now


def test_thinning_a_curved_cap_converges_to_the_shell_below_it() -> None:
    polar, left = np.radians(20.0), 2.5
    curve = tuple(
        (60.0 * float(np.sin(polar) * np.cos(t)), 60.0 * float(np.sin(polar) * np.sin(t)), 60.0 * float(np.cos(polar)))
        for t in np.linspace(0.0, 2.0 * np.pi, 90, endpoint=False)
    )
    shell = 2.0 * np.pi / 3.0 * (1.0 - np.cos(polar)) * ((60.0 - left) ** 3 - 56.0**3)
    errors, thickness = [], []
    for rings in (6, 12, 24):
        after = epochs(Thin("thin", 3.0, curve, left), tissue=spherical_cap(rings=rings))[-1]
        errors.append(abs(after.thinned[0].volume / shell - 1.0))
        skin = after.surface.triangles[after.surface.origin == FaceOrigin.SKIN]
        roof = underside(after.surface).mean(axis=1)
        roof = roof[np.degrees(np.arccos(roof[:, 2] / np.linalg.norm(roof, axis=1))) < 19.0]
        thickness.append(np.abs(ClosestPoint(after.surface.points, skin).query(roof)[2] - left).max())
    assert errors[2] < errors[1] < errors[0]
    assert errors[2] < 0.01
    assert thickness[2] < 0.01


def test_a_flap_that_is_cut_out_is_thinned_up_to_its_walls() -> None:
    cut = Incision("cut", 2.0, ring(), closed=True)
    after = epochs(cut, Thin("thin", 3.0, ring(), 2.2))[-1]
    assert after.fragments == 2
    points = after.surface.points
    inside = np.linalg.norm(points[:, :2], axis=1) < RADIUS
    assert points[inside][:, 2].min() == pytest.approx(TOP - 2.2, abs=1e-9)
    assert points[~inside][:, 2].min() == 0.0


def test_what_is_thin_already_stays_and_a_second_thinning_goes_on_from_the_first() -> None:
    found = epochs(Thin("first", 3.0, ring(), 3.0), Thin("second", 4.0, ring(5.0), 2.0))
    assert found[-1].thinned[0].volume == pytest.approx(area(ring(5.0)) * 1.0, rel=0.01)


def test_the_dressing_presses_on_the_skin_of_the_area_also_after_later_cuts() -> None:
    found = epochs(
        Thin("thin", 3.0, ring(), 2.0),
        Thin("bare", 3.0, tuple((x + 14.0, y, z) for x, y, z in ring(3.0)), 2.0, dressing=0.0),
        Incision("late", 6.0, ((-12.0, 0.3, TOP), (12.0, 0.3, TOP))),
    )
    for epoch in found[1:]:
        assert [name for name in epoch.surface.grips if name.startswith("thin:")] == ["thin:thin"]
        pressed = epoch.surface.grips["thin:thin"]
        assert (epoch.surface.origin[pressed] == FaceOrigin.SKIN).all()
        assert areas(epoch.surface)[pressed].sum() == pytest.approx(area(ring()), rel=0.06)


def test_the_same_thinning_gives_the_same_bytes() -> None:
    events = (Incision("cut", 2.0, ring(), closed=True), Thin("thin", 3.0, ring(), 2.2))
    one, two = (epochs(*events)[-1].surface for _ in range(2))
    for name in ("points", "triangles", "uv", "origin", "fixed", "bed"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes(), name


@pytest.mark.parametrize(
    ("events", "code"),
    [
        ([Thin("out", 5.0, tuple((x + 90.0, y, z) for x, y, z in ring()), 2.0)], ProblemCode.CUT_MISSES_TISSUE),
        ([Thin("out", 5.0, ring(), TOP)], ProblemCode.THIN_NOTHING),
        ([Thin("out", 5.0, ring(), 9.0)], ProblemCode.THIN_NOTHING),
        ([Thin("first", 4.0, ring(9.0), 2.0), Thin("out", 5.0, ring(), 2.0)], ProblemCode.THIN_NOTHING),
        ([Thin("out", 5.0, ring(), 0.0)], ProblemCode.THIN_THICKNESS),
        ([Thin("out", 5.0, ring()[:2], 2.0)], ProblemCode.CURVE_TOO_SHORT),
        (
            [
                Incision("cut", 2.0, ring(9.0), closed=True),
                Excision("gone", 3.0, ((0.0, 0.0, TOP),)),
                Thin("out", 5.0, ring(), 2.0),
            ],
            ProblemCode.THIN_NOTHING,
        ),
    ],
)
def test_a_thinning_that_cannot_act_is_refused_by_name(events: list[Event], code: ProblemCode) -> None:
    with refuses(code, "/Procedure/Timeline/out"):
        epochs(*events)


def test_one_epoch_may_cut_thin_and_undermine() -> None:
    together = epochs(
        Undermine("free", 3.0, ring(10.0)), Thin("thin", 3.0, ring(), 2.0), Incision("cut", 3.0, ring(), closed=True)
    )
    assert len(together) == 2
    apart = epochs(
        Incision("cut", 2.0, ring(), closed=True),
        replace(Thin("thin", 3.0, ring(), 2.0), dressing=0.0),
        Undermine("free", 4.0, ring(10.0)),
    )
    bed = [areas(found[-1].surface)[found[-1].surface.bed].sum() for found in (together, apart)]
    assert bed[0] == pytest.approx(bed[1], rel=1e-3)
