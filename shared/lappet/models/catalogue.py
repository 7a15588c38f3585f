"""The body models. Places are those of the neutral body: x to the patient's left, y to the back, z up, mm."""

from __future__ import annotations

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.model import Depth, Excision, Model
from lappet.models.region import Ellipsoid
from lappet.models.sources import CHOSEN

_HEAD = ((-130.0, -190.0, 560.0), (130.0, 120.0, 900.0))
_TORSO = ((-190.0, -260.0, 0.0), (190.0, 200.0, 620.0))
_HAND = ((380.0, -360.0, 40.0), (560.0, -120.0, 280.0))
_LEG = ((40.0, -160.0, -520.0), (260.0, 120.0, 60.0))

HEAD_MODELS = (
    Model(
        "face",
        "the whole face, from the hairline to the chin",
        Ellipsoid((0.0, -105.0, 712.0), (78.0, 72.0, 104.0)),
        Depth(1.2, "Sun 2022", "forehead, glabella, nose, temple and zygoma: 1.1 to 1.2"),
        Depth(2.4, "Iyengar 2018", "the forehead's 2, a little more"),
        "face",
        "default",
        1.8,
        1,
        ("forehead", "glabella", "eyes", "nose", "cheeks", "lips", "chin"),
        Excision((62.0, -95.0, 690.0), (-0.25, 0.0, 1.0), 30.0),
        _HEAD,
    ),
    Model(
        "nose",
        "the nose with its surroundings, nostrils open",
        Ellipsoid((0.0, -140.0, 706.0), (30.0, 45.0, 33.0)),
        Depth(1.4, "Sun 2022", "the dorsum's 1.2; the tip and the ala are thicker (Ha 2005, Chopra 2015)"),
        Depth(1.4, CHOSEN, "to the perichondrium, on which the nose is undermined"),
        "face",
        "tight",
        0.7,
        2,
        ("glabella", "nose", "cheeks", "lips"),
        Excision((3.0, -152.0, 713.0), (1.0, 0.0, 0.15), 12.0),
        _HEAD,
    ),
    Model(
        "lips",
        "both lips with the philtrum and the chin, mouth open",
        Ellipsoid((0.0, -138.0, 664.0), (48.0, 48.0, 26.0)),
        Depth(1.2, "Sun 2022", "of the zygoma; the lips themselves were not measured there"),
        Depth(2.4, CHOSEN, "to the orbicularis"),
        "face",
        "loose",
        1.0,
        2,
        ("lips", "chin", "cheeks"),
        Excision((20.0, -141.0, 655.0), (-0.25, 0.0, 1.0), 12.0),
        _HEAD,
    ),
    Model(
        "eyelids",
        "the left eye with both lids, open",
        Ellipsoid((32.0, -130.0, 734.0), (40.0, 45.0, 34.0)),
        Depth(0.8, "Sun 2022", "of the eyelid: 0.8; Chopra 2015 has 0.76 for its dermis"),
        Depth(1.2, CHOSEN, "the orbicularis, to the septum and the tarsus"),
        "eyelid",
        "loose",
        0.6,
        2,
        ("eyes", "forehead", "cheeks", "glabella"),
        Excision((33.0, -136.0, 743.5), (1.0, 0.0, 0.0), 18.0),
        _HEAD,
    ),
    Model(
        "forehead",
        "the forehead from brow to hairline",
        Ellipsoid((0.0, -130.0, 782.0), (62.0, 60.0, 36.0)),
        Depth(1.2, "Sun 2022", "of the forehead: 1.2"),
        Depth(2.0, "Iyengar 2018", "of the forehead: 2, down to the frontalis and galea"),
        "forehead",
        "default",
        1.0,
        2,
        ("forehead", "glabella"),
        Excision((15.0, -138.0, 785.0), (1.0, 0.0, 0.0), 30.0),
        _HEAD,
    ),
    Model(
        "cheek",
        "the left cheek, from the lower lid to the jaw",
        Ellipsoid((58.0, -105.0, 690.0), (42.0, 50.0, 44.0)),
        Depth(1.2, "Sun 2022", "of the zygoma: 1.2"),
        Depth(2.8, CHOSEN, "to the SMAS; Iyengar 2018 has 6 mm of fat at the temple"),
        "cheek",
        "loose",
        1.0,
        2,
        ("cheeks", "eyes", "nose", "lips"),
        Excision((58.0, -108.0, 690.0), (-0.3, 0.0, 1.0), 26.0),
        _HEAD,
    ),
    Model(
        "temple",
        "the left temple, between brow, hairline and zygoma",
        Ellipsoid((72.0, -75.0, 750.0), (40.0, 46.0, 36.0)),
        Depth(1.1, "Sun 2022", "of the temple: 1.1"),
        Depth(2.9, CHOSEN, "to the superficial temporal fascia; Iyengar 2018 has 6 mm of fat"),
        "face",
        "loose",
        1.0,
        2,
        ("forehead", "eyes", "cheeks"),
        Excision((70.0, -85.0, 752.0), (0.4, 1.0, 0.3), 26.0),
        _HEAD,
    ),
    Model(
        "chin",
        "the chin and the lower lip below the vermilion",
        Ellipsoid((0.0, -135.0, 640.0), (38.0, 40.0, 22.0)),
        Depth(1.15, "Sun 2022", "of the submandibular skin: 1.2"),
        Depth(2.85, CHOSEN, "Iyengar 2018 has 5 mm of fat at the chin; the rest is bed"),
        "face",
        "tight",
        1.0,
        2,
        ("chin", "lips"),
        Excision((9.0, -139.0, 641.0), (1.0, 0.0, 0.2), 16.0),
        _HEAD,
    ),
    Model(
        "ear",
        "the left ear with the skin around it",
        Ellipsoid((78.0, -28.0, 712.0), (40.0, 36.0, 44.0)),
        Depth(1.2, CHOSEN, "Chopra 2015: the skin behind the ear is among the thickest of the face"),
        Depth(1.2, CHOSEN, "to the perichondrium and the mastoid fascia; half of the auricle where that is less"),
        "face",
        "tight",
        0.8,
        2,
        ("cheeks",),
        Excision((74.0, -58.0, 700.0), (0.0, 0.0, 1.0), 14.0),
        _HEAD,
    ),
    Model(
        "neck",
        "the front of the neck",
        Ellipsoid((0.0, -70.0, 592.0), (56.0, 60.0, 34.0)),
        Depth(1.2, "Sun 2022", "of the neck: 1.2"),
        Depth(2.8, CHOSEN, "to the platysma; Iyengar 2018 has 6 mm of submental fat"),
        "face",
        "loose",
        1.2,
        2,
        ("neck",),
        Excision((10.0, -72.0, 590.0), (1.0, 0.0, 0.0), 30.0),
        ((-190.0, -220.0, 470.0), (190.0, 140.0, 900.0)),
    ),
    Model(
        "scalp",
        "the crown of the head",
        Ellipsoid((0.0, -45.0, 838.0), (66.0, 72.0, 40.0)),
        Depth(1.6, CHOSEN, "thicker than the forehead's 1.2 (Sun 2022)"),
        Depth(3.0, CHOSEN, "dense fat and galea, to the loose layer"),
        "scalp",
        "default",
        1.2,
        2,
        ("scalp",),
        Excision((12.0, -45.0, 840.0), (1.0, 0.0, 0.0), 36.0),
        _HEAD,
    ),
)

