"""What a material is to an anatomist, by its name: skin, fat, fascia, muscle, cartilage or mucosa; and its color."""

from __future__ import annotations

import re

from lappet.procedure import Material

# How atlases and operative photographs color cut tissue, linear RGB.
KIND_COLORS: dict[str, tuple[float, float, float]] = {
    "skin": (0.66, 0.225, 0.195),
    "fat": (0.84, 0.56, 0.17),
    "fascia": (0.74, 0.68, 0.58),
    "muscle": (0.36, 0.045, 0.045),
    "cartilage": (0.66, 0.72, 0.74),
    "mucosa": (0.70, 0.19, 0.22),
    "scar": (0.78, 0.50, 0.45),
    "other": (0.52, 0.34, 0.30),
}
KINDS = tuple(KIND_COLORS)

# Words of names, in the singular, the names of `lappet.tissue.presets` among them.
_WORDS = {
    "skin": (
        *("skin", "dermis", "epidermis", "cutis"),
        *("scalp", "face", "cheek", "eyelid", "forehead", "trunk", "limb"),  # of the skin of these places
    ),
    "fat": ("fat", "subcutis", "subcutaneous", "hypodermis", "panniculus", "adipose"),
    "fascia": ("galea", "fascia", "smas", "aponeurosis", "periosteum", "tendon", "ligament", "septum"),
    "muscle": ("muscle", "musculus", "orbicularis", "frontalis", "platysma", "masseter", "temporalis", "levator"),
    "cartilage": ("cartilage", "tarsus", "tarsal"),
    "mucosa": ("mucosa", "conjunctiva", "vermilion"),
    "scar": ("scar", "keloid"),
}
_KIND_OF = {word: kind for kind, words in _WORDS.items() for word in words}


def tissue_kind(material: Material, default: str = "other") -> str:
    """Tell what a material is.

    The last word of its name that is known decides ("skin_fat" is fat); muscle that can be active is muscle whatever
    it is called.

    Parameters
    ----------
    material
        The material.
    default
        What it is where no word of its name is known.

    Returns
    -------
    str
        One of `KINDS`.
    """
    words = re.findall(r"[a-z]+", material.name.lower())
    found = [_KIND_OF[word] for word in words if word in _KIND_OF]
    if found:
        return found[-1]
    return "muscle" if material.has_muscle else default
