"""What is to be known of solved frames is told after the last one, and again when they are found in the store."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from background_owner import SETTINGS, owner
from lappet.background.worker_events import Assessed
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Hook, Procedure, Suture
from small_procedure import TOP, small_procedure

ESTIMATED = replace(SETTINGS, correction=True)


def test_errors_are_estimated_where_that_is_wanted_and_told_again_from_the_store(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        plain = own.solver.solve(small_procedure(), SETTINGS)
        own.finished(plain)
        assert [each.assessment.errors for each in own.of(Assessed, plain)] == [()]
        job = own.solver.solve(small_procedure(), ESTIMATED)
        assert own.finished(job).frames == 8
        (told,) = own.of(Assessed, job)
        assert len(own.frames(job)) == 8, "each once"
        assert len(told.assessment.errors) == 8
        assert all(error is not None and error.greatest >= 0.0 for error in told.assessment.errors)
    with owner(tmp_path) as own:
        again = own.solver.solve(small_procedure(), ESTIMATED)
        own.finished(again)
        (known,) = own.of(Assessed, again)
        assert known.assessment == told.assessment


def test_what_hooks_and_sutures_pull_with_is_told_frame_by_frame_with_its_error(tmp_path: Path, binary: Path) -> None:
    with owner(tmp_path) as own:
        job = own.solver.solve(small_procedure(), ESTIMATED)
        own.finished(job)
        (told,) = own.of(Assessed, job)
        plain = own.solver.solve(small_procedure(), SETTINGS)
        own.finished(plain)
        (bare,) = own.of(Assessed, plain)
    acting = [{each.event for each in pulls} for pulls in told.assessment.pulls]
    assert acting == [set(), set(), set(), {"hook"}, *([{"hook", "stitch"}] * 2), *([{"stitch"}] * 2)]
    pulls = told.assessment.pulls[5]
    assert all(each.error_mn is not None and 0.0 < each.error_mn <= each.force_mn for each in pulls)
    assert [[(each.event, each.force_mn) for each in own] for own in bare.assessment.pulls] == [
        [(each.event, each.force_mn) for each in own] for own in told.assessment.pulls
    ]
    assert {each.error_mn for own in bare.assessment.pulls for each in own} == {None}


def test_a_pull_that_the_lattice_does_not_resolve_is_a_warning_with_its_place(tmp_path: Path, binary: Path) -> None:
    pull = Hook("hook", (0.0, 2.0, TOP), ((4.0, (0.0, 2.0, TOP)), (5.0, (0.0, 2.0, 24.0))), 4.0, 7.0)
    events = (*(event for event in small_procedure().events if not isinstance(event, Hook)), pull)
    coarse = small_procedure(events=events, tissue=replace(small_procedure().tissue, spacing=2.0))
    with owner(tmp_path) as own:
        job = own.solver.solve(coarse, ESTIMATED, 5)
        assert own.finished(job).frames == 5
        assert ProblemCode.HOOK_TARGET_FAR in [each.code for each in own.manifest(job).manifest.notes]
        (told,) = own.of(Assessed, job)
    doubted = [each for each in told.assessment.notes if each.code == ProblemCode.ERROR_LARGE]
    assert [each.prim for each in doubted] == ["Frame 5"]
    assert doubted[0].place is not None


def with_limit(pull_through: float) -> Procedure:
    sewn = Suture("stitch", ((2.0, -1.0, TOP), (2.0, 1.0, TOP)), 5.0, 2.0, pull_through=pull_through)
    return small_procedure(events=(*(e for e in small_procedure().events if not isinstance(e, Suture)), sewn))


def test_a_suture_that_may_cut_through_is_warned_of_also_where_only_its_limit_has_changed(
    tmp_path: Path, binary: Path
) -> None:
    """The frames' keys do not know the limit: what is kept with the frames must."""
    with owner(tmp_path) as own:
        codes = {}
        for limit in (1e6, 1e-3, 1e6):
            job = own.solver.solve(with_limit(limit), SETTINGS)
            own.finished(job)
            (told,) = own.of(Assessed, job)
            codes.setdefault(limit, []).append([each.code for each in told.assessment.notes])
            if limit == 1e-3:
                (warning,) = (e for e in told.assessment.notes if e.code == ProblemCode.SUTURE_PULLS_THROUGH)
                assert (warning.prim, warning.severity) == ("/Procedure/Timeline/stitch", "warning")
                assert warning.place is not None
        assert ProblemCode.SUTURE_PULLS_THROUGH in codes[1e-3][0]
        assert all(ProblemCode.SUTURE_PULLS_THROUGH not in each for each in codes[1e6])
