"""Key pairs and the files that hold them: lines `name = value`, `#` comments (PROTOCOL.md, "Keys").

Keys are CURVE keys in Z85, 40 characters. A file is written whole or not at all, and never over another.
"""

from __future__ import annotations

import contextlib
import os
import re
import stat
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lappet.core.durable import sync_folder
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

NAME = re.compile(r"[a-z0-9_-][a-z0-9._-]{0,63}")
MAX_BYTES = 4096
SECRET, OPEN = 0o600, 0o644
_Z85 = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#"
_Z85_VALUES = {each: value for value, each in enumerate(_Z85)}
_KEY_LENGTH = 40
_READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


@dataclass(frozen=True)
class KeyPair:
    """A CURVE key pair.

    Parameters
    ----------
    public
        The key that others may know, Z85.
    secret
        The key that nobody else may know, Z85.
    """

    public: str
    secret: str = field(repr=False)


def new_pair() -> KeyPair:
    """Make a fresh key pair.

    Returns
    -------
    KeyPair
        The pair.
    """
    import zmq

    public, secret = zmq.curve_keypair()
    return KeyPair(public.decode("ascii"), secret.decode("ascii"))


def is_key(text: str) -> bool:
    """Tell whether a text is a CURVE key in Z85.

    Parameters
    ----------
    text
        The text.

    Returns
    -------
    bool
        Whether it is.
    """
    if len(text) != _KEY_LENGTH or any(each not in _Z85_VALUES for each in text):
        return False
    for start in range(0, _KEY_LENGTH, 5):
        value = 0
        for each in text[start : start + 5]:
            value = value * len(_Z85) + _Z85_VALUES[each]
        if value >= 1 << 32:
            return False
    return True


def default_folder() -> Path:
    """Find the folder of the user's own keys.

    Returns
    -------
    Path
        The folder; it need not be there.
    """
    import platformdirs

    return platformdirs.user_config_path("lappet", appauthor=False)


def read_entries(path: Path, known: tuple[str, ...], *, secret: bool = False, links: bool = True) -> dict[str, str]:
    """Read the lines of a file of keys.

    Parameters
    ----------
    path
        The file.
    known
        The names that it may have.
    secret
        Whether nobody but its owner may read it.
    links
        Whether it may be a link to a file.

    Returns
    -------
    dict[str, str]
        The values by name.

    Raises
    ------
    RefusedError
        If it is no such file, too large, open to others where it must not be, or has another line.
    OSError
        If it cannot be read.
    """
    entries: dict[str, str] = {}
    for number, line in enumerate(_text(path, secret, links).split("\n"), 1):
        name, equals, value = (each.strip(" \t\r") for each in line.partition("="))
        if not line.strip() or line.lstrip().startswith("#"):  # only there: a key may hold '#' and '='
            continue
        place = f"{path}, line {number}"
        if not equals:
            raise refused(ProblemCode.KEY_FILE_LINE, place, line.strip()[:60])
        if name not in known:
            raise refused(ProblemCode.KEY_FILE_NAME, place, name[:60], known=", ".join(known))
        if name in entries:
            raise refused(ProblemCode.KEY_FILE_TWICE, place, name)
        entries[name] = value
    return entries


def key_in(entries: Mapping[str, str], name: str, path: Path) -> str:
    """Take a key that a file must hold.

    Parameters
    ----------
    entries
        What the file holds.
    name
        Name of the key.
    path
        The file, for messages.

    Returns
    -------
    str
        The key, Z85.

    Raises
    ------
    RefusedError
        If it is missing or no key.
    """
    if name not in entries:
        raise refused(ProblemCode.KEY_MISSING, path, name)
    if not is_key(entries[name]):
        raise refused(ProblemCode.KEY_NOT_Z85, path, name)
    return entries[name]


def new_own(folder: Path, name: str) -> tuple[Path, Path, KeyPair]:
    """Make a user's own pair, and the files that hold it and its public key.

    Parameters
    ----------
    folder
        Folder for them; made where there is none.
    name
        The user's name.

    Returns
    -------
    tuple[Path, Path, KeyPair]
        File of the pair, file of the public key, and the pair.

    Raises
    ------
    RefusedError
        If the name is none, there are keys of that name, or others may enter the folder.
    OSError
        If the file system refuses.
    """
    require_name(name)
    private_folder(folder)
    secret, public, pair = folder / f"{name}.key", folder / f"{name}.pub", new_pair()
    write_new(secret, pair_text(pair, f"The key of {name}. Nobody else may read it."), SECRET)
    write_over(public, public_text(pair.public, f"The public key of {name}: for whoever runs the daemon."), OPEN)
    return secret, public, pair


def require_name(name: str) -> None:
    """Refuse what is no name of a user.

    Parameters
    ----------
    name
        The name.

    Raises
    ------
    RefusedError
        If it has other characters than a to z, 0 to 9, '.', '_' and '-', begins with a point, or is too long.
    """
    if not NAME.fullmatch(name):
        raise refused(ProblemCode.USER_NAME, "", name[:80])


