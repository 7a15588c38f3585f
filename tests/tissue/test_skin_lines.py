"""The field of the skin's lines: against lines whose field is known, and all the way into the program."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.checks.validation import check
from lappet.core.problem_code import ProblemCode
from lappet.procedure import DEFAULT_SKIN, Procedure, SkinLine
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.tissue.dome import dome_scalp
from lappet.tissue.face_lines import FaceLandmarks, face_lines
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_lines import STEP, _samples, skin_field
from lappet.tissue.skin_sheet import SkinSheet
from lappet.tissue.uniaxial import prestretch_for
from lappet.usd.stage import read_procedure, write_procedure

UP = (0.0, 0.0, 1.0)


def grid(half: float = 20.0, count: int = 9) -> NDArray[np.float64]:
    x, y = np.meshgrid(np.linspace(-half, half, count), np.linspace(-half, half, count))
    return np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)


def between(directions: NDArray[np.float64], wanted: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles in degrees between directions without a sense."""
    cosine = np.abs((directions * wanted).sum(axis=1))
    return np.degrees(np.arccos(np.minimum(cosine, 1.0)))


def test_parallel_lines_drawn_either_way_give_their_direction_everywhere() -> None:
    along = np.array([np.cos(0.4), np.sin(0.4), 0.0])
    aside = np.array([-along[1], along[0], 0.0])
    lines = [
        SkinLine(f"line_{k}", tuple(tuple(k * 8.0 * aside + way * s * along) for s in (-30.0, 30.0)))
        for k, way in ((-1, 1.0), (0, -1.0), (1, 1.0))
    ]
    points = grid()
    field = skin_field(lines, points, np.tile(UP, (len(points), 1)), DEFAULT_SKIN)
    assert between(field.directions, along).max() < 1e-4
    assert field.stretch == pytest.approx(np.ones((len(points), 2)))


def test_circles_about_a_pole_give_a_field_that_turns_about_it_and_lies_in_the_skin() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 49)
    radius = 40.0
    lines = []
    for k, polar in enumerate((0.25, 0.5, 0.75)):
        at = radius * np.stack([np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle),
                                np.full_like(angle, np.cos(polar))], axis=1)  # fmt: skip
        lines.append(SkinLine(f"ring_{k}", tuple(map(tuple, at))))
    polar, turn = (v.ravel() for v in np.meshgrid(np.linspace(0.2, 0.8, 7), np.linspace(0.0, 6.0, 13)))
    normals = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=1)
    field = skin_field(lines, radius * normals, normals, DEFAULT_SKIN)
    around = np.stack([-np.sin(turn), np.cos(turn), np.zeros_like(turn)], axis=1)
    assert between(field.directions, around).max() < 2.0
    assert np.abs((field.directions * normals).sum(axis=1)).max() < 1e-12
    assert np.linalg.norm(field.directions, axis=1) == pytest.approx(1.0)


def test_between_two_lines_the_direction_turns_and_the_prestretch_changes_smoothly() -> None:
    lines = [
        SkinLine("left", ((-20.0, -30.0, 0.0), (-20.0, 30.0, 0.0)), (40.0, 20.0)),
        SkinLine("right", ((20.0, -30.0, 0.0), (30.0, 30.0, 0.0)), (10.0, 5.0)),
    ]
    points = np.stack([np.linspace(-20.0, 20.0, 81), np.zeros(81), np.zeros(81)], axis=1)
    field = skin_field(lines, points, np.tile(UP, (81, 1)), DEFAULT_SKIN)
    taut, slack = (np.array(prestretch_for(DEFAULT_SKIN, *line.tension)) for line in lines if line.tension)
    assert field.stretch[0] == pytest.approx(taut, rel=0.01)
    assert field.stretch[-1] == pytest.approx(slack, rel=0.01)
    assert (np.diff(field.stretch[:, 0]) <= 0.0).all()
    turned = between(field.directions, np.array([0.0, 1.0, 0.0]))
    assert turned[0] < 0.5
    assert turned[-1] == pytest.approx(np.degrees(np.arctan2(10.0, 60.0)), abs=0.5)
    assert (np.diff(turned) > -1e-9).all()
    assert np.abs(np.diff(turned)).max() < 1.0


def lined(*lines: SkinLine) -> Procedure:
    tissue = flat_patch((24.0, 16.0, 2.0), resolution=4.0, spacing=2.0)
    return Procedure(tissue, (DEFAULT_SKIN,), skin_lines=lines)


def test_the_field_at_a_point_does_not_depend_on_how_many_others_are_asked_for() -> None:
    """Of thousands, laid in blocks, each has what the formula says of it alone."""
    arc = np.linspace(0.0, 2.0, 30)
    curves = (
        np.stack([20.0 * np.cos(arc), 20.0 * np.sin(arc), arc], 1),
        np.array([[-20.0, 5.0, 0.0], [20.0, -9.0, 3.0]]),
    )
    lines = [SkinLine(f"line_{k}", tuple(map(tuple, curve))) for k, curve in enumerate(curves)]
    points = np.random.default_rng(5).uniform(-25.0, 25.0, (4500, 3))
    normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    field = skin_field(lines, points, normals, DEFAULT_SKIN)
    for rows in (slice(0, 40), slice(500, 520), slice(2040, 2060), slice(4090, 4100), slice(4460, 4500)):
        few = skin_field(lines, points[rows], normals[rows], DEFAULT_SKIN)
        assert np.abs((field.directions[rows] * few.directions).sum(axis=1)) == pytest.approx(1.0, abs=1e-9)
    places, tangents, _ = _samples(lines, DEFAULT_SKIN)
    weights = (((points[:, None] - places) ** 2).sum(axis=2) + STEP**2) ** -2.0
    tensors = np.einsum("rk,ki,kj->rij", weights, tangents, tangents)
    plane = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    values, vectors = np.linalg.eigh(plane @ tensors @ plane)
    clear = values[:, 2] - values[:, 1] > 0.1 * values[:, 1:].sum(axis=1)
    assert clear.sum() > 3000
    assert between(field.directions[clear], vectors[clear, :, 2]).max() < 1e-4


