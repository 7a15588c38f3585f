"""Any place of a face can be thickened: the MakeHuman base mesh (CC0) in the models' package, where that is fetched.

The mesh has eyelids, nostrils, lips that touch, a mouth inside and ears; it is made of quads and is in decimeters.
"""

from __future__ import annotations

from zipfile import ZipFile

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.geometry.injective_layout import signed_areas
from lappet.geometry.segment_hits import first_hits
from lappet.geometry.surface_check import first_intersection, signed_volume
from lappet.models.body_package import body_package, is_fetched
from lappet.tissue import Disc, tissue_of_mesh
from lappet.tissue.mesh_file import Mesh

pytestmark = [pytest.mark.slow, pytest.mark.timeout(900)]

SITES, RADIUS, THICKNESS = 81, 20.0, 4.0


def head_text() -> str:
    if not is_fetched():
        pytest.skip("the models' package is not there: lappet models fetch")
    with ZipFile(body_package()) as package:
        (name,) = [name for name in package.namelist() if name.endswith("3dobjs/base.obj")]
        return package.read(name).decode("utf-8")


@pytest.fixture(scope="module")
def head() -> Mesh:
    """The head of the group "body", in mm, the face looking along -y, z up."""
    points, faces, group = [], [], ""
    for line in head_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            points.append([float(word) for word in words[1:4]])
        elif words[:1] == ["g"]:
            group = words[1]
        elif words[:1] == ["f"] and group == "body":
            a, b, c, d = (int(word.split("/")[0]) - 1 for word in words[1:])
            faces += [[a, b, c], [a, c, d]]
    place = 100.0 * np.array(points)[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    triangles = np.array(faces)
    top = place[np.unique(triangles), 2].max()
    return Mesh(place, triangles[(place[triangles][:, :, 2] > top - 300.0).all(axis=1)])


def sites(head: Mesh) -> NDArray[np.float64]:
    """Points of the face that are seen from its front, spread by taking the one farthest from all before."""
    used = head.points[np.unique(head.triangles)]
    front = [0.0, -1.0, 0.0] * np.ones((len(used), 1))
    seen = np.isinf(first_hits(used + 0.5 * front, used + 300.0 * front, head.points, head.triangles).fraction)
    face = used[seen & (used[:, 2] > used[:, 2].max() - 240.0)]
    chosen = [int(face[:, 1].argmin())]
    away = np.full(len(face), np.inf)
    while len(chosen) < SITES:
        away = np.minimum(away, np.linalg.norm(face - face[chosen[-1]], axis=1))
        chosen.append(int(away.argmax()))
    return face[chosen]


def test_every_place_of_the_face_can_be_thickened_and_its_grid_is_whole(head: Mesh) -> None:
    for site in sites(head):
        tissue, _ = tissue_of_mesh(head, THICKNESS, Disc(tuple(site), RADIUS))
        triangles = tissue.face_vertex_indices.reshape(-1, 3).astype(np.int64)
        assert signed_volume(tissue.points, triangles) > 0.0, site
        assert first_intersection(tissue.points, triangles) is None, site
        skin = np.ones(len(triangles), bool)
        skin[np.concatenate([*tissue.subsets.values()])] = False
        corners = tissue.uv.reshape(-1, 3, 2)[skin].astype(np.float64)
        flat = corners.reshape(-1, 2)
        assert signed_areas(flat, np.arange(len(flat)).reshape(-1, 3)).min() > 0.0, site
