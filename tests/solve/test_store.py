"""The frame store keeps what it was given, or nothing."""

from __future__ import annotations

import errno
import hashlib
import multiprocessing
import os
import shutil
import stat
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lappet.core.array_codec import CodecError
from lappet.core.problem_code import ProblemCode
from lappet.core.value_codec import pack
from lappet.daemon.lattice_counts import LatticeCounts
from lappet.daemon.solved_frame import SolvedFrame
from lappet.daemon.solver_state import SolverState
from lappet.solve.store import FrameStore, default_folder

KEY = "ab" * 32


def frame(seed: int = 0, size: int = 100) -> SolvedFrame:
    rng = np.random.default_rng(seed)
    return SolvedFrame(
        float(seed),
        rng.random((size, 3)).astype(np.float32),
        suture_index=np.arange(3, dtype=np.int32),
        suture_gaps=np.array([1.0, np.nan, -0.0]),
        lattice=LatticeCounts(64, 1, 1, 0, 8, 1, 1, 0, 0, 1.0, 1000.0, 0.1),
        state=SolverState("float", np.zeros((8, 3), np.float32), *(np.zeros((0, 3)),) * 2, *(np.zeros(0),) * 2),
    )


def same(a: SolvedFrame, b: SolvedFrame) -> bool:
    return pack(a) == pack(b)


def test_a_frame_comes_back_bit_for_bit(tmp_path: Path) -> None:
    store = FrameStore(tmp_path / "not" / "yet")
    assert store.get(KEY, SolvedFrame) is None
    assert KEY not in store
    assert store.put(KEY, frame())
    assert KEY in store
    back = FrameStore(tmp_path / "not" / "yet").get(KEY, SolvedFrame)
    assert back is not None
    assert same(back, frame())
    assert all(array.flags.aligned and not array.flags.writeable for array in back.arrays().values())


@pytest.mark.parametrize("where", [0, 10, 60, 200, -1])
def test_a_flipped_bit_anywhere_makes_an_entry_absent_and_removes_it(tmp_path: Path, where: int) -> None:
    store = FrameStore(tmp_path)
    store.put(KEY, frame())
    data = bytearray(store.path(KEY).read_bytes())
    data[where] ^= 1
    store.path(KEY).write_bytes(data)
    assert store.get(KEY, SolvedFrame) is None
    assert not store.path(KEY).exists()
    assert store.put(KEY, frame())
    assert store.get(KEY, SolvedFrame) is not None


@pytest.mark.parametrize("length", [0, 7, 39, 48, 300])
def test_a_truncated_entry_is_absent(tmp_path: Path, length: int) -> None:
    store = FrameStore(tmp_path)
    store.put(KEY, frame())
    data = store.path(KEY).read_bytes()
    store.path(KEY).write_bytes(data[:length])
    assert store.get(KEY, SolvedFrame) is None


def test_the_store_keeps_to_its_limit_and_drops_what_was_unused_for_longest(tmp_path: Path) -> None:
    keys = [f"{i:02x}" * 32 for i in range(20)]
    one = 1500 * 12
    store = FrameStore(tmp_path, limit=12 * one)
    for i, key in enumerate(keys[:10]):
        store.put(key, frame(i, 1500))
        os.utime(store.path(key), (1000.0 + i, 1000.0 + i))
    assert store.get(keys[0], SolvedFrame) is not None  # used again just now
    for i, key in enumerate(keys[10:16]):
        store.put(key, frame(10 + i, 1500))
    assert store.size() <= 12 * one
    kept = [key for key in keys if key in store]
    assert keys[0] in kept
    assert keys[1] not in kept
    assert kept[1:] == keys[:16][-len(kept) + 1 :]


def test_a_frame_larger_than_the_limit_does_not_push_itself_out(tmp_path: Path) -> None:
    store = FrameStore(tmp_path, limit=1000)
    assert store.put(KEY, frame(0, 1000))
    assert store.get(KEY, SolvedFrame) is not None


