"""Layers follow from regions and materials: which lies at a depth, where columns meet, what one material gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.anatomy.tissue_kind import KIND_COLORS, KINDS, tissue_kind
from lappet.anatomy.tissue_layers import layer_search
from lappet.cutting.epochs import build_epochs
from lappet.geometry.labeled_surface import FaceOrigin, Surface
from lappet.procedure import Incision, Material, Procedure, Region
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets import PRESETS
from lappet.tissue.presets.layers import skin_over_fat
from lappet.tissue.surface import skin_faces

TOP = 10.0
CUT = Incision("cut", 1.0, ((-9.0, 0.0, TOP), (9.0, 0.0, TOP)))


def procedure() -> Procedure:
    """A patch 10 mm thick of one material, cut through."""
    return Procedure(flat_patch((30.0, 20.0, TOP), resolution=2.0, spacing=2.0), events=(CUT,))


def wall_of(surface: Surface) -> np.ndarray:
    """The triangles of the wound's walls."""
    return np.flatnonzero(surface.origin == FaceOrigin.WOUND_WALL)


def test_ten_millimetres_of_one_material_are_one_layer() -> None:
    search = layer_search(procedure().tissue, procedure().materials)
    assert search.layers.columns == 1
    assert search.layers.materials == ("skin",)
    surface = build_epochs(procedure())[0].surface
    found = search.of(surface)
    wall = wall_of(surface)
    middles = found.depth[surface.triangles[wall]].mean(axis=1)
    assert middles.max() > 6.0
    colors = search.layers.colors_at(found.column[wall], middles)
    assert len(np.unique(colors, axis=0)) == 1


def test_skin_over_fat_changes_at_its_thickness() -> None:
    layered = skin_over_fat(procedure(), 3.0)
    search = layer_search(layered.tissue, layered.materials)
    assert search.layers.materials == ("skin", "fat")
    assert search.layers.depth_from.tolist() == [0.0, 3.0]
    assert search.layers.deepest_border == 3.0
    surface = build_epochs(layered)[0].surface
    found = search.of(surface)
    at = np.flatnonzero(found.depth > 0.0)
    assert np.allclose(found.depth[at], TOP - surface.points[at, 2], atol=1e-5)
    below = search.layers.layers_at(np.zeros(3, int), np.array([2.999, 3.0, 9.0]))
    assert [search.layers.materials[k] for k in below] == ["skin", "fat", "fat"]


def test_a_region_inside_a_layered_one_has_a_column_of_its_own_and_the_last_region_counts() -> None:
    """A scar 5 mm deep right of x = 1, where a face begins, in skin over fat; and a scar that the fat comes after."""
    base = skin_over_fat(procedure(), 3.0)
    skin = np.flatnonzero(skin_faces(base.tissue))
    corners = np.split(base.tissue.face_vertex_indices, np.cumsum(base.tissue.face_vertex_counts)[:-1])
    right = [k for k in skin if base.tissue.points[corners[k], 0].mean() > 0.0]
    materials = (*base.materials, Material("scar"))
    subsets = {**base.tissue.subsets, "old": np.array(right, np.int32)}
    region = Region("old", "scar", 0.0, 5.0)
    last = replace(base.tissue, subsets=subsets, regions=(*base.tissue.regions, region))
    search = layer_search(last, materials)
    stacks = {
        column: [
            (name, float(top))
            for own, name, top in zip(
                search.layers.column, search.layers.materials, search.layers.depth_from, strict=True
            )
            if own == column
        ]
        for column in range(search.layers.columns)
    }
    assert sorted(stacks.values()) == [[("scar", 0.0), ("fat", 5.0)], [("skin", 0.0), ("fat", 3.0)]]
    surface = build_epochs(replace(base, tissue=last, materials=materials))[0].surface
    found, wall = search.of(surface), wall_of(surface)
    middles = surface.points[surface.triangles[wall]].mean(axis=1)
    names = [search.layers.materials[k] for k in search.layers.layers_at(found.column[wall], TOP - middles[:, 2])]
    for name, (x, _, z) in zip(names, middles, strict=True):
        expected = ("scar" if z > TOP - 5.0 else "fat") if x > 1.0 else ("skin" if z > TOP - 3.0 else "fat")
        assert name == expected, (x, z)
    first = replace(last, subsets={"old": subsets["old"], **base.tissue.subsets})
    other = layer_search(first, materials).layers
    assert [(name, top) for name, top in zip(other.materials, other.depth_from, strict=True)].count(("fat", 3.0)) == 2


@pytest.mark.parametrize(
    ("name", "kind"),
    [("skin", "skin"), ("fat", "fat"), ("galea", "fascia"), ("muscle", "muscle"), ("cartilage", "cartilage"),
     ("tarsus", "cartilage"), ("cheek_fat", "fat"), ("SMAS", "fascia"), ("frontalis_left", "muscle"),
     ("nasal_mucosa", "mucosa"), ("subcutaneous_fat_2", "fat"), ("Material", "other")],
)  # fmt: skip
def test_a_name_tells_what_a_material_is(name: str, kind: str) -> None:
    assert tissue_kind(Material(name)) == kind


def test_every_preset_is_of_a_known_kind_and_every_kind_has_its_own_color() -> None:
    for preset in PRESETS.values():
        assert tissue_kind(preset.material) != "other", preset.material.name
    assert tissue_kind(Material("lift", muscle_stress=300.0)) == "muscle"
    assert len(set(KIND_COLORS.values())) == len(KINDS)
