"""The rows of `lappet report literature`.

No preset of the skin is fitted to any of them. Bounds that a paper gives in words only ("little", "as long as") are
given numbers here; the row says so.
"""

from __future__ import annotations

from math import cos, inf, radians, sqrt

from lappet.output.solve_to_cache import SolveResult
from lappet.reports.literature.measured import (
    Measure,
    Measured,
    closing_force,
    closing_share,
    designed_arc,
    dog_ear,
    gape,
    greatest_in_middle,
    greatest_of,
    limb_turn,
    scar_gain,
    scar_length,
    wound_area,
)
from lappet.reports.literature.published import Published

POUND_FORCE = 4.448  # N
_U_WIDTH = 14.0  # mm, of the U-plasties
_ANGLES = (30, 45, 60, 75, 90)  # of the Z-plasties, in degrees

_FURNAS = "Furnas and Fischer, Br. J. Plast. Surg. 24 (1971) 144, after Limberg"
_DVM = "dvm360 (2004)"
_ROGGENDORF = "Roggendorf (1982)"
_ALBERINI = "Alberini et al., Procedia Structural Integrity 33 (2021) 556"
_TURN = "Dermatology Research and Practice (2010) 982623"
_ARC = "BMC Surgery (2023), 101 patients"
_CHEN = "Chen, as quoted in reviews"
_PIGS = "Plast. Reconstr. Surg. (1980), tension lines of pigs"
_PIGLETS = "Plast. Reconstr. Surg. 107 (2001) 1201, undermining in piglets"
_AHMAD = "Ahmad et al. (2019)"
_LARRABEE = "Larrabee et al. (1981), in piglets"
_RHOMBOID = "Larrabee et al., Rhomboid flap dynamics, Arch. Otolaryngol. 107 (1981) 755, quoted from memory"
_V_Y = "J. Plast. Reconstr. Aesthet. Surg. (2012) S1748-6815(12)00115-5"

_HELD = (
    "presumably the skin around, which its tension and the patch's rim hold, takes up the gain before it shows at the "
    "ends of the scar, as paper does not"
)


def _front_force(result: SolveResult) -> Measured:
    """The greatest force at the front of a U-plasty, whose run goes up one side, over the front and down the other."""
    return greatest_in_middle(result, "flap", _U_WIDTH)


def _z_gain(angle: int, least: float, most: float, source: str, there: str) -> Published:
    return Published(
        f"z-plasty-gain-{angle}",
        f"length that a {angle}° Z-plasty gains along its scar",
        "%",
        least,
        most,
        source,
        there,
        "skin of the trunk, limbs of 20 mm; how far two points 2 mm beyond the scar's ends part, per cent of the limb",
        Measure((f"z-plasty-{angle}",), scar_gain),
        _HELD,
    )


def _turn(angle: int, published: float) -> Published:
    return Published(
        f"z-plasty-turn-{angle}",
        f"angle by which the central limb of a {angle}° Z-plasty turns",
        "°",
        published - 5.0,
        published + 5.0,
        _TURN,
        f"{published:g}° is taught; ± 5° chosen here",
        "the same Z-plasty; the flap's edge against the scar",
        Measure((f"z-plasty-{angle}",), limb_turn),
        "drawn on paper the limb turns by 53.8, 73.7 and 90° for 30, 45 and 60°: the numbers that are taught are round",
    )


def _share_reached(angle: int, result: SolveResult) -> Measured:
    """What a Z-plasty gains, as a share of its gain on paper, sqrt(5 - 4 cos angle) - 1 (`lappet.designs`)."""
    return scar_gain(result).times(0.01 / (sqrt(5.0 - 4.0 * cos(radians(angle))) - 1.0))


def _best_beside_60(*results: SolveResult) -> Measured:
    """The share that 60° reaches over the largest of the other angles."""
    shares = [_share_reached(angle, result) for angle, result in zip(_ANGLES, results, strict=True)]
    sixty = shares.pop(_ANGLES.index(60))
    return sixty.per(max(shares, key=lambda share: share.value))


def _share_off(held: SolveResult, freed: SolveResult) -> Measured:
    """What undermining takes off the closing force, per cent."""
    return Measured(1.0, 0.0).minus(closing_share(held, freed)).times(100.0)


def _scar_length(ratio: int) -> Published:
    return Published(
        f"fusiform-scar-{ratio}",
        f"length of the scar of a {ratio} : 1 fusiform excision over its designed arc",
        "",
        0.95,
        1.05,
        _ARC,
        "the scar is as long as the arc of the design, not as its axis; ± 5 % chosen here",
        f"skin of the trunk, {12 * ratio} × 12 mm along the lines",
        Measure((f"fusiform-{ratio}",), lambda result: scar_length(result).per(designed_arc(result))),
    )


