"""When each frame is shown in a file that plays by itself: with a pause at each step."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Shown:
    """A frame while it is shown.

    Parameters
    ----------
    frame
        Its time code in the cache.
    begin
        Its time code in the file.
    end
        That at which its pause ends; `begin` where there is none.
    """

    frame: float
    begin: float
    end: float


def play_times(frames: Sequence[float], steps: Collection[float], pause: float) -> list[Shown]:
    """Lay frames out in time.

    Parameters
    ----------
    frames
        Time codes of the cache, ascending, at least one.
    steps
        Those at which a step is done.
    pause
        How long each of these is held, and the last frame, in time codes.

    Returns
    -------
    list[Shown]
        The frames; the first begins at 0, and between two of them passes what passes in the cache.
    """
    found: list[Shown] = []
    for frame in frames:
        begin = found[-1].end + frame - found[-1].frame if found else 0.0
        held = pause if frame in steps or frame == frames[-1] else 0.0
        found.append(Shown(frame, begin, begin + held))
    return found
