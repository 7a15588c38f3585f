"""What lies below skin or in it: fat, galea, muscle, cartilage and the eyelid's tarsal plate."""

from __future__ import annotations

from lappet.procedure import Material
from lappet.tissue.presets.preset import CHOSEN, Preset, PublishedCurve, Sourced

_FAT_SHEAR = 0.53  # kPa
_VOLUME = Sourced("poissons_ratio", "0.49", CHOSEN, "nearly incompressible")

FAT = Preset(
    Material("fat", youngs_modulus=2.0 * _FAT_SHEAR * 1.49, poissons_ratio=0.49, density=920.0),
    "Subcutaneous fat.",
    (
        Sourced("youngs_modulus", "1.58 kPa", "Sims 2010", "2 μ (1 + ν) with the neo-Hookean μ that was fitted"),
        _VOLUME,
        Sourced("density", "920 kg/m³", CHOSEN, "lighter than water"),
    ),
)
GALEA = Preset(
    Material(
        "galea",
        youngs_modulus=1000.0,
        poissons_ratio=0.49,
        fiber_k1=7987.0,
        fiber_dispersion=0.1,
        fiber_slack=1.0044,
        density=1100.0,
    ),
    "The galea, of which no measurement was found: the fascia of the temporal muscle, which borders on it.",
    (
        Sourced("youngs_modulus", "1000 kPa", CHOSEN, "soft beside the fibers"),
        _VOLUME,
        Sourced("fiber_k1", "7987 kPa", "Zwirner 2020a", "fitted with the slack to the end of the curve"),
        Sourced("fiber_slack", "1.0044", "Zwirner 2020a", "fitted with k₁ to the end of the curve"),
        Sourced("fiber_dispersion", "0.1", CHOSEN, "nearly parallel bundles"),
        Sourced("density", "1100 kg/m³", CHOSEN, "as of skin"),
    ),
    published=PublishedCurve("Zwirner 2020a", "temporal muscle fascia", 26200.0, 1.141, 2900.0),
)
MUSCLE = Preset(
    Material(
        "muscle",
        youngs_modulus=30.0,
        poissons_ratio=0.49,
        fiber_k1=275.1,
        fiber_dispersion=0.05,
        fiber_slack=1.0465,
        density=1060.0,
        muscle_stress=300.0,
    ),
    "Muscle, passive as the temporal muscle of the dead.",
    (
        Sourced("youngs_modulus", "30 kPa", CHOSEN, "soft beside the fibers"),
        _VOLUME,
        Sourced("fiber_k1", "275.1 kPa", "Zwirner 2020b", "fitted with the slack to the end of the curve"),
        Sourced("fiber_slack", "1.0465", "Zwirner 2020b", "fitted with k₁ to the end of the curve"),
        Sourced("fiber_dispersion", "0.05", CHOSEN, "nearly parallel fibers"),
        Sourced("muscle_stress", "300 kPa", "Blemker 2005", "as the force-length curve that Lappet has from there"),
        Sourced("density", "1060 kg/m³", CHOSEN, "a little above water"),
    ),
    published=PublishedCurve("Zwirner 2020b", "temporal muscle", 1580.0, 1.262, 260.0),
)
CARTILAGE = Preset(
    Material("cartilage", youngs_modulus=3010.0, poissons_ratio=0.45, density=1100.0),
    "Cartilage of the nasal septum.",
    (
        Sourced("youngs_modulus", "3010 kPa", "Richmon 2005", "the equilibrium modulus in tension"),
        Sourced("poissons_ratio", "0.45", CHOSEN, "it gives way a little as its water leaves"),
        Sourced("density", "1100 kg/m³", CHOSEN, "a little above water"),
    ),
)
TARSUS = Preset(
    Material(
        "tarsus",
        youngs_modulus=140.0,
        poissons_ratio=0.49,
        fiber_k1=376.4,
        fiber_dispersion=0.1,
        fiber_slack=1.1035,
        density=1100.0,
    ),
    "The tarsal plate of the eyelid.",
    (
        Sourced("youngs_modulus", "140 kPa", "Sun 2015", "the toe modulus"),
        _VOLUME,
        Sourced("fiber_k1", "376.4 kPa", "Sun 2015", "fitted with the slack to the end of the curve"),
        Sourced("fiber_slack", "1.1035", "Sun 2015", "fitted with k₁ to the end of the curve"),
        Sourced("fiber_dispersion", "0.1", CHOSEN, "along the lid's margin"),
        Sourced("density", "1100 kg/m³", CHOSEN, "as of skin"),
    ),
    published=PublishedCurve("Sun 2015", "tarsal plates", 1730.0, 1.30, 245.7, 140.0),
)
DEEP_TISSUES = (FAT, GALEA, MUSCLE, CARTILAGE, TARSUS)
