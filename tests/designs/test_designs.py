"""Designs against the geometry of shared/PROCEDURES: Z-plasty gain and turn, fusiform tip angle and arc."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.core.problem_code import ProblemCode
from lappet.designs import fusiform, oval, z_plasty
from lappet.tissue.placement import onto
from refusals import refuses
from surface_measures import spherical_cap


@pytest.mark.parametrize(
    ("angle", "gain", "turn"),
    [(30.0, 23.9, 53.8), (45.0, 47.4, 73.7), (60.0, 73.2, 90.0), (75.0, 99.1, 104.0), (90.0, 123.6, 116.6)],
)
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_z_plasty_gains_and_turns_as_published(angle, gain, turn, mirrored):
    z = z_plasty((3.0, -2.0, 4.0), (1.0, 2.0, 0.0), 20.0, angle, mirrored=mirrored)
    a, b, c, d = np.array(z.curve)
    for limb in (b - a, c - b, d - c):
        assert np.linalg.norm(limb) == pytest.approx(20.0)
    for tip, one, two in ((b, a, c), (c, b, d)):
        u, v = one - tip, two - tip
        assert np.degrees(np.arccos(u @ v / 400.0)) == pytest.approx(angle)
    assert np.linalg.norm(d - a) / 20.0 == pytest.approx(1.0 + gain / 100.0, abs=6e-4)
    central, after = b - c, a - d
    cosine = central @ after / np.linalg.norm(central) / np.linalg.norm(after)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(180.0 - turn, abs=0.06) or np.degrees(
        np.arccos(cosine)
    ) == pytest.approx(turn, abs=0.06)
    assert np.allclose((a + d) / 2.0, [3.0, -2.0, 4.0])
    assert z.tips == (z.curve[1], z.curve[2])
    assert z.bases == (z.curve[0], z.curve[3])


def test_flap_tips_reach_the_other_base_by_a_rigid_turn_about_their_own():
    z = z_plasty((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 20.0, 60.0)
    a, b, c, d = np.array(z.curve)
    # The flap abc keeps its base ac; its tip b goes to d, which is as far from c as b is.
    assert np.linalg.norm(b - c) == pytest.approx(np.linalg.norm(d - c))
    assert np.linalg.norm(c - b) == pytest.approx(np.linalg.norm(a - b))


@pytest.mark.parametrize(("ratio", "tip", "arc"), [(2, 106.3, 1.159), (3, 73.7, 1.073), (4, 56.1, 1.041)])
def test_a_fusiform_has_the_published_tip_angle_and_arc(ratio, tip, arc):
    length = 30.0
    design = fusiform((1.0, 2.0, 4.0), length, length / ratio, (1.0, 1.0, 0.0), samples=400)
    curve = np.array(design.curve)
    assert np.linalg.norm(np.subtract(*design.tips)) == pytest.approx(length)
    u, v = curve[1] - curve[0], curve[-1] - curve[0]
    assert np.degrees(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v))) == pytest.approx(tip, abs=0.4)
    around = np.linalg.norm(np.roll(curve, -1, axis=0) - curve, axis=1).sum()
    assert around / (2.0 * length) == pytest.approx(arc, abs=1e-3)
    pairs = np.array(design.pairs)
    widest = np.linalg.norm(pairs[:, 0] - pairs[:, 1], axis=1)
    assert widest.max() == pytest.approx(length / ratio)
    assert np.allclose(
        (pairs[:, 0] + pairs[:, 1]) @ [1.0, 1.0, 0.0] / 2.0 - 3.0, np.linspace(-1, 1, 9)[1:-1] * 15 * 2**0.5
    )
    x, y = curve[:, 0], curve[:, 1]
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0.0
    assert design.seed == (1.0, 2.0, 4.0)


def test_an_oval_has_its_axes_and_lies_around_the_fusiform_that_it_is_for():
    axes = np.array([[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]) / np.sqrt(2.0)
    around = np.array(oval((1.0, 2.0, 4.0), 30.0 + 2 * 8.0, 10.0 + 2 * 8.0, (1.0, 1.0, 0.0))) - (1.0, 2.0, 4.0)
    along, across = axes @ around.T
    assert (along / 23.0) ** 2 + (across / 13.0) ** 2 == pytest.approx(1.0)
    assert around[:, 2] == pytest.approx(0.0)
    assert (np.cross(around, np.roll(around, -1, axis=0))[:, 2] > 0.0).all()  # counter-clockwise
    tips = np.array(fusiform((1.0, 2.0, 4.0), 30.0, 10.0, (1.0, 1.0, 0.0)).tips) - (1.0, 2.0, 4.0)
    assert np.linalg.norm(around[[24, 0]] - tips, axis=1) == pytest.approx(8.0)


def test_designs_lie_on_a_curved_skin():
    tissue = spherical_cap(rings=32)
    counts = tissue.face_vertex_counts
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    skin = np.setdiff1d(np.arange(len(counts)), np.concatenate(list(tissue.subsets.values())))
    faces = [tissue.face_vertex_indices[starts[f] : starts[f] + counts[f]] for f in skin]
    triangles = np.array([t for f in faces for t in ([f[:3]] if len(f) == 3 else [f[[0, 1, 2]], f[[0, 2, 3]]])])
    place = onto(tissue.points, triangles)
    z = z_plasty((0.0, 0.0, 60.0), (1.0, 0.0, 0.0), 20.0, project=place)
    ellipse = fusiform((0.0, 0.0, 60.0), 30.0, 10.0, (1.0, 0.0, 0.0), project=place)
    around = oval((0.0, 0.0, 60.0), 46.0, 26.0, (1.0, 0.0, 0.0), project=place)
    for points in (z.curve, ellipse.curve, around):
        assert np.linalg.norm(np.array(points), axis=1) == pytest.approx(60.0, abs=0.15)


@pytest.mark.parametrize(
    ("draw", "code"),
    [
        (lambda: z_plasty((0, 0, 0), (1, 0, 0), 0.0), ProblemCode.LENGTH_NOT_POSITIVE),
        (lambda: z_plasty((0, 0, 0), (1, 0, 0), 10.0, 150.0), ProblemCode.DESIGN_ANGLE),
        (lambda: z_plasty((0, 0, 0), (0, 0, 1), 10.0), ProblemCode.DESIGN_DIRECTION),
        (lambda: fusiform((0, 0, 0), 10.0, 20.0, (1, 0, 0)), ProblemCode.DESIGN_OVAL),
        (lambda: fusiform((0, 0, 0), float("nan"), 20.0, (1, 0, 0)), ProblemCode.DESIGN_OVAL),
        (lambda: fusiform((0, 0, 0), 30.0, 10.0, (1, 0, 0), samples=1), ProblemCode.DESIGN_SAMPLES),
        (lambda: oval((0, 0, 0), 30.0, 0.0, (1, 0, 0)), ProblemCode.LENGTH_NOT_POSITIVE),
        (lambda: oval((0, 0, 0), float("nan"), 10.0, (1, 0, 0)), ProblemCode.LENGTH_NOT_POSITIVE),
        (lambda: oval((0, 0, 0), 30.0, 10.0, (0, 0, 1)), ProblemCode.DESIGN_DIRECTION),
    ],
)
def test_designs_that_cannot_be_drawn_are_refused(draw, code):
    with refuses(code):
        draw()
