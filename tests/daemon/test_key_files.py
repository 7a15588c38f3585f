"""Keys and the folder that holds them: only whole, private, regular files count, and whatever is wrong is named."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

import pytest
import zmq

from lappet.core.problem import RefusedError
from lappet.core.problem_code import ProblemCode
from lappet.daemon.key_files import KeyPair, is_key, new_pair, read_pair, read_public
from lappet.daemon.key_writing import new_own
from lappet.daemon.keys_folder import KeysFolder, Quotas, Role, User

# From the reference implementation's tests of Z85 (https://rfc.zeromq.org/spec/32), and the same one too large.
KEY = "rq:rM>}U?@Lns47E1%kR.o@n%FcmmsL/@{H8]yf7"
TOO_LARGE = "#" * 40


@pytest.fixture
def folder(tmp_path: Path) -> KeysFolder:
    made = KeysFolder(tmp_path / "keys")
    made.make_server()
    return made


def code_of(error: pytest.ExceptionInfo[RefusedError]) -> ProblemCode:
    assert len(error.value.problems) == 1
    return error.value.problems[0].code


def test_a_fresh_pair_belongs_together_and_hides_its_secret() -> None:
    first, second = new_pair(), new_pair()
    assert first != second
    assert zmq.curve_public(first.secret.encode()).decode() == first.public
    assert is_key(first.public)
    assert is_key(first.secret)
    assert first.secret not in repr(first)


def test_only_forty_characters_of_z85_are_a_key() -> None:
    assert is_key(KEY)
    for text in (KEY[:-1], KEY + "0", KEY[:-1] + "~", KEY[:-1] + " ", TOO_LARGE, ""):
        assert not is_key(text)


def test_a_key_with_every_odd_character_comes_back_from_its_file(folder: KeysFolder) -> None:
    """A key may hold '#' and begin with '='."""
    odd = "=0#!^{}<>&*()[]@%$?/+:.-abcdefghijklmnop"
    assert is_key(odd)
    folder.allow(User("anna", odd, Role.AUTHOR))
    assert folder.users() == ([User("anna", odd, Role.AUTHOR)], [])
    assert read_public(str(folder.users_path / "anna.pub")) == odd


@pytest.mark.skipif(os.name != "posix", reason="files have no modes here")
def test_secrets_are_for_their_owner_alone(folder: KeysFolder, tmp_path: Path) -> None:
    secret, public, pair = new_own(tmp_path / "own" / "lappet", "anna")
    assert read_pair(secret) == pair
    assert read_public(str(public)) == pair.public
    modes = {path: stat.S_IMODE(path.stat().st_mode) for path in (secret, public, secret.parent)}
    assert list(modes.values()) == [0o600, 0o644, 0o700]
    assert stat.S_IMODE(folder.path.stat().st_mode) == 0o700
    assert stat.S_IMODE(folder.users_path.stat().st_mode) == 0o700
    assert stat.S_IMODE(folder.server_key.stat().st_mode) == 0o600
    assert stat.S_IMODE(folder.server_public.stat().st_mode) == 0o644
    assert sorted(each.name for each in secret.parent.iterdir()) == ["anna.key", "anna.pub"]


def test_keys_are_never_written_over(folder: KeysFolder, tmp_path: Path) -> None:
    secret, _, pair = new_own(tmp_path / "own", "anna")
    with pytest.raises(RefusedError) as error:
        new_own(tmp_path / "own", "anna")
    assert code_of(error) == ProblemCode.KEY_EXISTS
    assert read_pair(secret) == pair
    server = folder.server()
    with pytest.raises(RefusedError) as error:
        folder.make_server()
    assert code_of(error) == ProblemCode.KEY_EXISTS
    assert folder.server() == server
    assert read_public(str(folder.server_public)) == server
    assert not [each for each in (*folder.path.iterdir(), *secret.parent.iterdir()) if each.name.startswith(".")]


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("public = {public}\nsecret = {other}\n", ProblemCode.KEY_PAIR_MIXED),
        ("public = {public}\n", ProblemCode.KEY_MISSING),
        ("public = {public}\nsecret = short\n", ProblemCode.KEY_NOT_Z85),
        ("public = {public}\npublic = {public}\n", ProblemCode.KEY_FILE_TWICE),
        ("public = {public}\nrole = admin\n", ProblemCode.KEY_FILE_NAME),
        ("{public}\n", ProblemCode.KEY_FILE_LINE),
        ("#" * 5000, ProblemCode.KEY_FILE_LARGE),
        ("\udcff", ProblemCode.KEY_FILE_KIND),
    ],
)
def test_a_file_that_holds_no_pair_is_named_with_its_fault(tmp_path: Path, text: str, code: ProblemCode) -> None:
    pair, path = KeyPair("a" * 40, ""), tmp_path / "anna.key"
    said = text.replace("{public}", pair.public).replace("{other}", new_pair().secret)
    path.write_bytes(said.encode("utf-8", "surrogateescape"))
    path.chmod(0o600)
    with pytest.raises(RefusedError) as error:
        read_pair(path)
    assert code_of(error) == code
    assert str(path) in str(error.value)


def test_what_is_no_file_or_a_secret_one_is_no_public_key(tmp_path: Path) -> None:
    secret, _, _ = new_own(tmp_path / "own", "anna")
    wrong = {str(tmp_path / "nothing"): ProblemCode.KEY_UNKNOWN, str(secret): ProblemCode.KEY_IS_SECRET}
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe")
        wrong[str(tmp_path / "pipe")] = ProblemCode.KEY_FILE_KIND
    for key, code in wrong.items():
        with pytest.raises(RefusedError) as error:
            read_public(key)
        assert code_of(error) == code


# --- who may use a daemon ------------------------------------------------------------------------------------------


def test_a_user_is_let_in_changed_and_shut_out(folder: KeysFolder) -> None:
    public = new_pair().public
    quotas = Quotas(memory_gib=1.5, threads=2, sessions=3, seconds=600.0)
    assert folder.allow(User("anna", public, Role.AUTHOR, quotas)) is None
    assert folder.users() == ([User("anna", public, Role.AUTHOR, quotas)], [])
    assert folder.allow(User("anna", public, Role.FOLLOWER)) == User("anna", public, Role.AUTHOR, quotas)
    assert folder.users() == ([User("anna", public, Role.FOLLOWER)], [])
    folder.revoke("anna")
    assert folder.users() == ([], [])
    with pytest.raises(RefusedError) as error:
        folder.revoke("anna")
    assert code_of(error) == ProblemCode.USER_UNKNOWN


def test_one_key_is_one_user_s_and_one_user_has_one_key(folder: KeysFolder) -> None:
    public = new_pair().public
    folder.allow(User("anna", public, Role.AUTHOR))
    for user, code in (
        (User("ben", public, Role.AUTHOR), ProblemCode.KEY_OF_ANOTHER),
        (User("anna", new_pair().public, Role.ADMIN), ProblemCode.USER_HAS_KEY),
    ):
        with pytest.raises(RefusedError) as error:
            folder.allow(user)
        assert code_of(error) == code
    assert folder.users() == ([User("anna", public, Role.AUTHOR)], [])


@pytest.mark.parametrize("name", ["", "Anna", "anna b", "../anna", ".anna", "..", "a/b", "a" * 65, "änna", "a\n"])
def test_what_is_no_name_is_refused(folder: KeysFolder, name: str) -> None:
    for attempt in (lambda: folder.allow(User(name, KEY, Role.AUTHOR)), lambda: folder.revoke(name)):
        with pytest.raises(RefusedError) as error:
            attempt()
        assert code_of(error) == ProblemCode.USER_NAME
    assert list(folder.users_path.iterdir()) == []


@pytest.mark.parametrize(
    "quotas",
    [
        Quotas(memory_gib=0.0),
        Quotas(memory_gib=float("nan")),
        Quotas(threads=0),
        Quotas(sessions=-1),
        Quotas(seconds=2e6),
    ],
)
def test_quotas_that_the_daemon_would_refuse_are_not_written(folder: KeysFolder, quotas: Quotas) -> None:
    with pytest.raises(RefusedError) as error:
        folder.allow(User("anna", KEY, Role.AUTHOR, quotas))
    assert code_of(error) == ProblemCode.USER_QUOTA
    assert folder.users() == ([], [])


@pytest.mark.skipif(os.name != "posix", reason="files have no modes here")
def test_a_folder_that_others_may_enter_is_refused(folder: KeysFolder, tmp_path: Path) -> None:
    for path in (folder.path, folder.users_path):
        path.chmod(0o750)
        with pytest.raises(RefusedError) as error:
            folder.users()
        assert code_of(error) == ProblemCode.KEYS_FOLDER_OPEN
        path.chmod(0o700)
    (tmp_path / "link").symlink_to(folder.path)
    with pytest.raises(RefusedError) as error:
        KeysFolder(tmp_path / "link").users()
    assert code_of(error) == ProblemCode.KEYS_NO_FOLDER


def test_files_of_users_that_are_wrong_are_named_and_count_for_nobody(folder: KeysFolder, tmp_path: Path) -> None:
    folder.allow(User("anna", KEY, Role.AUTHOR))
    (folder.users_path / "ben.pub").write_text(f"public = {new_pair().public}\nrole = king\n")
    (folder.users_path / "carl.pub").write_text(f"public = {new_pair().public}\nrole = author\nthreads = many\n")
    outside = tmp_path / "outside.pub"
    outside.write_text(f"public = {new_pair().public}\nrole = admin\n")
    (folder.users_path / "dora.pub").symlink_to(outside)
    (folder.users_path / ".anna.pub.swp").write_text("left by an editor")
    users, wrong = folder.users()
    assert [user.name for user in users] == ["anna"]
    assert [each.code for each in wrong] == [ProblemCode.USER_ROLE, ProblemCode.USER_QUOTA, ProblemCode.FILE_ERROR]


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="needs root, who administers a service")
def test_what_root_writes_belongs_to_whom_the_folder_belongs(folder: KeysFolder) -> None:
    """Else a daemon with a user of its own (systemd's DynamicUser) could not read it."""
    for path in (folder.users_path, folder.server_key, folder.path):
        os.chown(path, 61184, 61184)
    folder.allow(User("anna", KEY, Role.AUTHOR))
    status = (folder.users_path / "anna.pub").stat()
    assert (status.st_uid, status.st_gid) == (61184, 61184)


def test_a_disk_that_fills_between_the_two_files_of_a_pair_leaves_neither_and_is_said_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A secret without its public key would be in the way of the next try."""
    sync, writes = os.fsync, []

    def full(handle: int) -> None:
        writes.append(handle)
        if len(writes) == 3:  # the pair, its folder, the public key
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        sync(handle)

    monkeypatch.setattr("lappet.daemon.key_writing.os.fsync", full)
    with pytest.raises(OSError, match="No space left") as told:
        new_own(tmp_path / "keys", "me")
    assert told.value.filename == str(tmp_path / "keys" / "me.pub")
    assert list((tmp_path / "keys").iterdir()) == []
    monkeypatch.undo()
    secret, public, pair = new_own(tmp_path / "keys", "me")
    assert read_pair(secret) == pair
    assert read_public(str(public)) == pair.public
