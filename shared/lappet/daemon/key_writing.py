"""Files of keys as they are written: whole or not at all, with the modes that they need, never over another's key."""

from __future__ import annotations

import contextlib
import os
import stat
import tempfile
from pathlib import Path

from lappet.core.durable import sync_folder
from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.key_files import KeyPair, new_pair, require_name

SECRET, OPEN = 0o600, 0o644
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


def default_folder() -> Path:
    """Find the folder of the user's own keys.

    Returns
    -------
    Path
        The folder; it need not be there.
    """
    import platformdirs

    return platformdirs.user_config_path("lappet", appauthor=False)


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
    text = pair_text(pair, f"The key of {name}. Nobody else may read it.")
    told = public_text(pair.public, f"The public key of {name}: for whoever runs the daemon.")
    write_pair(secret, text, public, told)
    return secret, public, pair


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


def write_pair(secret: Path, text: str, public: Path, told: str) -> None:
    """Write the files of a new key pair, both or neither.

    Parameters
    ----------
    secret
        The file of the pair.
    text
        What it is to hold.
    public
        The file of the public key; one that is there is replaced.
    told
        What that is to hold.

    Raises
    ------
    RefusedError
        If there is a file of a pair.
    OSError
        If the file system refuses; names the file.
    """
    write_new(secret, text, SECRET)
    try:
        write_over(public, told, OPEN)
    except OSError:
        secret.unlink(missing_ok=True)  # nobody has seen it
        raise


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
    except OSError as error:  # a write does not say of which file
        fresh.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error
    except BaseException:
        fresh.unlink(missing_ok=True)
        raise
    return fresh


def _give_away(path: Path) -> None:
    """Where root writes into another user's folder, as that of a service, the file is that user's."""
    if os.name == "posix" and os.geteuid() == 0:
        owner = path.parent.stat()
        os.chown(path, owner.st_uid, owner.st_gid)
