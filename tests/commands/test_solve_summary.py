"""What `lappet solve` says of forces and seams: each value as exactly as its error allows."""

from __future__ import annotations

from dataclasses import replace

import pytest

from lappet.commands.run_solve import force_lines, seam_lines
from lappet.core.value_with_error import with_error
from lappet.solve.force_sums import ForceSums
from lappet.solve.hook_forces import HookForce
from lappet.solve.measures import FrameMeasures
from lappet.solve.seam_measures import SeamMeasure

SUMS = ForceSums(312.34, 49.83, "stitch_1", None, (), (), total_error_mn=8.3, greatest_error_mn=0.83)
SEAM = SeamMeasure(
    7.0, "top", 30.04, 30.0, 30.0, 30.0, 30.0, 0.0, 0.2, 1.234, 1.0, 0.1, 0.246, 0.5, 0.72, 240.0, 0.008,
    scar_length_error_mm=0.052, open_area_error_mm2=0.31, step_off_error_mm=0.02, start_dog_ear_error_mm=0.1,
    end_dog_ear_error_mm=0.13, tension_error_n_per_mm=0.00071,
)  # fmt: skip


@pytest.mark.parametrize(
    ("value", "error", "said"),
    [
        (12.34, 0.83, "12.3 ± 0.8"),
        (12.34, 0.123, "12.34 ± 0.12"),
        (239.0, 40.4, "240 ± 40"),
        (1234.0, 190.0, "1230 ± 190"),
        (0.0188, 0.0021, "0.019 ± 0.002"),
        (9.97, 0.96, "10.0 ± 1.0"),
        (0.0, 5.2, "0 ± 5"),
        (12.34, None, "12.3"),
        (12.34, 0.0, "12.3"),
    ],
)
def test_a_value_has_the_digits_that_its_error_allows(value: float, error: float | None, said: str) -> None:
    assert with_error(value, error) == said


def test_the_sum_and_the_greatest_of_the_sutures_and_the_hooks_that_pull_most_are_said_with_their_errors() -> None:
    hooks = tuple(HookForce(7.0, f"hook_{k}", 10.0 * k, 0.0, 0.0, 10.0 * k, 1.5) for k in range(5))
    lines = force_lines([FrameMeasures(), FrameMeasures(sums=replace(SUMS, unresolved=("stitch_9",)), hooks=hooks)])
    assert lines == [
        "Sutures: 312 ± 8 mN in all, 49.8 ± 0.8 mN at most (stitch_1); without stitch_9, which the lattice does not "
        "resolve, in the last frame.",
        "Hooks: hook_4 40.0 ± 1.5 mN, hook_3 30.0 ± 1.5 mN, hook_2 20.0 ± 1.5 mN and 2 more, in the last frame.",
    ]
    assert force_lines([]) == force_lines([FrameMeasures()]) == []


def test_without_an_estimate_values_are_said_alone() -> None:
    bare = replace(SUMS, total_error_mn=None, greatest_error_mn=None)
    assert force_lines([FrameMeasures(sums=bare)]) == [
        "Sutures: 312 mN in all, 49.8 mN at most (stitch_1), in the last frame."
    ]


def test_seams_are_said_with_their_errors_and_the_tension_as_the_mean_over_the_scar() -> None:
    (line,) = seam_lines([replace(SEAM, time=6.0, tension_n_per_mm=0.1), SEAM])
    assert line == (
        "Scar: 30.04 ± 0.05 mm, 1.2 ± 0.3 mm² still open, step-off 0.25 ± 0.02 mm, dog-ear 0.72 ± 0.13 mm at most, "
        "closing tension 0.0080 ± 0.0007 N/mm in the mean, in the last frame."
    )
    two = [SEAM, replace(SEAM, seam="other", scar_length_mm=10.0, tension_n_per_mm=None, tension_error_n_per_mm=None)]
    (line,) = seam_lines(two)
    assert "closing tension 0.0060 ± 0.0005 N/mm" in line  # of what is drawn over all of the scar
