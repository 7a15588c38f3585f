"""Durations as people say them."""

from __future__ import annotations

from .said import said


def duration_text(seconds: float) -> str:
    """A duration as people say it: 'about 12 s', 'about 4 min', 'about 2.5 h'."""
    if seconds < 90.0:
        return said("about {count} s", count=max(1, round(seconds)))
    if seconds < 90.0 * 60.0:
        return said("about {count} min", count=round(seconds / 60.0))
    return said("about {count} h", count=f"{seconds / 3600.0:.1f}")
