"""`lappet doctor` and `lappet completion`, as a user and as a shell see them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from command_runs import run
from lappet.commands import completion_command
from lappet.commands.cli import cli
from lappet.installation import Finding


@pytest.fixture
def findings(monkeypatch: pytest.MonkeyPatch) -> list[Finding]:
    """What the checks find."""
    found = [Finding("packages", "ok", "numpy 1.26"), Finding("extra plates", "missing", "typst", "pip install it")]
    monkeypatch.setattr("lappet.installation.packages.check_packages", lambda: found)
    monkeypatch.setattr("lappet.installation.places.check_places", list)
    monkeypatch.setattr("lappet.installation.solver.check_solver", list)
    return found


def test_a_missing_extra_is_told_with_its_remedy_and_is_no_fault(findings: list[Finding]) -> None:
    told = run("doctor")
    assert told.exit_code == 0
    assert "missing extra plates" in " ".join(told.output.split())
    assert "-> pip install it" in told.output


def test_what_is_broken_makes_the_exit_status_1(findings: list[Finding]) -> None:
    findings.append(Finding("daemon", "broken", "it is not there", "install it"))
    assert run("doctor").exit_code == 1


def test_everything_is_there_as_json(findings: list[Finding]) -> None:
    told = json.loads(run("doctor", "--json").output)
    assert set(told) == {"lappet", "machine", "findings"}
    assert told["findings"][1] == {
        "name": "extra plates",
        "state": "missing",
        "value": "typst",
        "remedy": "pip install it",
    }


def completed(kind: str, **environment: str) -> list[str]:
    """What the program answers to a shell that completes."""
    told = {**os.environ, completion_command.VARIABLE: f"{kind}_complete", **environment}
    answer = subprocess.run([sys.executable, "-m", "lappet"], env=told, capture_output=True, text=True, check=True)
    return answer.stdout.splitlines()


@pytest.mark.parametrize("shell", completion_command.SHELLS)
def test_every_shell_gets_a_script_of_its_own_that_asks_lappet(shell: str) -> None:
    told = run("completion", shell)
    assert told.exit_code == 0
    assert f"{shell}_complete" in told.output
    assert completion_command.VARIABLE in told.output


def test_commands_options_and_values_are_completed() -> None:
    assert completed("bash", COMP_WORDS="lappet so", COMP_CWORD="1") == ["plain,solve"]
    assert completed("bash", COMP_WORDS="lappet render --view ", COMP_CWORD="3") == [
        "plain,oblique",
        "plain,top",
        "plain,low",
    ]
    assert completed("fish", COMP_WORDS="lappet compl", COMP_CWORD="compl")[0].startswith("plain,completion")


def test_powershell_gets_a_line_for_each_with_its_help() -> None:
    line = completed("powershell", COMP_LINE="lappet doct", COMP_WORD="doct")
    assert line == [f"doctor\t{cli.commands['doctor'].get_short_help_str()}"]
    assert completed("powershell", COMP_LINE="lappet completion ", COMP_WORD="") == list(completion_command.SHELLS)
    assert completed("powershell", COMP_LINE="lappet report stability --only many", COMP_WORD="many") == ["'many cuts'"]


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_bash_itself_completes_with_the_script(tmp_path: Path) -> None:
    program = tmp_path / "lappet"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m lappet "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    words = """
    eval "$(lappet completion bash)"
    COMP_WORDS=(lappet doct) COMP_CWORD=1
    _lappet_completion lappet doct lappet
    echo "${COMPREPLY[@]}"
    COMPREPLY=() COMP_WORDS=(lappet report stability --only many) COMP_CWORD=4
    _lappet_completion lappet many --only
    echo "${COMPREPLY[@]}"
    """
    path = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    said = subprocess.run(["bash", "-c", words], capture_output=True, text=True, check=True, env=path)
    assert said.stdout.splitlines() == ["doctor", "many\\ cuts"]


@pytest.mark.skipif(shutil.which("fish") is None, reason="there is no fish")
def test_fish_itself_completes_with_the_script(tmp_path: Path) -> None:
    program = tmp_path / "lappet"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m lappet "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    words = "lappet completion fish | source; complete -C 'lappet models new web'"
    path = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}"}
    said = subprocess.run(["fish", "--no-config", "-c", words], capture_output=True, text=True, check=True, env=path)
    assert said.stdout.split() == ["web-space"]
