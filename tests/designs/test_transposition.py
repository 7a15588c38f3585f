"""The events of a flap's operation: where hooks go, what the line of undermining surrounds, how sutures lie."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.designs import Row, Schedule, Technique, flap_operation, limberg
from lappet.designs.transposition import outline
from lappet.procedure import Hook, Landmark, Suture, Undermine
from lappet.tissue.dome import dome_scalp, draped
from lappet.tissue.patch import flat_patch
from lappet.tissue.skin_sheet import SkinSheet

HOW = Technique(beyond=10.0, apart=2.6, rows=(Row("deep", 3.0), Row("dermal", 1.0, 0.5), Row("skin", 0.0)))
SIDE = 12.0


@pytest.fixture(params=["flat", "dome"])
def scene(request: pytest.FixtureRequest):
    if request.param == "flat":
        skin = SkinSheet.of(flat_patch((80.0, 80.0, 4.0)))
        return skin, limberg((0.0, 0.0, 4.0), (1.0, 0.0, 0.0), SIDE)
    skin = SkinSheet.of(dome_scalp(90.0, 48.0, 6.0))
    return skin, limberg((0.0, 0.0, 90.0), (1.0, 0.0, 0.0), SIDE, project=draped(90.0))


def test_a_hook_starts_at_the_flap_rises_and_ends_where_the_corner_belongs(scene) -> None:
    skin, design = scene
    when = Schedule()
    hooks = [event for event in flap_operation(design, skin, when, HOW) if isinstance(event, Hook)]
    assert [hook.name for hook in hooks] == ["hook_tip", "hook_shoulder"]
    for hook, carry in zip(hooks, design.carries, strict=True):
        assert (hook.targets[0][0], hook.targets[-1][0], hook.release) == (when.lift, when.carried, when.let_go)
        path = np.array([target for _, target in hook.targets])
        assert np.linalg.norm(np.subtract(hook.anchor, carry.corner.point)) == pytest.approx(HOW.inside, abs=0.05)
        assert path[0] == pytest.approx(np.array(hook.anchor), abs=1e-3)
        heights = skin.surface.query(path)[2]
        assert heights.max() == pytest.approx(HOW.height, rel=0.02)
        assert heights[-1] < 0.05 * HOW.height
        assert np.linalg.norm(path[-1] - carry.lay.point) == pytest.approx(HOW.inside, abs=0.35)
        # Limberg's flap turns rigidly, so the hook keeps its distance from the pivot along the skin.
        away = np.linalg.norm(skin.place(path) - carry.pivot, axis=1)
        assert away == pytest.approx(np.full(len(away), away[0]), rel=0.1)


def test_the_skin_is_undermined_as_far_beyond_every_cut_as_asked(scene) -> None:
    skin, design = scene
    line = np.array(outline(design, skin, 10.0))
    cuts = np.array([*design.excised[0].outline, *design.incisions[0]])
    nearest = np.linalg.norm(line[None] - cuts[:, None], axis=2).min(axis=0)
    assert nearest.min() > 9.5  # nowhere nearer to a cut
    assert nearest.max() < 10.0 + SIDE  # nor much farther: the line is convex
    drawn = next(event for event in flap_operation(design, skin, Schedule(), HOW) if isinstance(event, Undermine))
    assert np.array(drawn.points) == pytest.approx(line, abs=1e-5)


def test_sutures_start_on_both_walls_of_a_cut_at_the_depth_of_their_row_and_keep_apart(scene) -> None:
    skin, design = scene
    when = Schedule()
    sutures = [event for event in flap_operation(design, skin, when, HOW) if isinstance(event, Suture)]
    edges = np.array([point for seam in design.seams for edge in seam.edges for point in edge.points])
    for row in HOW.rows:
        own = [suture for suture in sutures if suture.name.startswith(f"{row.name}_")]
        assert len(own) >= 4 * 3 + 3
        for suture in own:
            for anchor in suture.anchors:
                assert skin.surface.query([anchor])[2][0] == pytest.approx(row.depth, abs=0.01)
                on_skin = skin.place([anchor])[0]
                assert np.linalg.norm(edges - on_skin, axis=1).min() < 0.8  # the edges' points are 1.5 mm apart
        anchors = np.array([suture.anchors for suture in own])
        for k in range(len(own)):
            both = np.linalg.norm(anchors - anchors[k], axis=2).max(axis=1)
            both[k] = np.inf
            assert both.min() > 1.9
    assert all(suture.start == when.donor_from for suture in sutures if "donor" in suture.name)
    assert all(suture.start + suture.duration <= when.end for suture in sutures)
    assert len({suture.name for suture in sutures}) == len(sutures)


def test_landmarks_come_in_pairs_along_both_edges_of_every_seam(scene) -> None:
    skin, design = scene
    marks = {
        event.label: event for event in flap_operation(design, skin, Schedule(), HOW) if isinstance(event, Landmark)
    }
    for seam in design.seams:
        one, other = marks[f"{seam.name} flap edge"].points, marks[f"{seam.name} wound edge"].points
        assert len(one) == len(other) == round(SIDE / HOW.follow)
    for corner in design.corners:
        assert len(marks[f"{corner.name} flap"].points) == len(marks[f"{corner.name} wound"].points) == 1
