"""Pictures as PNG (ISO/IEC 15948): eight bits for each of red, green and blue, no filter."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.core.durable import write_whole


def write_png(picture: NDArray[np.uint8], path: Path) -> None:
    """Write a picture; a file of that name is replaced whole.

    Parameters
    ----------
    picture
        Red, green and blue of each pixel from the top left on, shape (height, width, 3).
    path
        The file.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    write_whole(path, png_bytes(picture))


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    picture
        Red, green and blue of each pixel from the top left on, shape (height, width, 3).

    Returns
    -------
    bytes
        What the file holds.
    """
    height, width, _ = picture.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), picture.reshape(height, 3 * width)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 6)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + body
