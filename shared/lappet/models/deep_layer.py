"""The layer below the fat of a model that is asked for: SMAS, fascia, muscle or cartilage.

The fibers of muscles run across the skin lines (Borges 1984), and so do they here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.model import Depth, Model, Trial
from lappet.models.sources import CHOSEN
from lappet.procedure import Material, Procedure, Region
from lappet.tissue.presets import CARTILAGE, GALEA, MUSCLE, PRESETS
from lappet.tissue.surface import skin_faces

FACES = "deep_layer"


@dataclass(frozen=True)
class DeepLayer:
    """A layer below skin and fat.

    Parameters
    ----------
    title
        What it is, in a few words.
    material
        Its material.
    depth
        Its thickness.
    within
        Whether it is the deepest part of what the model has below its skin anyway; else the tissue is thicker by it.
    subunits
        Subunits of the model below which it is; none for all of it.
    trial
        The excision through it, where the model's own lies beside it; None for the model's.
    """

    title: str
    material: Material
    depth: Depth
    within: bool = False
    subunits: tuple[str, ...] = ()
    trial: Trial | None = None

    @property
    def added(self) -> float:
        """By how much the tissue is thicker with it, in mm."""
        return 0.0 if self.within else self.depth.mm


_SMAS = replace(PRESETS["face"].unstretched, name="smas")
_FASCIA = replace(GALEA.material, name="superficial_temporal_fascia")


def _muscle(name: str) -> Material:
    return replace(MUSCLE.material, name=name, fiber_angle=90.0)


_THIN = Depth(
    1.0,
    CHOSEN,
    "Caliskan 2020 has 0.12 over the zygoma, less than such images tell apart; its law is the skin's, as Har-Shai 1996 "
    "found both somewhat alike",
)
_CLEFT = DeepLayer(
    "the orbicularis of the mouth",
    _muscle("orbicularis_oris"),
    Depth(1.0, "J Craniofac Surg 2011", "of infants, the mean of both sides; a lip with a cleft has no room for more"),
    within=True,
)
DEEP_LAYERS = {
    "face": DeepLayer("the SMAS", _SMAS, _THIN),
    "cheek": DeepLayer("the SMAS", _SMAS, _THIN),
    "temple": DeepLayer(
        "the superficial temporal fascia",
        _FASCIA,
        Depth(1.0, CHOSEN, "less than StatPearls 29940 has, as its law is the dense galea's, which goes over into it"),
    ),
    "nose": DeepLayer(
        "the cartilages of the tip and of the sidewalls",
        CARTILAGE.material,
        Depth(0.55, "Dhong 2002", "of the lateral crura; the upper cartilages are taken to be as thick"),
        subunits=("nasal_tip", "columella", "nasal_sidewall_left", "nasal_sidewall_right"),
        trial=Trial((-11.0, 140.0, 717.0), (0.3, 0.3, 1.0), 10.0, beyond=0.2),
    ),
    "ear": DeepLayer(
        "the cartilage of the auricle",
        CARTILAGE.material,
        Depth(1.2, "Brockhoff 2014", "of the concha, the mean of both sexes; the rest is taken to be as thick"),
        within=True,
        subunits=(
            "helix_left",
            "scapha_left",
            "triangular_fossa_left",
            "antihelix_left",
            "concha_left",
            "tragus_left",
            "antitragus_left",
        ),
        trial=Trial((-70.0, 41.5, 712.0), (0.0, 0.3, 1.0), 10.0, beyond=0.15),
    ),
    "lips": DeepLayer(
        "the orbicularis of the mouth",
        _muscle("orbicularis_oris"),
        Depth(2.0, "van Alfen 2013", "between the 1.5 and 3.0 of muscles around the mouth"),
    ),
    "cleft-lip": _CLEFT,
    "cleft-lip-complete": _CLEFT,
    "eyelids": DeepLayer(
        "the orbicularis of the eye",
        _muscle("orbicularis_oculi"),
        Depth(1.0, "Abe 2019", "least difference that ultrasound tells, 0.25 mm, which is 25 % of its thickness"),
        within=True,
    ),
    "forehead": DeepLayer(
        "the frontalis",
        _muscle("frontalis"),
        Depth(
            1.5,
            CHOSEN,
            "at least 1.1, as 22 % of it are no less than 0.25 mm (Abe 2019); at most 2, what skin and fat leave of "
            "the 5.2 above the bone (Cakmakoglu 2025)",
        ),
    ),
    "neck": DeepLayer(
        "the platysma",
        _muscle("platysma"),
        Depth(0.75, "Calomeni 2024", "at rest, between a band's and that beside it"),
    ),
    "scalp": DeepLayer(
        "the galea",
        GALEA.material,
        Depth(0.5, "Coronal approach", "which does not say that it was measured"),
        within=True,
    ),
}


def deep_layer(model: str) -> DeepLayer:
    """Look up the layer of a model.

    Parameters
    ----------
    model
        Name of the model.

    Returns
    -------
    DeepLayer
        The layer.

    Raises
    ------
    RefusedError
        If the model has none.
    """
    if model not in DEEP_LAYERS:
        raise refused(ProblemCode.MODEL_NO_DEEP_LAYER, model, model, known=", ".join(DEEP_LAYERS))
    return DEEP_LAYERS[model]


def trial_of(model: Model, layer: DeepLayer | None) -> Trial:
    """Choose the excision with which a model is tried.

    Parameters
    ----------
    model
        The model.
    layer
        The layer below its fat; None for none.

    Returns
    -------
    Trial
        The layer's, if it has its own, else the model's.
    """
    return layer.trial if layer is not None and layer.trial is not None else model.trial


def with_deep_layer(procedure: Procedure, layer: DeepLayer, below_skin: float) -> Procedure:
    """Lay a layer below the fat of a procedure.

    Parameters
    ----------
    procedure
        A procedure of skin over fat, its tissue thick enough.
    layer
        The layer.
    below_skin
        Depth of its upper side in mm.

    Returns
    -------
    Procedure
        The procedure with its region, after all others.
    """
    tissue = procedure.tissue
    faces = np.flatnonzero(skin_faces(tissue)).astype(np.int32)
    if layer.subunits:
        own = [tissue.subsets[f"subunit_{name}"] for name in layer.subunits if f"subunit_{name}" in tissue.subsets]
        faces = np.unique(np.concatenate(own)).astype(np.int32)
    region = Region(FACES, layer.material.name, depth_from=below_skin)
    deeper = replace(tissue, subsets={**tissue.subsets, FACES: faces}, regions=(*tissue.regions, region))
    return replace(procedure, tissue=deeper, materials=(*procedure.materials, layer.material))
