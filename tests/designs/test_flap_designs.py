"""Rhombic flaps and the dual S-plasty against the geometry that defines them, in the plane and on a sphere."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from lappet.core.problem_code import ProblemCode
from lappet.designs import Edge, FlapDesign, dual_s_plasty, dufourmentel, limberg
from lappet.tissue.dome import dome_bone, dome_scalp, draped
from lappet.tissue.skin_sheet import SkinSheet
from refusals import refuses
from surface_measures import spherical_cap


def length(edge: Edge) -> float:
    return float(np.linalg.norm(np.diff(np.array(edge.points), axis=0), axis=1).sum())


def angle(a: NDArray[np.float64], corner: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    u, v = a - corner, b - corner
    return float(np.degrees(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v))))


def corners(design: FlapDesign) -> dict[str, NDArray[np.float64]]:
    """A to F of a rhombic design, from its seams and corners."""
    seams = {seam.name: seam for seam in design.seams}
    ends = {
        "a": seams["far"].edges[1].points[-1],
        "b": seams["far"].edges[1].points[0],
        "c": seams["near"].edges[0].points[0],
        "d": seams["near"].edges[0].points[-1],
        "e": seams["end"].edges[0].points[0],
        "f": seams["end"].edges[0].points[-1],
    }
    return {name: np.array(point) for name, point in ends.items()}


@pytest.mark.parametrize("mirrored", [False, True])
def test_limbergs_flap_turned_by_60_degrees_about_its_pivot_is_the_defect(mirrored: bool) -> None:
    at = corners(limberg((3.0, -2.0, 4.0), (1.0, 2.0, 0.0), 18.0, mirrored=mirrored))
    turn = np.radians(-60.0 if mirrored else 60.0)
    matrix = np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]])
    for start, end in (("d", "b"), ("e", "a"), ("f", "d")):
        assert matrix @ (at[start] - at["c"]) + at["c"] == pytest.approx(at[end], abs=1e-9)
    for one, other in ("ab", "bc", "cd", "da", "de", "ef", "bd", "fc"):
        assert np.linalg.norm(at[one] - at[other]) == pytest.approx(18.0)
    # The first limb extends the short diagonal, the second is parallel to a side.
    assert angle(at["b"], at["d"], at["e"]) == pytest.approx(180.0)
    assert np.cross(at["f"] - at["e"], at["c"] - at["d"]) == pytest.approx(np.zeros(3), abs=1e-9)


@pytest.mark.parametrize("acute", [60.0, 66.0, 75.0, 90.0])
@pytest.mark.parametrize("mirrored", [False, True])
def test_dufourmentels_limbs_halve_the_angle_and_follow_the_long_diagonal(acute: float, mirrored: bool) -> None:
    at = corners(dufourmentel((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 17.0, acute, mirrored=mirrored))
    assert angle(at["d"], at["a"], at["b"]) == pytest.approx(acute)
    for one, other in ("ab", "bc", "cd", "da", "de", "ef"):
        assert np.linalg.norm(at[one] - at[other]) == pytest.approx(17.0)
    extended_diagonal, extended_side = 2.0 * at["d"] - at["b"], 2.0 * at["d"] - at["c"]
    assert angle(extended_diagonal, at["d"], at["e"]) == pytest.approx(angle(extended_side, at["d"], at["e"]))
    assert angle(extended_diagonal, at["d"], at["e"]) == pytest.approx(45.0 - acute / 4.0)
    assert np.cross(at["f"] - at["e"], at["c"] - at["a"]) == pytest.approx(np.zeros(3), abs=1e-9)
    assert angle(at["d"], at["e"], at["f"]) == pytest.approx(45.0 + acute / 4.0)


@pytest.mark.parametrize("mirrored", [False, True])
def test_half_a_turn_takes_one_s_flap_to_the_other(mirrored: bool) -> None:
    design = dual_s_plasty((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 30.0, 20.0, 42.0, 12.0, mirrored=mirrored)
    first, second = (np.array(curve) for curve in design.incisions)
    assert second == pytest.approx(-first, abs=1e-9)
    step = np.diff(first[1:], axis=0)
    assert np.linalg.norm(step, axis=1).sum() == pytest.approx(42.0, rel=0.01)
    # It bends one way and then the other: an S.
    heading = np.unwrap(np.arctan2(step[:, 1], step[:, 0])) * (-1.0 if mirrored else 1.0)
    least = int(heading.argmin())
    assert heading[least] - heading[0] == pytest.approx(-np.radians(130.0), abs=0.12)
    assert heading[-1] - heading[least] == pytest.approx(np.radians(50.0), abs=0.12)
    for seam in design.seams[:2]:
        assert length(seam.edges[1]) - length(seam.edges[0]) == pytest.approx(12.0, rel=0.01)
    # Half the perimeter of the ellipse (Ramanujan) is what both leading edges have; the rest is met by incisions.
    a, b = 15.0, 10.0
    half = 0.5 * np.pi * (3 * (a + b) - np.sqrt((3 * a + b) * (a + 3 * b)))
    assert [length(edge) for edge in design.seams[2].edges] == pytest.approx([half - 12.0] * 2, rel=0.01)


DESIGNS = {
    "limberg": lambda **more: limberg((0.0, 0.0, 80.0), (1.0, 0.0, 0.0), 15.0, **more),
    "dufourmentel": lambda **more: dufourmentel((0.0, 0.0, 80.0), (1.0, 0.0, 0.0), 14.0, 66.0, **more),
    "dual_s": lambda **more: dual_s_plasty((0.0, 0.0, 80.0), (1.0, 0.0, 0.0), 30.0, 20.0, 42.0, 12.0, **more),
}


@pytest.mark.parametrize("name", DESIGNS)
@pytest.mark.parametrize("mirrored", [False, True])
def test_every_edge_of_a_design_has_its_tissue_on_the_side_it_says(name: str, mirrored: bool) -> None:
    """Beside an edge, on its tissue's side, there is no defect; the two edges of a cut lie on both sides of it."""
    design = DESIGNS[name](mirrored=mirrored)
    outline = np.array(design.excised[0].outline)[:, :2]
    turn = outline - np.roll(outline, 1, axis=0)
    assert np.sum(outline[:, 0] * np.roll(outline[:, 1], -1) - outline[:, 1] * np.roll(outline[:, 0], -1)) > 0.0
    assert len(turn) > 20

    def in_defect(point: NDArray[np.float64]) -> bool:
        a = outline - point
        b = np.roll(a, -1, axis=0)
        cross, dot = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("ij,ij->i", a, b)
        return bool(abs(np.arctan2(cross, dot).sum()) > np.pi)

    on_rim = 0
    for seam in design.seams:
        for edge in seam.edges:
            points = np.array(edge.points)[:, :2]
            for p, q in pairwise(points):
                left = np.array([p[1] - q[1], q[0] - p[0]]) / np.linalg.norm(q - p) * edge.side
                middle = 0.5 * (p + q)
                assert not in_defect(middle + 0.2 * left)
                on_rim += in_defect(middle - 0.2 * left)
    assert on_rim > 20  # the other side of the defect's own rim is the defect
    for corner in design.corners:
        for spot in (corner.flap, corner.wound):
            towards = np.subtract(spot.towards, spot.point)[:2]
            assert not in_defect(np.array(spot.point)[:2] + 0.2 * towards / np.linalg.norm(towards))


