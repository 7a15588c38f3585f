"""Frames named by their time codes, as people read them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise


def span_of(times: Sequence[float]) -> str:
    """Name frames: "Frame 3", "Frames 1, 3 to 5 and 9".

    Parameters
    ----------
    times
        Their time codes in order, at least one.

    Returns
    -------
    str
        The text.
    """
    runs = [[times[0], times[0]]]
    for before, time in pairwise(times):
        if time == before + 1.0:
            runs[-1][1] = time
        else:
            runs.append([time, time])
    said = [f"{first:g}" if first == last else f"{first:g} to {last:g}" for first, last in runs]
    listed = " and ".join(filter(None, [", ".join(said[:-1]), said[-1]]))
    return f"Frame{'' if len(times) == 1 else 's'} {listed}"
