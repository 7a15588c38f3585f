"""Tissue from meshes and patches, and where points lie on its skin."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lappet.core.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from lappet.tissue.dome import dome_bone, dome_scalp, draped
    from lappet.tissue.patch import flat_patch
    from lappet.tissue.placement import Place, onto
    from lappet.tissue.skin_sheet import SkinSheet
    from lappet.tissue.surgical_field import Box, Disc, Outline, Sphere
    from lappet.tissue.tissue_from_mesh import new_tissue, tissue_of_mesh

__all__ = [
    "Box",
    "Disc",
    "Outline",
    "Place",
    "SkinSheet",
    "Sphere",
    "dome_bone",
    "dome_scalp",
    "draped",
    "flat_patch",
    "new_tissue",
    "onto",
    "tissue_of_mesh",
]

__getattr__, __dir__ = lazy_exports(
    __name__,
    {
        "dome": ("dome_bone", "dome_scalp", "draped"),
        "patch": ("flat_patch",),
        "placement": ("Place", "onto"),
        "skin_sheet": ("SkinSheet",),
        "surgical_field": ("Box", "Disc", "Outline", "Sphere"),
        "tissue_from_mesh": ("new_tissue", "tissue_of_mesh"),
    },
)