@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_draped_on_a_sphere_lies_on_it_with_its_distances_from_the_pole(name: str) -> None:
    flat, curved = DESIGNS[name](), DESIGNS[name](project=draped(80.0))
    for a, b in zip(flat.incisions[0], curved.incisions[0], strict=True):
        assert np.linalg.norm(b) == pytest.approx(80.0)
        assert 80.0 * np.arccos(b[2] / 80.0) == pytest.approx(np.hypot(a[0], a[1]), abs=1e-5)
        assert np.arctan2(b[1], b[0]) == pytest.approx(np.arctan2(a[1], a[0]))


def solid_volume(points: NDArray[np.float64], counts: NDArray[np.int32], indices: NDArray[np.int32]) -> float:
    """The volume inside a mesh; asserts that every directed edge has its opposite."""
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    triangles = np.array(
        [
            [indices[s], indices[s + k], indices[s + k + 1]]
            for s, n in zip(starts, counts, strict=True)
            for k in range(1, n - 1)
        ]
    )
    edges = np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    key, back = edges[:, 0] * len(points) + edges[:, 1], edges[:, 1] * len(points) + edges[:, 0]
    assert len(np.unique(key)) == len(key)
    assert np.array_equal(np.sort(key), np.sort(back))
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_a_dome_has_the_volume_of_its_shell_and_its_bone_lies_below_it() -> None:
    tissue, bone = dome_scalp(80.0, 52.0, 5.0, resolution=2.0), dome_bone(74.9, 60.0, 6.0)

    def shell(outer: float, inner: float, half: float) -> float:
        return 2.0 / 3.0 * np.pi * (1.0 - np.cos(half)) * (outer**3 - inner**3)

    found = solid_volume(tissue.points, tissue.face_vertex_counts, tissue.face_vertex_indices)
    assert found == pytest.approx(shell(80.0, 75.0, 52.0 / 80.0), rel=0.002)
    found = solid_volume(bone.points, bone.face_vertex_counts, bone.face_vertex_indices)
    assert found == pytest.approx(shell(74.9, 68.9, 60.0 / 74.9), rel=0.01)
    assert np.linalg.norm(tissue.points, axis=1).min() > np.linalg.norm(bone.points, axis=1).max()
    starts = np.concatenate([[0], np.cumsum(tissue.face_vertex_counts)[:-1]])
    under = tissue.points[tissue.face_vertex_indices[starts[tissue.subsets["bed"][0]] :][:3]]
    assert np.linalg.norm(under, axis=1) == pytest.approx(75.0, abs=1e-3)
    # The texture keeps lengths from the pole: the triangles' edges to better than the sphere's own 1 - sin(x) / x.
    assert tissue.uv is not None
    skin = tissue.face_vertex_indices[: 3 * len(tissue.subsets["bed"])].reshape(-1, 3)
    flat = 100.0 * tissue.uv[: skin.size].reshape(-1, 3, 2)
    true = np.linalg.norm(tissue.points[skin] - tissue.points[np.roll(skin, -1, axis=1)], axis=2)
    drawn = np.linalg.norm(flat - np.roll(flat, -1, axis=1), axis=2)
    assert (drawn / true).max() < 1.005 * 0.65 / np.sin(0.65)
    assert (drawn / true).min() > 0.995