def read_pair(path: Path, *, links: bool = True) -> KeyPair:
    """Read a file that holds a key pair.

    Parameters
    ----------
    path
        The file.
    links
        Whether it may be a link to a file.

    Returns
    -------
    KeyPair
        The pair.

    Raises
    ------
    RefusedError
        If others may read it, or it does not hold two keys that belong together.
    OSError
        If it cannot be read.
    """
    import zmq

    entries = read_entries(path, ("public", "secret"), secret=True, links=links)
    pair = KeyPair(key_in(entries, "public", path), key_in(entries, "secret", path))
    if zmq.curve_public(pair.secret.encode("ascii")).decode("ascii") != pair.public:
        raise refused(ProblemCode.KEY_PAIR_MIXED, path)
    return pair


def read_public(key: str) -> str:
    """Read a public key that a user names.

    Parameters
    ----------
    key
        The key itself (Z85), or a file that holds it.

    Returns
    -------
    str
        The key, Z85.

    Raises
    ------
    RefusedError
        If it is neither, or the file holds a secret, which must not be handed around.
    OSError
        If the file cannot be read.
    """
    if is_key(key):
        return key
    path = Path(key).expanduser()
    if not path.exists():
        raise refused(ProblemCode.KEY_UNKNOWN, "", key)
    entries = read_entries(path, ("public", "secret", "role", "memory_gib", "threads", "sessions", "seconds"))
    if "secret" in entries:
        raise refused(ProblemCode.KEY_IS_SECRET, path, path.with_suffix(".pub").name)
    return key_in(entries, "public", path)


def private_folder(folder: Path) -> None:
    """Make a folder that only its owner may enter, or refuse one that is there and others may enter.

    Parameters
    ----------
    folder
        The folder.

    Raises
    ------
    RefusedError
        If something else is there, or a folder of another user or that others may enter.
    OSError
        If it cannot be made.
    """
    if not folder.exists() and not folder.is_symlink():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileExistsError):
            folder.mkdir(mode=0o700)
            _give_away(folder)
    found = folder.lstat()
    if not stat.S_ISDIR(found.st_mode):
        raise refused(ProblemCode.KEYS_NO_FOLDER, folder)
    if os.name == "posix":
        if os.geteuid() not in (0, found.st_uid):
            raise refused(ProblemCode.KEYS_NOT_YOURS, folder)
        if found.st_mode & _OTHERS:
            raise refused(ProblemCode.KEYS_FOLDER_OPEN, folder, f"{stat.S_IMODE(found.st_mode):04o}")


def write_new(path: Path, text: str, mode: int) -> None:
    """Write a file where there is none, whole or not at all.

    Parameters
    ----------
    path
        The file.
    text
        What it is to hold.
    mode
        Its mode.

    Raises
    ------
    RefusedError
        If there is one.
    OSError
        If the file system refuses.
    """
    fresh = _written(path, text, mode)
    try:
        os.link(fresh, path)
    except FileExistsError:
        raise refused(ProblemCode.KEY_EXISTS, path) from None
    finally:
        fresh.unlink(missing_ok=True)
    sync_folder(path.parent)


def write_over(path: Path, text: str, mode: int) -> None:
    """Write a file, whole or not at all, in place of the one that is there.

    Parameters
    ----------
    path
        The file.
    text
        What it is to hold.
    mode
        Its mode.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    fresh = _written(path, text, mode)
    try:
        fresh.replace(path)
    finally:
        fresh.unlink(missing_ok=True)
    sync_folder(path.parent)


def pair_text(pair: KeyPair, remark: str) -> str:
    """Write what a file of a key pair holds.

    Parameters
    ----------
    pair
        The pair.
    remark
        A line about it.

    Returns
    -------
    str
        The text.
    """
    return f"# {remark}\npublic = {pair.public}\nsecret = {pair.secret}\n"


def public_text(public: str, remark: str) -> str:
    """Write what a file of a public key holds.

    Parameters
    ----------
    public
        The key, Z85.
    remark
        A line about it.

    Returns
    -------
    str
        The text.
    """
    return f"# {remark}\npublic = {public}\n"


def _text(path: Path, secret: bool, links: bool) -> str:
    handle = os.open(path, _READ if links else _READ | getattr(os, "O_NOFOLLOW", 0))
    with os.fdopen(handle, "rb") as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise refused(ProblemCode.KEY_FILE_KIND, path)
        if secret and os.name == "posix" and found.st_mode & _OTHERS:
            raise refused(ProblemCode.KEY_FILE_OPEN, path, f"{stat.S_IMODE(found.st_mode):04o}")
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise refused(ProblemCode.KEY_FILE_LARGE, path, MAX_BYTES)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise refused(ProblemCode.KEY_FILE_KIND, path) from None


def _written(path: Path, text: str, mode: int) -> Path:
    """A file beside its place that holds the text, with its mode and the owner of the folder."""
    handle, name = tempfile.mkstemp(prefix=f".{path.name}-", dir=path.parent)
    fresh = Path(name)
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
            fresh.chmod(mode)
            _give_away(fresh)
            file.write(text)
            file.flush()
            os.fsync(handle)
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise
    return fresh


def _give_away(path: Path) -> None:
    """Where root writes into another user's folder, as that of a service, the file is that user's."""
    if os.name == "posix" and os.geteuid() == 0:
        owner = path.parent.stat()
        os.chown(path, owner.st_uid, owner.st_gid)
