"""The unit file and the recipe of an image: what they promise is there, and the daemon takes their command lines."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
from collections import defaultdict
from pathlib import Path

import pytest

from lappet.daemon.keys_folder import KeysFolder

PACKAGING = Path(__file__).resolve().parents[2] / "packaging"
UNIT = PACKAGING / "lappet-solverd.service"
RECIPE = PACKAGING / "Containerfile"
GIB = 1 << 30
PORT = "5570"

# What SECURITY.md and docs/sharing_a_daemon.md promise of the service.
DIRECTIVES = {
    "AmbientCapabilities": "",
    "CapabilityBoundingSet": "",
    "DevicePolicy": "closed",
    "DynamicUser": "yes",
    "LimitCORE": "0",
    "LockPersonality": "yes",
    "MemoryDenyWriteExecute": "yes",
    "MemorySwapMax": "0",
    "NoNewPrivileges": "yes",
    "OOMPolicy": "continue",
    "PrivateDevices": "yes",
    "PrivateMounts": "yes",
    "PrivateTmp": "yes",
    "PrivateUsers": "yes",
    "ProcSubset": "pid",
    "ProtectClock": "yes",
    "ProtectControlGroups": "yes",
    "ProtectHome": "yes",
    "ProtectHostname": "yes",
    "ProtectKernelLogs": "yes",
    "ProtectKernelModules": "yes",
    "ProtectKernelTunables": "yes",
    "ProtectProc": "invisible",
    "ProtectSystem": "strict",
    "RemoveIPC": "yes",
    "RestrictAddressFamilies": "AF_INET AF_INET6 AF_UNIX",
    "RestrictNamespaces": "yes",
    "RestrictRealtime": "yes",
    "RestrictSUIDSGID": "yes",
    "StateDirectory": "lappet",
    "StateDirectoryMode": "0700",
    "SystemCallArchitectures": "native",
    "UMask": "0077",
}


def unit() -> dict[str, list[str]]:
    """What the section [Service] says, each directive with its values in order."""
    said: defaultdict[str, list[str]] = defaultdict(list)
    section = ""
    for line in UNIT.read_text(encoding="utf-8").splitlines():
        if line.startswith("["):
            section = line
        elif section == "[Service]" and line.strip() and not line.startswith("#"):
            name, equals, value = line.partition("=")
            assert equals, line
            said[name].append(value)
    return said


def recipe() -> list[tuple[str, str]]:
    """The instructions of the recipe and what follows them."""
    text = "\n".join(line for line in RECIPE.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    lines = [line for line in re.sub(r"\\\n\s*", "", text).splitlines() if line.strip()]
    return [(word, rest) for word, _, rest in (line.partition(" ") for line in lines)]


def instruction(name: str) -> str:
    (found,) = [rest for word, rest in recipe() if word == name]
    return found


def service_command() -> list[str]:
    (command,) = unit()["ExecStart"]
    return shlex.split(command)


def image_command() -> list[str]:
    return [*json.loads(instruction("ENTRYPOINT")), *json.loads(instruction("CMD"))]


def option(command: list[str], name: str) -> str:
    return command[command.index(name) + 1]


@pytest.mark.parametrize("name", sorted(DIRECTIVES))
def test_the_service_is_in_the_cage_that_is_promised(name: str) -> None:
    assert unit()[name] == [DIRECTIVES[name]]


def test_the_service_may_call_what_services_do_and_nothing_of_the_privileged() -> None:
    assert unit()["SystemCallFilter"] == ["@system-service", "~@privileged"]


def test_the_memory_of_the_service_holds_all_its_sessions() -> None:
    (most,) = unit()["MemoryMax"]
    assert most.endswith("G")
    command = service_command()
    sessions, message = int(option(command, "--max-sessions")), int(option(command, "--max-message-bytes"))
    budgets = sessions * (float(option(command, "--memory-gib")) * GIB + 2 * message)
    assert budgets <= float(most[:-1]) * GIB


def test_the_keys_of_the_service_are_in_the_folder_that_systemd_gives_it() -> None:
    assert option(service_command(), "--keys") == f"%S/{DIRECTIVES['StateDirectory']}/keys"


def test_the_image_is_debian_and_runs_as_a_user_without_a_name_of_power() -> None:
    bases = [rest.split()[0] for word, rest in recipe() if word == "FROM"]
    assert bases == ["docker.io/library/debian:12-slim"] * 2
    assert [word for word, _ in recipe()].index("USER") > max(
        place for place, (word, _) in enumerate(recipe()) if word in ("RUN", "COPY")
    )
    user, group = instruction("USER").split(":")
    assert int(user) > 0
    assert int(group) > 0
    # A declared volume that nobody mounts is made anew in silence, with other keys.
    assert "VOLUME" not in [word for word, _ in recipe()]
    assert option(image_command(), "--keys") == "/keys"
    assert instruction("EXPOSE") == f"{PORT}/tcp"


def test_the_image_holds_no_secret_and_nothing_but_the_wheel() -> None:
    assert not [rest for word, rest in recipe() if word in ("ENV", "ARG", "ADD")]
    copied = [rest.split() for word, rest in recipe() if word == "COPY"]
    assert copied == [["lappet-*.whl", "/wheel/"], ["--from=unpacked", "/opt/lappet", "/opt/lappet"]]
    assert "server.key" not in RECIPE.read_text(encoding="utf-8")


def test_the_recipe_says_to_run_the_image_in_a_cage() -> None:
    said = " ".join(line.lstrip("# ").rstrip("\\ ") for line in RECIPE.read_text(encoding="utf-8").splitlines()[:20])
    for part in (
        "--read-only",
        "--cap-drop ALL",
        "--security-opt no-new-privileges",
        "--memory 16g",
        "--pids-limit",
        ":/keys ",
    ):
        assert part in said


@pytest.mark.slow
@pytest.mark.parametrize("command", [service_command(), image_command()], ids=["service", "image"])
def test_the_daemon_takes_their_command_line(binary: Path, tmp_path: Path, command: list[str]) -> None:
    """On another port and with keys of the test's own; it listens, and ends well when it is told to."""
    assert Path(command[0]).name == "lappet-solverd"
    assert option(command, "--listen") == f"tcp://0.0.0.0:{PORT}"
    folder = KeysFolder(tmp_path / "keys")
    folder.make_server()
    swapped = [str(binary), *command[1:]]
    swapped[swapped.index("--keys") + 1] = str(folder.path)
    swapped[swapped.index("--listen") + 1] = "tcp://0.0.0.0:0"
    process = subprocess.Popen(
        swapped, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("listening tcp://0.0.0.0:")
        process.terminate()
        assert process.wait(10.0) == 0
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_takes_the_unit_and_finds_little_exposed(binary: Path, tmp_path: Path) -> None:
    checked = tmp_path / UNIT.name
    checked.write_text(UNIT.read_text().replace(service_command()[0], str(binary)))
    verified = subprocess.run(
        ["systemd-analyze", "verify", "--man=no", str(checked)], capture_output=True, text=True, check=False
    )
    assert (verified.returncode, verified.stdout, verified.stderr) == (0, "", "")
    # An exposure of 0 to 10; systemd calls up to 2 "ok", and a service without any of this has 9.6.
    judged = subprocess.run(
        ["systemd-analyze", "security", "--offline=yes", "--threshold=20", "--no-pager", str(checked)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert judged.returncode == 0, judged.stdout[-2000:] + judged.stderr
