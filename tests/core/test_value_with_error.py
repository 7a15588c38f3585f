"""Values are written as exactly as their errors allow, and as people read them."""

from __future__ import annotations

import pytest

from lappet.core.value_with_error import with_error


@pytest.mark.parametrize(
    ("value", "error", "written"),
    [
        (2514.0, 290.0, "2500 ± 300"),
        (149.2, 11.3, "149 ± 11"),
        (0.0432, 0.0051, "0.043 ± 0.005"),
        (2725.43, None, "2730"),
        (999.6, None, "1000"),
        (-1234567.0, None, "-1230000"),
        (123.4, None, "123"),
        (0.004321, None, "0.00432"),
        (0.0, 0.0, "0"),
    ],
)
def test_a_value_has_the_digits_that_its_error_leaves_and_three_where_none_is_known(
    value: float, error: float | None, written: str
) -> None:
    assert with_error(value, error) == written
