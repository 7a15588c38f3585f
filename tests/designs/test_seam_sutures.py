"""Runs of sutures along the seams of a design: the same stitches as one by one, in few events."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lappet.designs import Schedule, limberg
from lappet.designs.laid_design import flap_on_skin
from lappet.designs.library import DESIGNS
from lappet.designs.library_operation import flap_on_patch, schedule, technique
from lappet.designs.seam_sutures import suture_runs
from lappet.designs.technique import Technique
from lappet.designs.transposition import flap_operation
from lappet.procedure import Suture, SutureRun
from lappet.suturing import with_single_sutures
from lappet.suturing.single_sutures import skin_of

AT, ALONG = (0.0, 0.0, 4.0), (1.0, 0.0, 0.0)


@pytest.mark.parametrize("name", list(DESIGNS))
def test_runs_have_the_stitches_that_the_seams_have_one_by_one(name: str) -> None:
    procedure = flap_on_patch(name, spacing=2.0)
    design = flap_on_skin(procedure.tissue, name, AT, ALONG)
    how = technique(design, 4.0, 2.0)
    one_by_one = flap_operation(design, skin_of(procedure.tissue), schedule(design), replace(how, runs=False))
    single = [event for event in one_by_one if isinstance(event, Suture)]
    places = np.array([suture.anchors for suture in single])
    found = [event for event in with_single_sutures(procedure).events if isinstance(event, Suture)]
    assert len(found) == len(single)
    for suture in found:
        ends = np.array(suture.anchors)
        off = np.minimum(np.abs(places - ends).max(axis=(1, 2)), np.abs(places - ends[::-1]).max(axis=(1, 2)))
        assert off.min() < 0.02, suture.name  # which a curved edge's direction differs by, seen from its other end


def test_a_limberg_flap_is_sewn_with_two_runs_one_round_its_corners() -> None:
    procedure = flap_on_patch("limberg", spacing=2.0)
    runs = [event for event in procedure.events if isinstance(event, SutureRun)]
    assert [run.name for run in runs] == ["suture_donor", "suture_flap"]
    assert [len(run.corners) for run in runs] == [1, 2]
    assert [layer.name for layer in runs[0].layers] == ["deep", "dermal", "skin"]
    donor, flap = runs
    assert flap.lengths == pytest.approx((54.0, 54.0), rel=1e-3)
    assert donor.lengths == pytest.approx((18.0, 18.0), rel=1e-3)
    assert (donor.start, flap.start) == (24.0, 26.0)


def test_the_limbs_of_a_z_plasty_are_one_run() -> None:
    design = DESIGNS["z-plasty"].draw(np.zeros(3), ALONG, **DESIGNS["z-plasty"].values({}))
    (run,) = suture_runs(design, Schedule(), Technique())
    assert len(run.corners) == 2
    assert run.sides in ((1, -1), (-1, 1))
    assert run.lengths[0] == pytest.approx(sum(np.linalg.norm(np.subtract(*edge)) for edge in _limbs(design)), rel=1e-3)


def _limbs(design: object) -> list[tuple[object, object]]:
    return [(seam.edges[0].points[0], seam.edges[0].points[-1]) for seam in design.seams]  # type: ignore[attr-defined]


def test_seams_that_do_not_go_on_into_each_other_stay_runs_of_their_own() -> None:
    design = limberg((0.0, 0.0, 4.0), ALONG, 18.0)
    apart = replace(design, corners=())
    assert [run.name for run in suture_runs(apart, Schedule(), Technique())] == [
        "suture_donor",
        "suture_near",
        "suture_far",
        "suture_end",
    ]
