"""The curves of materials against formulas, published summaries and a bar that the daemon draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.daemon.daemon_solver import connect_to, solver_identity
from lappet.procedure import DEFAULT_SKIN, MODELS, Material
from lappet.program.materials import parameters
from lappet.reports.box_scenes import BoxScene, stretched
from lappet.solve.solve_frames import SolveObserver, solve_program
from lappet.solve.store import FrameStore
from lappet.tissue.presets import CHOSEN, PRESETS, SKIN, SOURCES
from lappet.tissue.presets.preset import WORDS
from lappet.tissue.uniaxial import curve, curve_shape, nominal_stresses, prestretch_for, strip, tension_of


@pytest.mark.parametrize("model", MODELS)
def test_every_model_begins_with_its_modulus_and_contracts_by_its_poissons_ratio(model: str) -> None:
    material = Material("m", model, youngs_modulus=70.0, poissons_ratio=0.4, mooney_ratio=0.5)
    stress, s = strip(material, 1.0 + 1e-6)
    assert stress == pytest.approx(70.0 * 1e-6, rel=1e-4)
    assert 1.0 - s[1:] == pytest.approx(0.4e-6, rel=1e-3)


def test_an_incompressible_strip_follows_the_neo_hookean_formula() -> None:
    material = Material("m", youngs_modulus=30.0, poissons_ratio=0.4999)
    stretches = np.array([0.8, 1.1, 1.5, 2.0])
    formula = 10.0 * (stretches - stretches**-2)
    assert curve(material, stretches) == pytest.approx(formula, rel=1e-3)


SKINS = [
    preset.material for preset in PRESETS.values() if preset.material.poissons_ratio == DEFAULT_SKIN.poissons_ratio
]


def test_every_skin_has_the_default_poissons_ratio() -> None:
    assert {name for name in PRESETS if "skin" in name} <= {skin.name for skin in SKINS}
    assert len(SKINS) >= 13


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_the_sides_of_a_strip_are_free_and_its_volume_is_kept(skin: Material) -> None:
    for axis in (0, 1):
        for stretch in np.arange(1.05, 1.601, 0.05):
            stress, s = strip(skin, float(stretch), axis)
            found = nominal_stresses(skin, s)
            assert found[axis] == stress
            assert np.abs(np.delete(found, axis)).max() < 1e-8 * skin.youngs_modulus
            assert abs(s.prod() - 1.0) < 0.01


def test_the_default_skin_is_j_shaped_and_plain_neo_hookean_skin_is_not() -> None:
    """Its fibers straighten at about 1.15; the modulus that suction on forearms measured is met at their tension."""
    skin, plain = curve_shape(DEFAULT_SKIN, 1.4), curve_shape(Material(), 1.4)
    assert plain.terminal_slope < plain.initial_slope
    assert skin.terminal_slope > 6.0 * skin.initial_slope
    assert 1.15 < skin.knee < 1.3
    slopes = np.diff(curve(DEFAULT_SKIN, np.linspace(1.1, 1.6, 26)))
    assert (np.diff(slopes[2:]) > 0.0).all()
    tension, step = 13.5, 0.05  # kPa
    before = np.log(prestretch_for(DEFAULT_SKIN, tension, tension))
    along = np.log(prestretch_for(DEFAULT_SKIN, tension + step, tension))[0] - before[0]
    across = np.log(prestretch_for(DEFAULT_SKIN, tension, tension + step))[1] - before[1]
    assert 0.5 * (step / along + step / across) == pytest.approx(116.0, rel=0.05)
    assert along < across / 2.0


@pytest.mark.parametrize("tension", [(5.0, 5.0), (20.0, 10.0), (53.0, 26.5), (90.0, 30.0)])
def test_the_prestretch_for_a_tension_gives_it(tension: tuple[float, float]) -> None:
    stretch = prestretch_for(DEFAULT_SKIN, *tension)
    assert tension_of(replace(DEFAULT_SKIN, prestretch=stretch)) == pytest.approx(tension, rel=1e-6)
    assert stretch[0] > 1.0


@pytest.mark.parametrize("name", [name for name, preset in PRESETS.items() if preset.published])
def test_a_fitted_preset_has_the_slopes_and_the_knee_of_its_published_curve(name: str) -> None:
    preset = PRESETS[name]
    published = preset.published
    assert published is not None
    shape = curve_shape(preset.material, published.last)
    assert shape.terminal_slope == pytest.approx(published.terminal_slope, rel=0.01)
    assert shape.knee == pytest.approx(published.knee, abs=0.002)
    if published.initial_slope is not None:
        assert shape.initial_slope == pytest.approx(published.initial_slope, rel=0.01)


@pytest.mark.parametrize("name", PRESETS)
def test_every_number_of_a_preset_has_its_source_and_is_the_one_that_is_told(name: str) -> None:
    preset = PRESETS[name]
    told = {value.parameter: value for value in preset.values}
    plain = Material()
    for value in preset.values:
        assert value.parameter in WORDS
        assert value.source == CHOSEN or value.source in SOURCES
        assert value.how
        if value.parameter != "tension":
            assert float(value.value.split()[0]) == pytest.approx(getattr(preset.material, value.parameter), rel=2e-3)
    for parameter in set(WORDS) - {"tension"}:
        if getattr(preset.material, parameter) != getattr(plain, parameter):
            assert parameter in told
    assert {"youngs_modulus", "poissons_ratio", "density"} <= set(told)
    assert ("tension" in told) == (preset.tension != (0.0, 0.0)) == preset.material.has_prestretch
    if preset.tension != (0.0, 0.0):
        assert tension_of(preset.material) == pytest.approx(preset.tension, rel=0.01)
        assert 5.0 <= preset.tension[0] <= 90.0


def test_the_default_skin_is_the_preset() -> None:
    assert SKIN.material == DEFAULT_SKIN
    assert {"skin", "scalp", "face", "cheek", "eyelid", "forehead", "trunk", "limb", "young_skin"} <= set(PRESETS)
    assert {"old_skin", "edematous_skin", "scar", "fat", "galea", "muscle", "cartilage"} <= set(PRESETS)


def test_two_families_mirror_each_other_and_at_a_right_angle_are_one_across() -> None:
    """What both pull aslant cancels: the curves along and across swap at 90° and agree at 45°."""
    stretches = np.array([1.05, 1.2, 1.4])
    one, crossed = DEFAULT_SKIN, replace(DEFAULT_SKIN, fiber_angle=90.0)
    assert curve(crossed, stretches, 0) == pytest.approx(curve(one, stretches, 1), rel=1e-9)
    assert curve(crossed, stretches, 1) == pytest.approx(curve(one, stretches, 0), rel=1e-9)
    even = replace(DEFAULT_SKIN, fiber_angle=45.0)
    assert curve(even, stretches, 0) == pytest.approx(curve(even, stretches, 1), rel=1e-9)
    assert curve(one, stretches, 0)[-1] > 1.5 * curve(even, stretches, 0)[-1] > 1.5 * curve(one, stretches, 1)[-1]
    slanted = replace(DEFAULT_SKIN, fiber_angle=35.0)
    stretch = prestretch_for(slanted, 20.0, 10.0)
    assert tension_of(replace(slanted, prestretch=stretch)) == pytest.approx((20.0, 10.0), rel=1e-6)


@pytest.mark.parametrize(
    ("direction", "axis", "angle"),
    [((1.0, 0.0, 0.0), 0, 0.0), ((0.0, 1.0, 0.0), 1, 0.0), ((1.0, 0.0, 0.0), 0, 35.0), ((0.0, 1.0, 0.0), 1, 35.0)],
)
def test_a_bar_that_the_daemon_draws_follows_the_curve(
    tmp_path_factory: pytest.TempPathFactory, direction: tuple[float, float, float], axis: int, angle: float
) -> None:
    """Stress and stretch in the middle of a bar of 48 x 4 x 4 mm drawn by 40 %, away from its clamped ends."""
    material = replace(DEFAULT_SKIN, fiber_direction=direction, fiber_angle=angle)
    bar = BoxScene("bar", "", (48.0, 4.0, 4.0), (24, 2, 2), (0,), gripped=(1,), material=parameters(material))
    program = replace(bar, motion=stretched(0.4 * 48.0)).program(2.0, precision="double", tolerance=1e-8)
    store = FrameStore(tmp_path_factory.mktemp("store"))
    frames = solve_program(program, store, connect_to(None), solver_identity(None), SolveObserver())
    assert frames.reason is None
    solved = frames.frames[0].solved
    rest = program.epochs[0].surface.points
    left, right = (np.flatnonzero(np.abs(rest[:, 0] - x) < 1e-6) for x in (22.0, 26.0))
    middle = np.abs(rest[:, 0] - 24.0) < 1e-6
    stretch = (solved.points[right, 0].mean() - solved.points[left, 0].mean()) / 4.0
    assert stretch > 1.35
    nominal, s = strip(material, stretch, axis)
    assert solved.tension[middle].mean() == pytest.approx(nominal * stretch / s.prod(), rel=0.01)
