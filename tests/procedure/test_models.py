"""The names of material models are listed once in Python, and the daemon's registry has the same ones."""

from __future__ import annotations

import re
from pathlib import Path

from lappet.procedure import MODELS

ROOT = Path(__file__).resolve().parents[2]
# The list itself, what Blender's menu says of each model, and cases that expect other outcomes of each.
LISTS = {
    "shared/lappet/procedure/tissue.py",
    "addon/lappet_blender/model/procedure_properties.py",
    "shared/lappet/reports/stability/deformation_cases.py",
}


def test_the_daemon_has_a_header_for_every_model_that_procedures_may_name() -> None:
    folder = ROOT / "solverd/src/force/materials"
    named = [re.findall(r'kName = "(\w+)"', file.read_text(encoding="utf-8")) for file in folder.glob("*.h")]
    assert sorted(name for names in named for name in names) == sorted(MODELS)


def test_no_other_file_of_the_product_lists_the_models() -> None:
    sources = [
        file
        for folder in ("shared", "addon", "solverd/src")
        for suffix in ("py", "usda", "h", "cpp")
        for file in (ROOT / folder).rglob(f"*.{suffix}")
    ]
    assert len(sources) > 100
    listing = {
        file.relative_to(ROOT).as_posix()
        for file in sources
        if all(f'"{name}"' in file.read_text(encoding="utf-8") for name in MODELS)
    }
    assert listing <= LISTS
