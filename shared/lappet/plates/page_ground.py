"""The ground of a page or a film, and the colors of what is written on it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PageGround:
    """A ground.

    Parameters
    ----------
    paper
        Its color, #rrggbb; "" for none: it is transparent.
    ink
        Color of captions.
    quiet
        Color of what is less important.
    """

    paper: str
    ink: str
    quiet: str


WHITE = PageGround("#ffffff", "#111111", "#55606d")
DARK = PageGround("#14171b", "#f1f3f6", "#aab4c0")
CLEAR = PageGround("", "#111111", "#55606d")
