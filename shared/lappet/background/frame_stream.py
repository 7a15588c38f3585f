"""Messages through a pipe: eight bytes of length, little-endian, then as many bytes."""

from __future__ import annotations

import io

from lappet.core.problem import ProblemsError
from lappet.core.problem_code import ProblemCode

MOST_BYTES = 1 << 32


class StreamError(ProblemsError, OSError):
    """What came through the pipe is no message."""

    code_of_sentences = ProblemCode.PIPE_MALFORMED


def write_frame(pipe: io.RawIOBase, data: bytes) -> None:
    """Write a message whole.

    Parameters
    ----------
    pipe
        The pipe.
    data
        The message.

    Raises
    ------
    OSError
        If nobody reads any more.
    """
    for part in (memoryview(len(data).to_bytes(8, "little")), memoryview(data)):
        rest = part
        while rest:
            written = pipe.write(rest)
            rest = rest[written or 0 :]


def read_frame(pipe: io.RawIOBase) -> bytearray | None:
    """Read the next message.

    Parameters
    ----------
    pipe
        The pipe.

    Returns
    -------
    bytearray | None
        The message, or None at the end of the stream; a message that breaks off counts as the end.

    Raises
    ------
    StreamError
        If what comes is no message.
    """
    head = _read(pipe, 8)
    if head is None:
        return None
    size = int.from_bytes(head, "little")
    if size > MOST_BYTES:
        raise StreamError(f"The pipe holds a message of {size} bytes; at most {MOST_BYTES} are read.")
    return _read(pipe, size)


def _read(pipe: io.RawIOBase, size: int) -> bytearray | None:
    data = bytearray(size)
    rest = memoryview(data)
    while rest:
        count = pipe.readinto(rest)
        if not count:
            return None
        rest = rest[count:]
    return data
