"""The lattice spacing that new tissue gets where none is given."""

from __future__ import annotations

_CELLS = 40_000


def chosen_spacing(volume: float, thickness: float = 0.0) -> float:
    """Choose a lattice spacing: about 40 000 cells, and at least a quarter of a sheet's thickness.

    Parameters
    ----------
    volume
        Volume of the tissue in mm³.
    thickness
        Thickness of a sheet in mm, 0 for other tissue.

    Returns
    -------
    float
        Spacing in mm with two digits.
    """
    return float(f"{max(thickness / 4.0, (volume / _CELLS) ** (1.0 / 3.0)):.2g}")
