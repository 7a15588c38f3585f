"""The operations in which the rows of the literature are measured: flaps of the library on patches of preset skin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from lappet.designs.library_operation import THICKNESS, flap_on_patch
from lappet.designs.z_plasty_design import z_plasty
from lappet.procedure import Incision, Landmark, Point, Procedure, Undermine
from lappet.tissue.patch import flat_patch
from lappet.tissue.presets.preset import Preset
from lappet.tissue.presets.skin import CHEEK, SCALP, TRUNK

ALONG, ACROSS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)  # directions of the skin lines; a design's own is x
LIMB = 20.0  # mm, of a Z-plasty
BESIDE = 2.0  # mm from the ends of its scar to the skin whose distance is measured
SCAR_ENDS, CENTRAL_LIMB = "scar end", "central limb"
CUT, LIPS = 24.0, "lip"  # mm, a straight cut; the middles of its lips
EXCISED = 12.0  # mm, width of a fusiform excision


def on_skin(
    procedure: Procedure, preset: Preset, lines: tuple[float, float, float] = ALONG, *, undermined: bool = True
) -> Procedure:
    """Give a patch another skin.

    Parameters
    ----------
    procedure
        The procedure.
    preset
        Its new skin, under its tension.
    lines
        Direction of the skin lines.
    undermined
        Whether it is undermined, if the procedure does so.

    Returns
    -------
    Procedure
        The same operation in that skin.
    """
    skin = replace(preset.material, fiber_direction=lines)
    kept = tuple(event for event in procedure.events if undermined or not isinstance(event, Undermine))
    return replace(procedure, tissue=replace(procedure.tissue, material=skin.name), materials=(skin,), events=kept)


def flap(
    name: str,
    values: Mapping[str, float],
    preset: Preset,
    spacing: float,
    lines: tuple[float, float, float] = ALONG,
    *,
    undermined: bool = True,
) -> Procedure:
    """Make the operation of a design.

    Parameters
    ----------
    name
        Name of the design.
    values
        Values of its parameters that are not the default.
    preset
        The skin.
    spacing
        Edge of the lattice's cells in mm.
    lines
        Direction of the skin lines.
    undermined
        Whether the skin around is undermined.

    Returns
    -------
    Procedure
        The operation.
    """
    return on_skin(flap_on_patch(name, values, spacing=spacing), preset, lines, undermined=undermined)


def z_plasty_of(angle: float, spacing: float) -> Procedure:
    """Make a Z-plasty whose scar and new central limb are measured.

    Parameters
    ----------
    angle
        Angle of both flaps in degrees.
    spacing
        Edge of the lattice's cells in mm.

    Returns
    -------
    Procedure
        The operation, its scar along the lines of the skin of the trunk.
    """
    values = {"limb": LIMB, "angle": angle, "other": angle}
    made = flap("z-plasty", values, TRUNK, spacing)
    a, b, c = (np.array(corner) for corner in z_plasty((0.0, 0.0, THICKNESS), ALONG, LIMB, angle).curve[:3])
    ahead = BESIDE * (b - c) / np.linalg.norm(b - c)
    inside = (a + b + c) / 3.0
    ends = Landmark("scar_ends", (_point(b + ahead), _point(c - ahead)), SCAR_ENDS)
    limb = Landmark("central_limb", (_point(0.9 * a + 0.1 * inside), _point(0.9 * b + 0.1 * inside)), CENTRAL_LIMB)
    return made.with_events(ends, limb)


def straight_cut(lines: tuple[float, float, float], spacing: float) -> Procedure:
    """Make a straight cut through skin of the trunk, the middles of whose lips are measured.

    Parameters
    ----------
    lines
        Direction of the skin lines; the cut runs along x.
    spacing
        Edge of the lattice's cells in mm.

    Returns
    -------
    Procedure
        The cut.
    """
    lips = tuple((0.0, side * 0.1, THICKNESS) for side in (1.0, -1.0))
    cut = Incision("cut", 2, ((-0.5 * CUT, 0.0, THICKNESS), (0.5 * CUT, 0.0, THICKNESS)), kerf=0.05)
    patch = flat_patch((80.0, 60.0, THICKNESS), spacing=spacing)
    plain = Procedure(patch, (), events=(cut, Landmark("lips", lips, LIPS)), start_time=1, end_time=4, fps=12)
    return on_skin(plain, TRUNK, lines)


def _point(xyz: np.ndarray) -> Point:
    return (float(xyz[0]), float(xyz[1]), float(xyz[2]))


def _flap(name: str, preset: Preset = TRUNK, **values: float) -> Callable[[float], Procedure]:
    return lambda spacing: flap(name, values, preset, spacing)


def _excision(
    preset: Preset, lines: tuple[float, float, float] = ALONG, ratio: float = 3.0, *, undermined: bool = True
) -> Callable[[float], Procedure]:
    values = {"length": ratio * EXCISED, "width": EXCISED}
    return lambda spacing: flap("fusiform", values, preset, spacing, lines, undermined=undermined)


OPERATIONS: dict[str, Callable[[float], Procedure]] = {  # of the edge of the lattice's cells in mm
    **{f"z-plasty-{angle}": partial(z_plasty_of, angle) for angle in (30, 45, 60, 75, 90)},
    **{f"fusiform-{ratio}": _excision(TRUNK, ratio=ratio) for ratio in (2, 3, 4, 5)},
    "fusiform-across": _excision(TRUNK, ACROSS),
    "fusiform-held": _excision(TRUNK, undermined=False),
    "fusiform-across-held": _excision(TRUNK, ACROSS, undermined=False),
    "fusiform-cheek": _excision(CHEEK),
    "fusiform-cheek-held": _excision(CHEEK, undermined=False),
    "fusiform-scalp": _excision(SCALP),
    "cut-along": partial(straight_cut, ALONG),
    "cut-across": partial(straight_cut, ACROSS),
    **{f"rotation-{ratio}": _flap("rotation", arc_ratio=ratio) for ratio in (2, 3, 6)},
    **{f"u-plasty-{ratio}": _flap("u-plasty", length=ratio) for ratio in (1, 2, 3)},
    "limberg": _flap("limberg"),
    "v-y-narrow": _flap("v-y", width=0.4),
    "v-y-wide": _flap("v-y", width=1.5),
}
