"""Durations as people say them."""

from __future__ import annotations


def duration_text(seconds: float) -> str:
    """A duration as people say it: 'about 12 s', 'about 4 min', 'about 2.5 h'."""
    if seconds < 90.0:
        return f"about {max(1, round(seconds))} s"
    if seconds < 90.0 * 60.0:
        return f"about {round(seconds / 60.0)} min"
    return f"about {seconds / 3600.0:.1f} h"
