"""Skins: the default, those of the regions of the body, of age and of disease, and excised dermis.

All but dermis share the law of the default: crimped fibers in a soft matrix. What was measured of a region is its
tension; where even that was not, the table says so.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from lappet.procedure import DEFAULT_SKIN, Material
from lappet.tissue.presets.preset import CHOSEN, Preset, PublishedCurve, Sourced

_MATRIX = Sourced("youngs_modulus", "50 kPa", "Jor 2011", "a shear modulus of 17 kPa, within those of the matrix")
_VOLUME = Sourced(
    "poissons_ratio",
    "0.49",
    CHOSEN,
    "keeps the volume within 1 % up to a stretch of 1.6, along and across; a lattice locks nearer to 0.5",
)
_SLACK = Sourced("fiber_slack", "1.05", "Jor 2011", "the low end of the undulations")
_K1 = Sourced(
    "fiber_k1",
    "200 kPa",
    "Diridollou 2000",
    "for a mean modulus of 116 kPa under 13.5 kPa in all directions of the skin: 129 ± 88 kPa were measured",
)
_K2 = Sourced("fiber_k2", "1", CHOSEN, "stiffens gently, so that the modulus at a stretch of 1.4 is 8 times the first")
_DISPERSION = Sourced("fiber_dispersion", "0.25", CHOSEN, "2.7 times as stiff along the lines as across under 13.5 kPa")
_DENSITY = Sourced("density", "1100 kg/m³", CHOSEN, "a little above water")
_LAW = (_MATRIX, _VOLUME, _K1, _K2, _DISPERSION, _SLACK, _DENSITY)

SKIN = Preset(
    DEFAULT_SKIN,
    "Skin without tension: a soft matrix and crimped fibers that take over as it stretches.",
    _LAW,
)


def _taut(name: str, summary: str, tension: tuple[float, float], source: str, how: str) -> Preset:
    """Skin of the default's law under a tension along and across the lines in kPa."""
    shown = f"{tension[0]:g} and {tension[1]:g} kPa"
    values = (*_LAW, Sourced("tension", shown, source, how))
    return Preset(replace(DEFAULT_SKIN, name=name), f"{summary} Its law is the default skin's.", values, tension)


def _changed(name: str, summary: str, tension: tuple[float, float], how: Sourced, *values: Sourced) -> Preset:
    """Skin of another law than the default's, whose values are given; how: of its tension."""
    told = {value.parameter: value for value in values}
    law = tuple(told.get(value.parameter, value) for value in _LAW)
    numbers: dict[str, Any] = {value.parameter: float(value.value.split()[0]) for value in values}
    material = replace(DEFAULT_SKIN, name=name, **numbers)
    return Preset(material, summary, (*law, how), tension)


_ACROSS = "half of it across, chosen"
TAUT_SKIN = _taut(
    "taut_skin",
    "Skin under a mild tension: it parts when it is cut, and takes up what a flap gives.",
    (13.5, 6.75),
    "Diridollou 2000",
    f"of the forearm; {_ACROSS}",
)
FACE = _taut("face", "Skin of the face.", (20.0, 10.0), "Flynn 2018", f"between lip and cheek; {_ACROSS}")
CHEEK = _taut("cheek", "Skin of the cheek.", (53.0, 26.5), "Flynn 2018", f"the middle of the cheek; {_ACROSS}")
FOREHEAD = _taut("forehead", "Skin of the forehead.", (20.0, 10.0), CHOSEN, "as of the face; no measurement was found")
EYELID = _taut("eyelid", "Skin of the eyelid.", (5.0, 2.5), CHOSEN, "it is loose; no measurement was found")
SCALP = _taut("scalp", "Skin of the scalp.", (30.0, 20.0), CHOSEN, "taut in all directions; no measurement was found")
TRUNK = _taut("trunk", "Skin of the trunk.", (20.0, 10.0), CHOSEN, "between face and arm; no measurement was found")
LIMB = _taut("limb", "Skin of the arm.", (28.0, 14.0), "Flynn 2011", f"the low end of the arms; {_ACROSS}")
YOUNG_SKIN = _changed(
    "young_skin",
    "Skin of a young adult.",
    (20.0, 10.0),
    Sourced("tension", "20 and 10 kPa", CHOSEN, "more than in the old, whose skin folds"),
    Sourced("youngs_modulus", "35 kPa", "Agache 1980", "half of the old; both lie about the default"),
    Sourced("fiber_slack", "1.1", CHOSEN, "stretches further before it stiffens"),
)
OLD_SKIN = _changed(
    "old_skin",
    "Skin of the old.",
    (7.0, 3.5),
    Sourced("tension", "7 and 3.5 kPa", CHOSEN, "it folds"),
    Sourced("youngs_modulus", "70 kPa", "Agache 1980", "twice that of the young"),
    Sourced("fiber_slack", "1.03", CHOSEN, "its stretchability was found to diminish from 30 years on"),
)
EDEMATOUS_SKIN = _changed(
    "edematous_skin",
    "Skin over an edema.",
    (40.0, 40.0),
    Sourced("tension", "40 and 40 kPa", CHOSEN, "swollen in all directions; no measurement was found"),
    Sourced("density", "1060 kg/m³", CHOSEN, "more water"),
)
SCAR = _changed(
    "scar",
    "A hypertrophic scar.",
    (10.0, 10.0),
    Sourced("tension", "10 and 10 kPa", CHOSEN, "no direction; no measurement was found"),
    Sourced("youngs_modulus", "150 kPa", CHOSEN, "stiffer than skin, as Clark et al. found (Burns 22:443)"),
    Sourced("fiber_k1", "800 kPa", CHOSEN, "less extensible, as they found"),
    Sourced("fiber_slack", "1.01", CHOSEN, "its fibers are parallel and straight"),
)
DERMIS_OF_THE_BACK = Preset(
    Material(
        "dermis",
        youngs_modulus=1180.0,
        poissons_ratio=0.49,
        fiber_k1=15166.0,
        fiber_dispersion=0.1404,
        fiber_slack=1.1054,
        density=1100.0,
    ),
    "Excised skin of the human back, far stiffer than skin feels to a surgeon.",
    (
        Sourced("youngs_modulus", "1180 kPa", "Ní Annaidh 2012", "the mean initial slope, 1.18 ± 0.88 MPa"),
        Sourced("poissons_ratio", "0.49", CHOSEN, "nearly incompressible"),
        Sourced("fiber_k1", "15166 kPa", "Ní Annaidh 2012", "fitted with the slack to the end of the curve"),
        Sourced("fiber_slack", "1.1054", "Ní Annaidh 2012", "fitted with k₁ to the end of the curve"),
        Sourced("fiber_dispersion", "0.1404", "Ní Annaidh 2012b", "of the fibers in histological sections"),
        Sourced("density", "1100 kg/m³", CHOSEN, "a little above water"),
    ),
    published=PublishedCurve("Ní Annaidh 2012", "skin of the back", 83300.0, 1.54, 21600.0, 1180.0),
)
SKINS = (
    SKIN,
    TAUT_SKIN,
    SCALP,
    FACE,
    CHEEK,
    EYELID,
    FOREHEAD,
    TRUNK,
    LIMB,
    YOUNG_SKIN,
    OLD_SKIN,
    EDEMATOUS_SKIN,
    SCAR,
    DERMIS_OF_THE_BACK,
)
