"""`lappet inspect` counts the stitches of suture runs, on the lattice that is asked for."""

from __future__ import annotations

from pathlib import Path

from lappet.designs.library_operation import flap_on_patch
from lappet.output.inspect_procedure import inspect_procedure
from lappet.usd.stage import write_procedure


def test_each_run_has_a_line_with_its_stitches_by_layer(tmp_path: Path) -> None:
    write_procedure(flap_on_patch("limberg", spacing=2.0), tmp_path / "p.usda")
    text = inspect_procedure(tmp_path / "p.usda", lattice=False)
    lines = text.split("Suture runs\n")[1].split("\n\n")[0].splitlines()
    assert [line.strip() for line in lines] == [
        "suture_donor: 6 deep, 5 dermal, 6 skin; a stitch every 3 mm",
        "suture_flap: 17 deep, 14 dermal, 17 skin; a stitch every 3 mm",
    ]
    coarse = inspect_procedure(tmp_path / "p.usda", spacing=4.0, lattice=False)
    assert "a stitch every 4.8 mm, merged from 3 mm" in coarse
