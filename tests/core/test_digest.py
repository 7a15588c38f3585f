"""Digests are equal for equal values and for no others."""

from __future__ import annotations

import numpy as np
import pytest

from lappet.core.digest import SIZE, digest
from lappet.procedure import Hook, Suture
from small_procedure import small_procedure


def test_equal_values_have_one_digest() -> None:
    ones = np.ones((2, 3))
    for one, other in (
        (1, 1.0),
        (0.0, -0.0),
        (np.float32(0.5), 0.5),
        ([1, "a"], (1, "a")),
        (ones, np.asfortranarray(ones)),
        (ones, ones.astype(">f8")),
        (np.array([0.0]), np.array([-0.0])),
    ):
        assert digest(one) == digest(other)
    assert len(digest()) == SIZE


def test_other_values_have_other_digests() -> None:
    hook = Hook("it", (0.0, 0.0, 0.0), (), 1.0, 2.0)
    values = [
        None, 0, 1, "", "1", b"1", (), (1,), ((1,),), {}, {"a": 1}, {"a": 2}, ("ab", "c"), ("a", "bc"),
        np.ones(6), np.ones((2, 3)), np.ones((3, 2)), np.ones(6, np.float32), np.ones(6, np.int32),
        hook, Hook("it", (0.0, 0.0, 1.0), (), 1.0, 2.0), Suture("it", ((0.0,) * 3, (1.0,) * 3), 1.0),
    ]  # fmt: skip
    assert len({digest(value) for value in values}) == len(values)
    assert digest("a", "b") != digest("ab") != digest(("a", "b"))


def test_what_is_remembered_has_the_digest_of_its_values() -> None:
    one, other = small_procedure().tissue, small_procedure().tissue
    first = digest(one, remember=(type(one),))
    assert digest(one, remember=(type(one),)) == first
    assert digest(other, remember=(type(one),)) == first


def test_what_has_no_digest_is_refused() -> None:
    with pytest.raises(TypeError, match="a object has no digest"):
        digest((1, object()))