def test_a_place_beside_an_edge_of_the_skin_is_on_the_skin_and_one_below_it_is_as_deep_as_asked() -> None:
    skin = SkinSheet.of(spherical_cap(radius=60.0, rings=32))
    beside = np.array(skin.beside((0.0, 0.0, 60.0), (1.0, 0.0, 0.0), 7.0))
    assert beside[1] == pytest.approx(7.0, abs=0.1)
    assert np.linalg.norm(beside) == pytest.approx(60.0, abs=0.1)
    assert np.linalg.norm(skin.below(beside, 3.0)) == pytest.approx(57.0, abs=0.1)
    assert np.linalg.norm(np.subtract(skin.towards(beside, (0.0, 0.0, 60.0), 2.0), beside)) == pytest.approx(
        2.0, abs=0.05
    )


@pytest.mark.parametrize(
    ("draw", "code"),
    [
        (lambda: limberg((0, 0, 0), (1, 0, 0), 0.0), ProblemCode.LENGTH_NOT_POSITIVE),
        (lambda: limberg((0, 0, 0), (0, 0, 1), 10.0), ProblemCode.DESIGN_DIRECTION),
        (lambda: dufourmentel((0, 0, 0), (1, 0, 0), 10.0, 50.0), ProblemCode.DESIGN_ANGLE),
        (lambda: dual_s_plasty((0, 0, 0), (1, 0, 0), 20.0, 30.0, 40.0, 5.0), ProblemCode.DESIGN_OVAL),
        (lambda: dual_s_plasty((0, 0, 0), (1, 0, 0), 30.0, 20.0, 40.0, 35.0), ProblemCode.DESIGN_ADVANCE),
        (lambda: dual_s_plasty((0, 0, 0), (1, 0, 0), 30.0, 20.0, float("nan"), 5.0), ProblemCode.LENGTH_NOT_POSITIVE),
        (lambda: dome_scalp(80.0, 52.0, 90.0), ProblemCode.DOME_NO_CAP),
        (lambda: dome_bone(80.0, 200.0), ProblemCode.DOME_NO_CAP),
        (lambda: dome_scalp(-80.0), ProblemCode.LENGTH_NOT_POSITIVE),
    ],
)
def test_what_cannot_be_drawn_is_refused(draw, code) -> None:
    with refuses(code):
        draw()
