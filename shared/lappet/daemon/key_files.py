"""Key pairs and the files that hold them: lines `name = value`, `#` comments (PROTOCOL.md, "Keys").

Keys are CURVE keys in Z85, 40 characters.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode

NAME = re.compile(r"[a-z0-9_-][a-z0-9._-]{0,63}")
MAX_BYTES = 4096
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


def _text(path: Path, secret: bool, links: bool) -> str:
    handle = os.open(path, _READ if links else _READ | getattr(os, "O_NOFOLLOW", 0))
    try:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise refused(ProblemCode.KEY_FILE_KIND, path)
        if secret and os.name == "posix" and found.st_mode & _OTHERS:
            raise refused(ProblemCode.KEY_FILE_OPEN, path, f"{stat.S_IMODE(found.st_mode):04o}")
        with os.fdopen(handle, "rb", closefd=False) as file:
            data = file.read(MAX_BYTES + 1)
    finally:
        os.close(handle)
    if len(data) > MAX_BYTES:
        raise refused(ProblemCode.KEY_FILE_LARGE, path, MAX_BYTES)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        raise refused(ProblemCode.KEY_FILE_KIND, path) from None
