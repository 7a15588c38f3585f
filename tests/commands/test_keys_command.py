"""`lappet keys`, and the three options that name a daemon and its keys."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from curve_server import CurveServer
from lappet.commands.cli import cli
from lappet.daemon.key_files import read_pair
from lappet.daemon.keys_folder import KeysFolder, Quotas, Role
from lappet.usd.stage import write_procedure
from small_procedure import small_procedure


def run(*arguments: object) -> Result:
    return CliRunner().invoke(cli, ["keys", *(str(each) for each in arguments)])


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("platformdirs.user_config_path", lambda *_, **__: tmp_path / "config" / "lappet")
    return tmp_path / "config" / "lappet"


def test_keys_are_made_allowed_listed_and_revoked(home: Path, tmp_path: Path) -> None:
    server = run("new", "--server", "--keys", tmp_path / "keys")
    assert server.exit_code == 0, server.output
    folder = KeysFolder(tmp_path / "keys")
    assert f"--listen tcp://0.0.0.0:5570 --keys {folder.path}" in server.stdout
    assert folder.server() in server.stdout
    own = run("new", "anna")
    assert own.exit_code == 0, own.output
    pair = read_pair(home / "anna.key")
    assert pair.public in own.stdout
    for result in (server, own):
        assert "secret = " not in result.output
        assert pair.secret not in result.output
    done = run(
        *("allow", "anna", "--key", home / "anna.pub", "--role", "author", "--threads", 2, "--seconds", 60),
        *("--keys", folder.path),
    )
    assert done.exit_code == 0, done.output
    users, wrong = folder.users()
    assert (users[0].role, users[0].quotas, wrong) == (Role.AUTHOR, Quotas(threads=2, seconds=60.0), [])
    listed = run("list", "--keys", folder.path)
    assert listed.exit_code == 0
    assert f"anna  {pair.public}  author, 2 threads a session, 60 s a frame" in listed.stdout
    assert run("revoke", "anna", "--keys", folder.path).exit_code == 0
    assert folder.users() == ([], [])
    assert "Nobody" in run("list", "--keys", folder.path).stdout


def test_the_command_that_starts_the_daemon_can_be_copied_whatever_the_folders_name(tmp_path: Path) -> None:
    folder = tmp_path / "keys of the clinic"
    (line,) = [line for line in run("new", "--server", "--keys", folder).stdout.splitlines() if "--listen" in line]
    assert shlex.split(line.partition(": ")[2])[1:] == ["--listen", "tcp://0.0.0.0:5570", "--keys", str(folder)]


def test_a_key_is_taken_from_the_command_line_too(home: Path, tmp_path: Path) -> None:
    run("new", "--server", "--keys", tmp_path / "keys")
    run("new", "anna")
    public = read_pair(home / "anna.key").public
    assert run("allow", "anna", "--key", public, "--role", "admin", "--keys", tmp_path / "keys").exit_code == 0
    assert KeysFolder(tmp_path / "keys").users()[0][0].public == public


def test_refusals_are_one_sentence_and_status_1(home: Path, tmp_path: Path) -> None:
    run("new", "--server", "--keys", tmp_path / "keys")
    run("new", "anna")
    for refused in (
        run("new", "anna"),
        run("new", "Anna"),
        run("allow", "anna", "--key", home / "anna.key", "--role", "author", "--keys", tmp_path / "keys"),
        run("allow", "anna", "--key", "nonsense", "--role", "author", "--keys", tmp_path / "keys"),
        run("revoke", "anna", "--keys", tmp_path / "keys"),
        run("list", "--keys", tmp_path / "nothing"),
        run("new", "--server", "ward 7\x1b[2J", "--keys", tmp_path / "others"),
    ):
        assert refused.exit_code == 1
        assert len(refused.stderr.strip().splitlines()) == 1
        assert "Traceback" not in refused.output
    assert not (tmp_path / "others").exists()


def test_a_damaged_file_is_named_and_the_status_is_1(home: Path, tmp_path: Path) -> None:
    run("new", "--server", "--keys", tmp_path / "keys")
    damaged = tmp_path / "keys" / "users" / "ben.pub"
    damaged.write_text("role = author\n")
    listed = run("list", "--keys", tmp_path / "keys")
    assert listed.exit_code == 1
    assert str(damaged) in listed.stderr


@pytest.mark.parametrize("arguments", [["new"], ["new", "--server"], ["allow", "anna", "--role", "king", "--key", "x"]])
def test_what_is_missing_on_the_command_line_is_usage(arguments: list[str]) -> None:
    assert run(*arguments).exit_code == 2


# --- --daemon, --server-key, --key ---------------------------------------------------------------------------------


@pytest.fixture
def procedure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path / "store"))
    path = tmp_path / "p.usda"
    write_procedure(small_procedure(), path)
    return path


def solve(procedure: Path, *options: object) -> Result:
    return CliRunner().invoke(cli, ["solve", str(procedure), *(str(each) for each in options)])


def test_a_daemon_elsewhere_needs_both_keys(procedure: Path, home: Path, tmp_path: Path) -> None:
    run("new", "anna")
    there = ("--daemon", "tcp://192.0.2.7:5570")
    for options, missing in (
        (there, "--server-key, --key"),
        ((*there, "--key", home / "anna.key"), "--server-key"),
        ((*there, "--server-key", home / "anna.pub"), "--key"),
    ):
        refused = solve(procedure, *options)
        assert refused.exit_code == 1
        assert missing in refused.stderr
        assert len(refused.stderr.strip().splitlines()) == 1
    assert solve(procedure, "--key", home / "anna.key").exit_code == 2


def test_solve_and_inspect_hand_the_keys_to_the_daemon(procedure: Path, home: Path, tmp_path: Path) -> None:
    """And refuse one with another key, with a sentence that says what to do."""
    run("new", "--server", "--keys", tmp_path / "keys")
    run("new", "anna")
    folder = KeysFolder(tmp_path / "keys")
    run("allow", "anna", "--key", home / "anna.pub", "--role", "author", "--keys", folder.path)
    keys = ("--server-key", folder.server_public, "--key", home / "anna.key")
    with CurveServer(read_pair(folder.server_key), folder) as server:
        solve(procedure, "--daemon", server.address, *keys, "--no-error-estimate")
        assert [message.type for message in server.messages][:2] == ["hello", "bye"]  # for its version
        assert "open" in [message.type for message in server.messages]
        assert all(not message.fields.get("token") for message in server.messages)
        asked = len(server.messages)
        run_inspect = ["inspect", procedure, "--daemon", server.address, *keys]
        CliRunner().invoke(cli, [str(each) for each in run_inspect])
        assert "open" in [message.type for message in server.messages[asked:]]
    other = KeysFolder(tmp_path / "other")
    with CurveServer(other.make_server(), folder) as stranger:
        refused = solve(procedure, "--daemon", stranger.address, *keys)
        assert stranger.messages == []
    assert refused.exit_code == 1
    assert "server.pub" in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1
