"""What reading a file may take: defaults that a face scan of 200 MB passes, and the options that raise them."""

from __future__ import annotations

from dataclasses import dataclass

GIB = 1 << 30


@dataclass(frozen=True)
class ReadLimits:
    """What reading one file, with all that it refers to, may take.

    Parameters
    ----------
    memory
        Bytes of memory of the process that reads. Only Linux keeps it.
    seconds
        Seconds of a processor; by the clock it may take twice as long.
    size
        Bytes of one file, and of what is read from all of them.
    allow_external
        Whether files outside the folder of the first one are followed.
    """

    memory: int = 4 * GIB
    seconds: int = 120
    size: int = 1 * GIB
    allow_external: bool = False

    @property
    def wall_seconds(self) -> int:
        """Seconds by the clock after which reading ends: on a busy machine they are not all its own."""
        return 2 * self.seconds


DEFAULT_LIMITS = ReadLimits()