ROWS = (
    _z_gain(
        30,
        20.0,
        30.0,
        _FURNAS,
        "25 % on paper, ± 5 chosen here; in vitro less, and 30° can even shorten (Roggendorf 1982)",
    ),
    _z_gain(45, 45.0, 55.0, _FURNAS, "50 % on paper, ± 5 chosen here"),
    _z_gain(60, 41.0, 63.0, _DVM, "measured in tissue"),
    _z_gain(75, 95.0, 105.0, _FURNAS, "100 % on paper, ± 5 chosen here"),
    _z_gain(90, 115.0, 125.0, _FURNAS, "120 % on paper, ± 5 chosen here"),
    Published(
        "z-plasty-30-below-paper",
        "gain of a 30° Z-plasty over that on paper",
        "",
        -inf,
        1.0,
        _ROGGENDORF,
        "in vitro just below the geometry, or shorter",
        "the same",
        Measure(("z-plasty-30",), lambda result: _share_reached(30, result)),
    ),
    Published(
        "z-plasty-60-over-30",
        "share of the gain on paper that is reached: 60° over 30°",
        "",
        1.0,
        inf,
        _ROGGENDORF,
        "60° and 75° use the gain on paper well, 30° does not",
        "the same",
        Measure(
            ("z-plasty-60", "z-plasty-30"),
            lambda sixty, thirty: _share_reached(60, sixty).per(_share_reached(30, thirty)),
        ),
    ),
    Published(
        "z-plasty-best-angle",
        "share of the gain on paper that is reached: 60° over the best of 30, 45, 75 and 90°",
        "",
        1.0,
        inf,
        _ALBERINI,
        "of 36 designs simulated 60° elongates most efficiently",
        "the same",
        Measure(tuple(f"z-plasty-{angle}" for angle in _ANGLES), _best_beside_60),
        "the more a Z-plasty gains on paper, the more the skin around seems to hold it back",
    ),
    _turn(30, 45.0),
    _turn(45, 60.0),
    _turn(60, 90.0),
    _scar_length(2),
    _scar_length(3),
    _scar_length(4),
    Published(
        "fusiform-dog-ear-5",
        "height of the dog-ear of a 5 : 1 fusiform excision",
        "mm",
        0.0,
        0.5,
        _CHEN,
        "none below an apex of 30°, which takes 5 : 1; none is read as below 0.5 mm, chosen here",
        "skin of the trunk, 60 × 12 mm along the lines",
        Measure(("fusiform-5",), dog_ear),
        "0.5 mm was chosen, and what is called a dog-ear by eye was not measured there; its tip angle is 45°, as its "
        "sides are arcs",
    ),
    Published(
        "fusiform-dog-ear-2-over-5",
        "dog-ear of a 2 : 1 fusiform excision over that of a 5 : 1",
        "",
        1.0,
        inf,
        _CHEN,
        "dog-ears shrink as an excision grows longer",
        "skin of the trunk, 12 mm wide along the lines",
        Measure(("fusiform-2", "fusiform-5"), lambda short, long: dog_ear(short).per(dog_ear(long))),
    ),
    Published(
        "lines-force",
        "force that closes an excision along the lines over one across them",
        "",
        0.0,
        1.0,
        _PIGS,
        "wounds along the lines take less force",
        "skin of the trunk, 36 × 12 mm",
        Measure(
            ("fusiform-3", "fusiform-across"), lambda along, across: closing_force(along).per(closing_force(across))
        ),
    ),
    Published(
        "lines-retraction",
        "area of the wound of an excision along the lines over one across them",
        "",
        0.0,
        1.0,
        _PIGS,
        "wounds along the lines retract less",
        "the same, before the first suture",
        Measure(("fusiform-3", "fusiform-across"), lambda along, across: wound_area(along).per(wound_area(across))),
        "area is not what their retraction was: along the lines the skin pulls least across the wound's width",
    ),
    Published(
        "lines-gape",
        "gape of a straight cut along the lines over one across them",
        "",
        0.0,
        1.0,
        "Langer (1861), and every textbook since",
        "cuts across the lines gape more",
        "skin of the trunk, cuts of 24 mm; the distance of the lips' middles",
        Measure(("cut-along", "cut-across"), lambda along, across: gape(along).per(gape(across))),
    ),
    Published(
        "undermining-trunk",
        "what undermining takes off the force that closes an excision",
        "%",
        13.6,
        30.0,
        _PIGLETS,
        "13.6 % in piglets, to about 30 % elsewhere",
        "skin of the trunk, 36 × 12 mm along the lines, undermined 15 mm around",
        Measure(("fusiform-held", "fusiform-3"), _share_off),
    ),
    Published(
        "undermining-cheek",
        "the same in skin of the cheek",
        "%",
        13.6,
        30.0,
        _PIGLETS,
        "as above",
        "skin of the cheek, tauter; the same excision",
        Measure(("fusiform-cheek-held", "fusiform-cheek"), _share_off),
    ),
    Published(
        "undermining-lines",
        "what undermining takes off along the lines less what it takes off across them",
        "%",
        0.0,
        inf,
        _PIGS,
        "wounds along the lines gain more from undermining",
        "skin of the trunk, 36 × 12 mm",
        Measure(
            ("fusiform-held", "fusiform-3", "fusiform-across-held", "fusiform-across"),
            lambda *results: _share_off(*results[:2]).minus(_share_off(*results[2:])),
        ),
    ),
    Published(
        "scalp-strip",
        "force that closes an excision of the scalp 12 mm wide",
        "N",
        round(0.90 * POUND_FORCE, 1),
        round(3.06 * POUND_FORCE, 1),
        _AHMAD,
        "0.90 to 3.06 lbf for strips 10 to 15 mm wide",
        "skin of the scalp, 36 × 12 mm; the sum over all sutures, deep ones included",
        Measure(("fusiform-scalp",), closing_force),
        "a strip is longer than 36 mm, and its force was measured at one place; the scalp's tension is chosen",
    ),
    Published(
        "scalp-limit",
        "greatest force on a suture of that closure",
        "N",
        0.0,
        15.0,
        _AHMAD,
        "15 N is what surgeons close with at most",
        "the same",
        Measure(("fusiform-scalp",), lambda result: greatest_of(result, "").times(1e-3)),
    ),
    Published(
        "rotation-to-90",
        "force that closes a rotation flap whose arc turns 86° over one of 57°",
        "",
        0.0,
        1.0,
        _LARRABEE,
        "a longer arc lowers the tension up to about 90°",
        "skin of the trunk, defect 12 mm wide, arc of 3 and of 2 times its width",
        Measure(
            ("rotation-3", "rotation-2"), lambda longer, shorter: closing_force(longer).per(closing_force(shorter))
        ),
    ),
    Published(
        "rotation-beyond-90",
        "force that closes a rotation flap whose arc turns 172° over one of 86°",
        "",
        0.9,
        1.1,
        _LARRABEE,
        "little is gained beyond 90°; ± 10 % chosen here",
        "the same, arc of 6 and of 3 times its width",
        Measure(
            ("rotation-6", "rotation-3"), lambda longer, shorter: closing_force(longer).per(closing_force(shorter))
        ),
        "all sutures are summed up, and a longer arc has more of them",
    ),
    Published(
        "advancement-length",
        "greatest force at the front of an advancement flap of 2 : 1 over one of 1 : 1",
        "",
        0.9,
        1.1,
        _LARRABEE,
        "a length of once the width is enough; ± 10 % chosen here",
        "skin of the trunk, U-plasty 14 mm wide",
        Measure(
            ("u-plasty-2", "u-plasty-1"),
            lambda long, short: _front_force(long).per(_front_force(short)),
        ),
        "the forces are those of the front's sutures, which a longer flap shares out with its sides; the undermining "
        "grows with the flap. Which of these it is was not looked into",
    ),
    Published(
        "advancement-length-3",
        "the same of 3 : 1 over 2 : 1",
        "",
        0.9,
        1.1,
        _LARRABEE,
        "as above",
        "the same",
        Measure(
            ("u-plasty-3", "u-plasty-2"),
            lambda long, short: _front_force(long).per(_front_force(short)),
        ),
        "the forces are those of the front's sutures, which a longer flap shares out with its sides; the undermining "
        "grows with the flap. Which of these it is was not looked into",
    ),
    Published(
        "limberg-donor",
        "greatest force where Limberg's donor site is closed over the greatest elsewhere",
        "",
        1.0,
        inf,
        _RHOMBOID,
        "the greatest tension lies at the closure of the donor site",
        "skin of the trunk, sides of 18 mm",
        Measure(
            ("limberg",), lambda result: greatest_of(result, "donor").per(greatest_of(result, "donor", others=True))
        ),
    ),
    Published(
        "v-y-apex",
        "force that closes a V–Y with an apex of 74° over one of 23°",
        "",
        1.0,
        inf,
        _V_Y,
        "an apex of 20 to 60° is taught, as wider ones leave more to close than they give",
        "skin of the trunk, the design's own length",
        Measure(("v-y-wide", "v-y-narrow"), lambda wide, narrow: closing_force(wide).per(closing_force(narrow))),
    ),
)