def test_what_crashed_writers_left_is_removed_but_not_what_is_being_written(tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    folder = store.path(KEY).parent
    folder.mkdir(parents=True)
    (folder / ".writing-old").write_bytes(b"x")
    os.utime(folder / ".writing-old", (0.0, 0.0))
    (folder / ".writing-new").write_bytes(b"x")
    store.put(KEY, frame())
    assert not (folder / ".writing-old").exists()
    assert (folder / ".writing-new").exists()


def test_a_full_disk_is_a_sentence_and_the_store_stays_readable(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    store = FrameStore(tmp_path)
    store.put(KEY, frame())

    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("lappet.solve.store.os.fdopen", full)
    other = "cd" * 32
    assert not store.put(other, frame(1))
    assert store.trouble is not None
    assert (store.trouble.code, store.trouble.prim) == (ProblemCode.STORE_NOT_WRITABLE, str(tmp_path))
    assert store.trouble.value == os.strerror(errno.ENOSPC)
    assert other not in store
    assert store.get(KEY, SolvedFrame) is not None
    assert not list(tmp_path.rglob(".writing-*"))


def test_a_store_that_cannot_be_made_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    store = FrameStore(tmp_path / "file")
    assert store.get(KEY, SolvedFrame) is None
    assert not store.put(KEY, frame())
    assert store.trouble is not None
    assert (store.trouble.code, store.trouble.prim) == (ProblemCode.STORE_NOT_WRITABLE, str(tmp_path / "file"))


@pytest.mark.parametrize("key", ["", "../../etc/passwd", "AB" * 32, "ab", "g" * 64])
def test_what_is_no_key_is_refused(tmp_path: Path, key: str) -> None:
    with pytest.raises(ValueError, match="content key"):
        FrameStore(tmp_path).get(key, SolvedFrame)


def test_an_array_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CodecError, match="dtype <U1"):
        FrameStore(tmp_path).put(KEY, replace(frame(), strain=np.array(["a"])))


def test_a_value_of_another_class_is_absent_and_stays(tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    store.put(KEY, frame())
    assert store.get(KEY, SolverState) is None
    assert store.get(KEY, SolvedFrame) is not None


def test_what_another_wrote_is_no_frame(tmp_path: Path) -> None:
    """Whoever does not know the secret of the folder cannot make an entry, not even from true ones."""
    store, other, foreign = FrameStore(tmp_path / "own"), "cd" * 32, FrameStore(tmp_path / "foreign")
    for each in (store, foreign):
        each.put(KEY, frame(1))
        each.put(other, frame(2))
    packed = pack(frame(3))
    forged = b"LAPPET FRAMES 3\n" + hashlib.blake2b(packed, digest_size=32).digest() + packed
    for wrong in (forged, foreign.path(KEY).read_bytes(), store.path(other).read_bytes()):
        store.path(KEY).write_bytes(wrong)
        assert store.get(KEY, SolvedFrame) is None
        assert not store.path(KEY).exists()
    assert store.get(other, SolvedFrame) is not None
    assert foreign.copy(KEY, store)
    assert store.get(KEY, SolvedFrame) is not None


posix = pytest.mark.skipif(os.name != "posix", reason="files have no owners and modes here")


@posix
def test_only_regular_files_of_the_users_own_are_read_and_the_rest_is_removed(tmp_path: Path) -> None:
    store = FrameStore(tmp_path / "store")
    store.put(KEY, frame())
    path, aside = store.path(KEY), tmp_path / "aside"
    path.replace(aside)

    def is_absent() -> bool:
        begun = time.monotonic()
        absent = KEY not in store and store.get(KEY, SolvedFrame) is None and not os.path.lexists(path)
        return absent and time.monotonic() - begun < 5.0

    os.mkfifo(path)
    assert is_absent(), "a pipe holds up whoever opens it"
    path.symlink_to(aside)
    assert is_absent()
    assert aside.is_file()
    shutil.copyfile(aside, path)
    path.chmod(0o622)
    assert is_absent(), "others could have written it"
    assert store.put(KEY, frame())
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@posix
@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="nothing lists the open files here")
def test_a_folder_in_the_place_of_a_frame_is_none_and_leaves_nothing_open(tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    store.put(KEY, frame())
    store.path(KEY).unlink()
    store.path(KEY).mkdir()
    before = len(list(Path("/proc/self/fd").iterdir()))
    assert [store.get(KEY, SolvedFrame) for _ in range(3)] == [None] * 3
    assert len(list(Path("/proc/self/fd").iterdir())) == before


@posix
def test_a_linked_folder_is_not_the_stores(tmp_path: Path) -> None:
    """Pruning used to follow the link and remove what another program keeps there."""
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    precious = elsewhere / f"{KEY}.frame"
    precious.write_bytes(bytes(50_000))
    (elsewhere / ".writing-old").write_bytes(b"x")
    os.utime(elsewhere / ".writing-old", (0.0, 0.0))
    store = FrameStore(tmp_path / "store", limit=10_000)
    assert store.put("cd" * 32, frame())
    store.path(KEY).parent.symlink_to(elsewhere, target_is_directory=True)
    for i in range(3):
        assert store.put(f"{i:02x}" * 32, frame(i))
    assert sorted(each.name for each in elsewhere.iterdir()) == [".writing-old", precious.name]
    assert KEY not in store
    assert store.put(KEY, frame())
    assert not store.path(KEY).parent.is_symlink()
    assert precious.stat().st_size == 50_000


@posix
def test_the_secret_is_the_users_alone(tmp_path: Path) -> None:
    store = FrameStore(tmp_path)
    tmp_path.chmod(0o777)
    store.put(KEY, frame())
    assert stat.S_IMODE(tmp_path.stat().st_mode) == 0o755, "others may write no longer"
    secret = tmp_path / "secret"
    assert stat.S_IMODE(secret.stat().st_mode) == 0o600
    known = secret.read_bytes()
    secret.chmod(0o644)
    assert FrameStore(tmp_path).get(KEY, SolvedFrame) is None, "what others could read proves nothing"
    assert secret.read_bytes() != known
    assert stat.S_IMODE(secret.stat().st_mode) == 0o600


@posix
def test_a_folder_of_another_user_is_no_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    FrameStore(tmp_path).put(KEY, frame())
    monkeypatch.setattr("lappet.solve.own_files.os.geteuid", lambda: os.getuid() + 1)
    store = FrameStore(tmp_path)
    assert store.get(KEY, SolvedFrame) is None
    assert not store.put(KEY, frame())
    assert store.trouble is not None
    assert store.trouble.value == "the folder belongs to another user"


def test_the_folder_is_the_users_unless_it_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("LAPPET_STORE", str(tmp_path))
    assert default_folder() == tmp_path
    monkeypatch.delenv("LAPPET_STORE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert default_folder() == tmp_path / "cache" / "lappet" / "frames"


def _hammer(folder: str, seed: int) -> int:
    """Writes and reads the same few keys as others do, in a store that is always too small; counts wrong answers."""
    store = FrameStore(Path(folder), limit=40_000)
    rng = np.random.default_rng(seed)
    wrong = 0
    for _ in range(150):
        i = int(rng.integers(0, 6))
        key = f"{i:02x}" * 32
        if not store.put(key, frame(i, 800)):
            wrong += 1
        j = int(rng.integers(0, 6))
        found = store.get(f"{j:02x}" * 32, SolvedFrame)
        if found is not None and not same(found, frame(j, 800)):
            wrong += 1
    return wrong


def test_processes_that_share_a_store_never_see_half_a_frame(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    with context.Pool(2) as pool:
        assert pool.starmap(_hammer, [(str(tmp_path), seed) for seed in range(3)]) == [0, 0, 0]
