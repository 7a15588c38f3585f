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
from lappet.core.problem import Problem
from lappet.procedure import Tissue
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


def of_0_1(found: object, content: object) -> object:
    """Leave out the fields that 0.1 did not know, which have their defaults."""
    if isinstance(found, dict) and isinstance(content, dict):
        kind = getattr(lappet.procedure, str(found.get("type")), None)
        defaults = {} if kind is None else {field.name: recorded(field.default) for field in dataclasses.fields(kind)}
        for name in set(found) - set(content):
            assert found[name] == defaults[name], name
        return {name: of_0_1(found[name], content[name]) for name in found if name in content}
    if isinstance(found, list) and isinstance(content, list) and len(found) == len(content):
        return [of_0_1(each, kept) for each, kept in zip(found, content, strict=True)]
    return found


@pytest.mark.parametrize("name", ["every_event", "z_plasty"])
def test_a_procedure_of_0_1_loads_with_every_value_and_no_note(name: str) -> None:
    expected = json.loads((KEPT / f"{name}.json").read_text(encoding="utf-8"))
    notes: list[Problem] = []
    procedure = read_procedure(KEPT / f"{name}.usda", notes)
    assert notes == expected.pop("notes")
    found = recorded(procedure)
    assert isinstance(found, dict)
    assert [name for name in found if name in expected] == list(expected)
    assert procedure.skin_lines == ()
    if expected["tissue"]["gravity"] is None:  # 0.1 had none where nothing was said; now that is the default
        expected["tissue"]["gravity"] = Tissue.gravity
    for field, content in expected.items():
        assert of_0_1(found[field], content) == content, field


@pytest.mark.parametrize("name", ["every_event", "z_plasty"])
def test_a_procedure_of_0_1_is_written_again_byte_for_byte(name: str, tmp_path: Path) -> None:
    """So 0.1 can read what is written now: the same but for the gravity that is now said."""
    write_procedure(read_procedure(KEPT / f"{name}.usda"), tmp_path / "again.usda")
    before, again = (KEPT / f"{name}.usda").read_bytes(), (tmp_path / "again.usda").read_bytes()
    gravity = b"        uniform double lappet:gravity = 9.81\n"
    assert again.count(gravity) == 1
    if gravity not in before:
        again = again.replace(gravity, b"")
    assert again == before
