"""From how near surfaces press on each other with self-contact, as the daemon has it (docs/solver.md)."""

from __future__ import annotations

_SHARE = 0.05
_FULL_SPACING = 1.0


def contact_reach(spacing: float) -> float:
    """Give the distance from which on surfaces press on each other.

    Parameters
    ----------
    spacing
        The lattice spacing in mm.

    Returns
    -------
    float
        The distance in mm.
    """
    return _SHARE * spacing * max(1.0, spacing / _FULL_SPACING)
