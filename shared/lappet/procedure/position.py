"""How the patient lies: the direction in which gravity pulls, in the axes of a head as scanners give them.

x runs to the patient's right, y to the front, z to the top of the head. A patch without a patient has z as its outward
normal, so that `upright` presses it onto its bed.
"""

from __future__ import annotations

from lappet.procedure.exact_values import Point

POSITIONS: dict[str, Point] = {
    "upright": (0.0, 0.0, -1.0),
    "supine": (0.0, -1.0, 0.0),
    "prone": (0.0, 1.0, 0.0),
    "left_lateral": (-1.0, 0.0, 0.0),
    "right_lateral": (1.0, 0.0, 0.0),
}


def position_of(direction: Point) -> str | None:
    """Name the position in which gravity pulls along a direction.

    Parameters
    ----------
    direction
        The direction, of any length.

    Returns
    -------
    str | None
        A name of `POSITIONS`, or None for a direction between them.
    """
    length = sum(value * value for value in direction) ** 0.5
    if not length > 0.0:
        return None
    for name, down in POSITIONS.items():
        if all(abs(value / length - wanted) < 1e-9 for value, wanted in zip(direction, down, strict=True)):
            return name
    return None
