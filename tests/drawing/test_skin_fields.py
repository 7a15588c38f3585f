"""Normals of the skin and the edge of a wound."""

from __future__ import annotations

import numpy as np
import pytest

import synthetic_skin_cache as synthetic
from lappet.drawing.skin_fields import SKIN, border_chains, vertex_normals

UP = np.array([0.0, 0.0, 1.0])


def test_normals_of_the_flat_skin_point_up() -> None:
    rest, triangles, origin = synthetic.patch(4.0, False)
    normals = vertex_normals(rest.astype(np.float32), triangles, origin, SKIN)
    np.testing.assert_allclose(normals[np.unique(triangles[origin == SKIN])], np.tile(UP, (546, 1)), atol=1e-6)


def test_the_edge_of_a_slit_is_one_closed_chain_of_its_two_lips() -> None:
    rest, triangles, origin = synthetic.patch(2.0, True)
    chains = border_chains(triangles, origin)
    assert sum(len(c) - 1 for c in chains) == 40  # 20 edges a lip
    points = np.concatenate([rest[c] for c in chains])
    np.testing.assert_allclose(points[:, 1:], 0.0, atol=1e-6)
    assert np.abs(points[:, 0]).max() == pytest.approx(synthetic.HALF_SLIT)
    for chain in chains:
        assert (np.linalg.norm(np.diff(rest[chain], axis=0), axis=1) < 2.001).all()
    whole, faces, label = synthetic.patch(2.0, False)
    assert border_chains(faces, label) == []
    assert len(whole)