BODY_MODELS = (
    Model(
        "hand",
        "the back of the left hand",
        Ellipsoid((484.0, -221.0, 179.0), (38.0, 26.0, 13.0), (44.0, -77.0, -51.0), (25.0, 55.0, -27.0)),
        Depth(1.2, CHOSEN, "thin skin; no measurement was found"),
        Depth(1.2, CHOSEN, "loose areolar tissue above the tendons"),
        "limb",
        "loose",
        0.7,
        2,
        ("hand",),
        Excision((484.0, -221.0, 179.0), (25.0, 55.0, -27.0), 16.0),
        _HAND,
    ),
    Model(
        "breast",
        "the left breast of a woman",
        Ellipsoid((72.0, -140.0, 390.0), (74.0, 70.0, 74.0)),
        Depth(1.6, CHOSEN, "between the abdomen's 2.2 (Gibney 2010) and the face's"),
        Depth(5.4, CHOSEN, "of the gland's cover of fat"),
        "trunk",
        "loose",
        2.0,
        3,
        ("breast",),
        Excision((72.0, -146.0, 345.0), (1.0, 0.0, 0.0), 40.0),
        _TORSO,
        female=True,
    ),
    Model(
        "trunk",
        "the front of the abdomen",
        Ellipsoid((0.0, -110.0, 230.0), (84.0, 70.0, 84.0)),
        Depth(2.2, "Gibney 2010", "of the abdomen: 2.2"),
        Depth(5.8, "Gibney 2010", "part of the abdomen's 13.9, down to the superficial fascia"),
        "trunk",
        "loose",
        2.0,
        3,
        ("abdomen",),
        Excision((35.0, -115.0, 260.0), (1.0, 0.0, 0.0), 40.0),
        _TORSO,
    ),
    Model(
        "limb",
        "the front of the left thigh",
        Ellipsoid((124.0, -95.0, -130.0), (52.0, 50.0, 84.0)),
        Depth(1.9, "Gibney 2010", "of the thigh: 1.9"),
        Depth(4.1, "Gibney 2010", "part of the thigh's 10.4"),
        "limb",
        "loose",
        1.5,
        3,
        ("thigh",),
        Excision((124.0, -95.0, -130.0), (0.1, 0.0, 1.0), 45.0),
        _LEG,
    ),
)

MODELS = {model.name: model for model in (*HEAD_MODELS, *BODY_MODELS)}


def model_named(name: str) -> Model:
    """Look up a body model.

    Parameters
    ----------
    name
        Its name.

    Returns
    -------
    Model
        The model.

    Raises
    ------
    RefusedError
        If there is none of that name.
    """
    if name not in MODELS:
        raise refused(ProblemCode.MODEL_UNKNOWN, name, name, known=", ".join(MODELS))
    return MODELS[name]
