"""Procedures that Lappet 0.1 wrote (`kept/`) load, with the values that 0.1 itself read from them.

`every_event.usda` has every event, curve basis, material, region and bone; `z_plasty.usda` is the bundled example. The
`.json` beside each holds the values field by field, large arrays as their digests. Both were recorded with the code of
0.1 and are never written again.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

import lappet.procedure
from lappet.usd.stage import read_procedure, write_procedure

KEPT = Path(__file__).parent / "kept"


def recorded(value: object) -> object:
    """Return a value as the `.json` files hold it."""
    if isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        said = {"dtype": array.dtype.str, "shape": list(array.shape)}
        if array.size > 64:
            return {**said, "sha256": hashlib.sha256(array.tobytes()).hexdigest()}
        return {**said, "values": array.ravel().tolist()}
    if dataclasses.is_dataclass(value):
        fields = {field.name: recorded(getattr(value, field.name)) for field in dataclasses.fields(value)}
        return {"type": type(value).__name__, **fields}
    if isinstance(value, dict):
        return [[name, recorded(content)] for name, content in value.items()]
    if isinstance(value, tuple):
        return [recorded(each) for each in value]
    return value


def as_of_0_1(found: object, expected: object) -> object:
    """Leave out the fields that 0.1 did not have, which must hold their defaults."""
    if isinstance(found, dict) and isinstance(expected, dict):
        for name in found.keys() - expected.keys():
            assert found[name] == recorded(getattr(lappet.procedure, str(found["type"])).__dict__[name]), name
        return {name: as_of_0_1(value, expected[name]) for name, value in found.items() if name in expected}
    if isinstance(found, list) and isinstance(expected, list) and len(found) == len(expected):
        return [as_of_0_1(one, other) for one, other in zip(found, expected, strict=True)]
    return found


@pytest.mark.parametrize("name", ["every_event", "z_plasty"])
def test_a_procedure_of_0_1_loads_with_every_value_and_no_note(name: str) -> None:
    expected = json.loads((KEPT / f"{name}.json").read_text(encoding="utf-8"))
    notes: list[str] = []
    procedure = read_procedure(KEPT / f"{name}.usda", notes)
    assert notes == expected.pop("notes")
    found = as_of_0_1(recorded(procedure), expected)
    assert isinstance(found, dict)
    assert list(found) == list(expected)
    for field, content in expected.items():
        assert found[field] == content, field


@pytest.mark.parametrize("name", ["every_event", "z_plasty"])
def test_a_procedure_of_0_1_is_written_again_byte_for_byte(name: str, tmp_path: Path) -> None:
    """So 0.1 can read what is written now."""
    write_procedure(read_procedure(KEPT / f"{name}.usda"), tmp_path / "again.usda")
    assert (tmp_path / "again.usda").read_bytes() == (KEPT / f"{name}.usda").read_bytes()