def test_the_daemon_is_told_the_field_and_every_key_holds_it(tmp_path: Path) -> None:
    turned = SkinLine("across", ((0.0, -8.0, 2.0), (0.0, 8.0, 2.0)))
    taut = replace(turned, tension=(30.0, 15.0))
    programs = [compile_program(lined(*lines)) for lines in ((), (turned,), (taut,))]
    regions = [program.epochs[0].regions for program in programs]
    assert [len(each.skin_directions) for each in regions] == [0, *2 * [len(regions[0].skin_points)]]
    assert [len(each.skin_stretch) for each in regions] == [0, 0, len(regions[0].skin_points)]
    assert between(regions[1].skin_directions, np.array([0.0, 1.0, 0.0])).max() < 1e-6
    stretch = prestretch_for(DEFAULT_SKIN, 30.0, 15.0)
    assert regions[2].skin_stretch == pytest.approx(np.tile(stretch, (len(regions[2].skin_points), 1)))
    assert [program.settings.materials[0].prestretch for program in programs] == [
        (1, 1),
        (1, 1),
        pytest.approx(stretch),
    ]
    assert len({frame_keys(program, "solver")[0] for program in programs}) == 3


def test_lines_come_back_from_a_file_and_what_is_wrong_with_them_is_said(tmp_path: Path) -> None:
    wave = ((-8.0, 0.0, 2.0), (-4.0, 1.0, 2.0), (0.0, 0.0, 2.0), (4.0, -1.0, 2.0))
    sound = lined(SkinLine("wave", wave, (20.0, 8.0), "catmullRom"), SkinLine("line", wave[:2]))
    write_procedure(sound, tmp_path / "p.usda")
    assert read_procedure(tmp_path / "p.usda") == sound
    assert [each for each in check(sound) if each.severity == "error"] == []
    wrong = lined(SkinLine("taut", wave, (1e9, 0.0)), SkinLine("point", wave[:1]), SkinLine("nan", wave, (np.nan, 1.0)))
    found = [(each.code, each.prim) for each in check(wrong) if each.severity == "error"]
    assert found == [
        (ProblemCode.SKIN_LINE_TENSION, "/Procedure/SkinLines/taut"),
        (ProblemCode.CURVE_TOO_SHORT, "/Procedure/SkinLines/point"),
        (ProblemCode.SKIN_LINE_TENSION, "/Procedure/SkinLines/nan"),
    ]


def test_on_a_dome_the_field_lies_in_the_skin() -> None:
    tissue = dome_scalp(40.0, 24.0, 4.0, resolution=4.0, spacing=2.0)
    line = SkinLine("crown", ((-20.0, 0.0, 34.6), (0.0, 0.0, 40.0), (20.0, 0.0, 34.6)))
    regions = compile_program(Procedure(tissue, (DEFAULT_SKIN,), skin_lines=(line,))).epochs[0].regions
    outwards = regions.skin_points / np.linalg.norm(regions.skin_points, axis=1, keepdims=True)
    assert np.abs((regions.skin_directions * outwards).sum(axis=1)).max() < 0.1  # the rim's normals lean
    assert between(regions.skin_directions, np.array([1.0, 0.0, 0.0])).max() < 40.0


def test_the_lines_of_a_face_run_as_the_atlas_has_them() -> None:
    """On a flat face: across the forehead and chin, upright in the lip, downwards and outwards over the cheek."""
    tissue = flat_patch((160.0, 200.0, 4.0), resolution=8.0, spacing=4.0)
    skin = SkinSheet.of(tissue)
    face = FaceLandmarks((0, 80, 4), (0, 25, 4), (0, -25, 4), (0, -75, 4), ((-45, 20, 4), (45, 20, 4)),
                         ((-25, -45, 4), (25, -45, 4)))  # fmt: skip
    lines = face_lines(face, skin)
    points = np.array([(0.0, 55.0, 4.0), (0.0, -60.0, 4.0), (0.0, -35.0, 4.0), (45.0, -45.0, 4.0), (-45.0, -45.0, 4.0),
                       (58.0, 20.0, 4.0)])  # fmt: skip
    field = skin_field(lines, points, np.tile(UP, (len(points), 1)), DEFAULT_SKIN)
    slant = np.array([1.0, -1.5, 0.0]) / np.hypot(1.0, 1.5)
    mirrored = slant * (-1.0, 1.0, 1.0)
    side, upright = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    wanted = np.array([side, side, upright, slant, mirrored, side])
    assert between(field.directions, wanted).max() < 30.0
    assert field.stretch[3, 0] > field.stretch[2, 0] > 1.0
    assert {line.tension for line in lines} == {None, (7.0, 3.5), (53.0, 26.5)}
    assert check(replace(lined(), skin_lines=lines)) == check(lined())
