"""An anatomical model is cut, undermined and sewn: every frame converges and the wound closes."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from lappet.commands.cli import cli
from lappet.models.model_choice import ModelChoice
from lappet.models.new_model import new_model
from lappet.usd.stage import write_procedure


@pytest.mark.slow
@pytest.mark.parametrize(("name", "spacing", "deep"), [("hand", 1.2, False), ("chin", 2.0, False), ("ear", 1.4, True)])
def test_the_excision_of_a_model_closes(
    binary: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, spacing: float, deep: bool
) -> None:
    monkeypatch.setenv("LAPPET_SOLVERD", str(binary))
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "store"))
    file = tmp_path / f"{name}.usdc"
    write_procedure(new_model(name, ModelChoice(spacing=spacing, excision=True, deep=deep)), file)
    arguments = ["solve", str(file), "-o", str(tmp_path / "skin.usdc"), "--no-error-estimate"]
    solved = CliRunner().invoke(cli, arguments)
    assert solved.exit_code == 0, solved.output
    assert "12 frames done: 12 solved" in solved.output
    scar = next(line for line in solved.output.splitlines() if line.startswith("Scar: "))
    open_area = float(scar.partition(" mm, ")[2].partition(" mm²")[0])
    assert open_area < 2.0
