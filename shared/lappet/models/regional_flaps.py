"""Where the designs of the flap library belong on a body: a model, a place on it, and measures that fit there.

The examples, the atlas and the site's downloads take them from here.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

from numpy.typing import ArrayLike

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.designs.library_operation import add_flap, skin_line_direction
from lappet.models.body_shape import BodyShape
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import new_model
from lappet.models.scar_band import with_scar_band
from lappet.procedure import FlapLines, Point, Procedure


@dataclass(frozen=True)
class RegionalFlap:
    """A design where it belongs on a body.

    Parameters
    ----------
    name
        Name of the operation.
    place
        Where it is, for people: what follows "on".
    model
        Name of the model.
    design
        Name of the design.
    at
        Where it lies on the model in mm.
    direction
        Its direction, or how it lies to the lines of the skin.
    measures
        Values of the design's parameters that are not the default.
    remark
        What the model lacks there, or what to look at, in a sentence or two.
    mirrored
        Whether the design is mirrored.
    targets
        Shape targets of the body and their amounts, where it has not the usual shape.
    scar
        Length and width in mm of a contracted scar along the direction, or None.
    spacing
        Edge of the lattice's cells in mm; None for the model's.
    weightless
        Whether it is solved without gravity, as what is cut free of a lip lies on nothing that holds it.
    self_contact
        Whether tissue is kept from passing through tissue: where the atlas comes to its end so.
    """

    name: str
    place: str
    model: str
    design: str
    at: Point
    direction: Point | Literal["along", "across"]
    measures: dict[str, float] = field(default_factory=dict)
    remark: str = ""
    mirrored: bool = False
    targets: tuple[tuple[str, float], ...] = ()
    scar: tuple[float, float] | None = None
    spacing: float | None = None
    weightless: bool = False
    self_contact: bool = True


# An upper lid that hangs over its crease, on both eyes.
_HOODED = tuple((f"eyes/{side}-eye-eyefold-{what}", 1.0) for side in "lr" for what in ("convex", "down"))
# In the order of the library.
REGIONAL_FLAPS = {
    flap.name: flap
    for flap in (
        RegionalFlap(
            "upper_eyelid",
            "the upper eyelid",
            "eyelids",
            "upper-lid",
            (-32.0, 139.0, 742.3),
            (-1.0, 0.0, 0.0),
            {"length": 28.0, "width": 4.5},
            "The lid has no tarsus and no levator that hold its edge and its crease.",
            targets=_HOODED,
        ),
        RegionalFlap(
            "web_z_plasty",
            "the first web space of a hand",
            "web-space",
            "z-plasty",
            (-447.0, 259.5, 167.0),
            (-1.0, 0.1, 0.1),
            {"limb": 8.0},
            "The web is not contracted, and nothing below its skin keeps it thick.",
            self_contact=False,
        ),
        RegionalFlap(
            "neck_z_plasty",
            "a contracted scar of the neck",
            "neck",
            "z-plasty",
            (0.0, 75.0, 592.0),
            (0.0, 0.0, 1.0),
            {"limb": 15.0},
            "The scar, 44 by 6 mm, pulls with 40 kPa along itself (chosen; no measurement was found).",
            scar=(44.0, 6.0),
            self_contact=False,
        ),
        RegionalFlap(
            "web_five_flap",
            "the first web space of a hand",
            "web-space",
            "five-flap-z-plasty",
            (-447.0, 259.5, 167.0),
            (-1.0, 0.1, 0.1),
            {"limb": 8.0},
            "The web is not contracted, and nothing below its skin keeps it thick.",
            self_contact=False,
        ),
        RegionalFlap(
            "cheek_limberg",
            "the cheek",
            "cheek",
            "limberg",
            (-50.0, 112.0, 692.0),
            "across",
            {"side": 11.0},
        ),
        RegionalFlap(
            "nose_bilobed",
            "the nose",
            "nose",
            "bilobed",
            (-3.0, 156.0, 705.0),
            (1.0, 0.0, 0.0),
            {"diameter": 7.0},
            "The nose has no cartilage but a bed that does not move: its ala cannot be drawn up.",
            mirrored=True,
        ),
        RegionalFlap(
            "nose_trilobed",
            "the tip of the nose",
            "nose",
            "trilobed",
            (-3.0, 157.5, 702.0),
            (1.0, 0.0, -0.3),
            {"diameter": 6.0},
            "The nose has no cartilage but a bed that does not move: its ala cannot be drawn up.",
            mirrored=True,
        ),
        RegionalFlap(
            "ala_nasolabial",
            "the ala",
            "midface",
            "nasolabial",
            (-15.5, 146.0, 700.0),
            (0.3, 0.3, -0.9),
            {"diameter": 7.0},
            "The flap bridges the groove between ala and cheek and makes it shallow, as such flaps do; the landmark "
            "alare lies on it and goes along, and what is measured as a dog-ear is partly its rise out of the groove. "
            "The nostril keeps its shape because the bed below the nose does not move; on a patient the ala could.",
        ),
        RegionalFlap(
            "nose_dorsal",
            "the back of the nose",
            "midface",
            "dorsal-nasal",
            (0.0, 157.5, 705.0),
            (0.04, 0.0, 1.0),
            {"diameter": 9.0, "length": 52.0, "half_width": 11.0, "back_cut": 20.0, "slide": 0.6},
            "A dog-ear stands beside the tip, where a surgeon takes a triangle away.",
        ),
        RegionalFlap(
            "nose_forehead",
            "the back of the nose",
            "face",
            "paramedian-forehead",
            (18.5, 139.0, 749.0),  # on the supratrochlear artery
            (0.66, 0.0, 0.75),
            {"diameter": 14.0, "distance": 38.0, "width": 9.0, "spare": 5.0, "turn": 140.0, "thinned": 2.8},
            "The third stage leaves 2.8 mm of the paddle, as the model `nose` has. It makes the paddle lie lower: as "
            "the model's forehead and nose are equally thick, it stood no prouder than its surroundings before.",
            mirrored=True,
        ),
        RegionalFlap(
            "scalp_rotation",
            "the scalp",
            "scalp",
            "rotation",
            (-12.0, 45.0, 840.0),
            (0.0, 1.0, 0.0),
            remark="Hair and galea are not in the model.",
        ),
        RegionalFlap(
            "cheek_cervicofacial",
            "the cheek below the eye",
            "face",
            "cervicofacial",
            (-45.6, 127.5, 703.1),
            (0.1, 0.0, 1.0),
            {"width": 14.0, "length": 17.0, "reach": 30.0, "drop": 44.0},
            "The model ends in front of the ear and at the jaw, so that no skin comes from the neck.",
            self_contact=False,
        ),
        RegionalFlap(
            "temple_o_z",
            "the temple",
            "temple",
            "o-z",
            (-70.0, 75.0, 755.0),
            "along",
            {"diameter": 10.0},
        ),
        RegionalFlap(
            "forehead_h",
            "the forehead",
            "forehead",
            "h-plasty",
            (-15.0, 138.0, 785.0),
            "along",
            {"width": 12.0},
        ),
        RegionalFlap(
            "lip_a_t",
            "the upper lip",
            "lips",
            "a-t",
            (-13.5, 147.0, 678.7),
            (-1.0, 0.0, -0.22),
            {"width": 7.0, "height": 1.1, "limb": 0.85, "burow": 0.0},
            "The lip is skin on a bed: it has no muscle and no red inside.",
        ),
        RegionalFlap(
            "cheek_island",
            "the cheek beside the nose",
            "cheek",
            "island-v-y",
            (-40.1, 130.2, 694.0),
            (0.4, 0.0, 0.9),
            {"width": 10.0},
        ),
        RegionalFlap(
            "limb_keystone",
            "the thigh",
            "limb",
            "keystone",
            (-132.1, 122.8, -130.5),
            (-0.1, 0.0, 1.0),
            {"length": 42.0, "width": 14.0},
            "Perforators are not in the model.",
        ),
        RegionalFlap(
            "trunk_keystone",
            "the trunk",
            "trunk",
            "keystone-iii",
            (-37.3, 137.5, 257.7),
            (-1.0, 0.0, 0.0),
            remark="Perforators are not in the model.",
        ),
        RegionalFlap(
            "cleft_lip_millard",
            "an incomplete cleft of the upper lip",
            "cleft-lip",
            "millard",
            (-8.5, 148.5, 689.5),
            (-0.217, 0.866, -0.451),
            {
                "medial": 10.9,
                "lateral": 14.0,
                "gap": 17.6,
                "ala": 11.0,
                "red": 8.0,
                "narrowing": -0.1,
                "blade_turn": 20.0,
                "blade_lift": 22.0,
                "undermined": 0.0,
            },
            "The lip is skin over fat that lies on its mucosa: it has no muscle to be put together, and its red is not "
            "drawn. Nothing is done to the nose.",
            spacing=1.2,
            weightless=True,
        ),
        RegionalFlap(
            "lip_karapandzic",
            "the lower lip",
            "lips",
            "karapandzic",
            (0.0, 147.0, 661.0),
            (-1.0, 0.0, 0.0),
            {"width": 14.0, "height": 14.0, "mouth": 48.0, "alar": 13.0},
            "The lip has no mucosa, which a surgeon would leave whole, and no muscle.",
            self_contact=False,
        ),
    )
}


def regional_flaps(design: str) -> list[RegionalFlap]:
    """List the operations of a design on a body.

    Parameters
    ----------
    design
        Name of the design.

    Returns
    -------
    list[RegionalFlap]
        The operations; none for a design that belongs to no region.
    """
    return [flap for flap in REGIONAL_FLAPS.values() if flap.design == design]


def flap_on_model(name: str, spacing: float | None = None, *, scenery: bool = True, reach: float = 1.0) -> Procedure:
    """Make the procedure of a design where it belongs on a body.

    Parameters
    ----------
    name
        Name of the operation.
    spacing
        Edge of the lattice's cells in mm; None for the model's.
    scenery
        Whether the body around the tissue is shown.
    reach
        How many times as far as usual the model's tissue reaches.

    Returns
    -------
    Procedure
        The procedure.

    Raises
    ------
    RefusedError
        If there is no such operation or the package of the models is not there.
    """
    if name not in REGIONAL_FLAPS:
        raise refused(ProblemCode.DESIGN_UNKNOWN, "", name, known=", ".join(REGIONAL_FLAPS))
    flap = REGIONAL_FLAPS[name]
    shape = BodyShape(targets=flap.targets) if flap.targets else None
    start = new_model(flap.model, ModelChoice(shape=shape, scenery=scenery, reach=reach))
    chosen = spacing if spacing is not None else flap.spacing
    if chosen is not None:
        start = replace(start, tissue=replace(start.tissue, spacing=chosen))
    if flap.weightless:
        start = replace(start, tissue=replace(start.tissue, gravity=0.0))
    start = replace(start, tissue=replace(start.tissue, self_contact=flap.self_contact))
    lines: FlapLines = ""
    direction: ArrayLike = flap.direction
    if isinstance(flap.direction, str):
        lines = flap.direction
        direction = skin_line_direction(start, flap.at, across=lines == "across")
    if flap.scar is not None:
        start = with_scar_band(start, flap.at, direction, *flap.scar)
    return add_flap(start, flap.design, flap.at, direction, flap.measures, mirrored=flap.mirrored, lines=lines)
