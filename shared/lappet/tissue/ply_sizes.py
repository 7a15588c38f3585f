"""What the header of a PLY file promises, before anything believes it."""

from __future__ import annotations

from pathlib import Path
from typing import IO

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode


def refuse_ply_sizes(path: Path, stream: IO[bytes]) -> None:
    """Refuse a PLY file whose header counts more elements than the file has bytes.

    Parameters
    ----------
    path
        The file.
    stream
        The file, open; it stands at its beginning afterwards.

    Raises
    ------
    RefusedError
        If it does.
    """
    size = path.stat().st_size
    for line in stream:
        words = line.split()
        if b"end_header" in words:
            break
        if len(words) >= 3 and words[0] == b"element":
            count = int(words[2]) if words[2].isdigit() else -1
            if not 0 <= count <= size:
                name, value = words[1].decode(errors="replace"), words[2].decode(errors="replace")
                raise refused(ProblemCode.MESH_SIZES, path, f"{value:.20} elements", what=f"{name:.20}", room=size)
    stream.seek(0)
