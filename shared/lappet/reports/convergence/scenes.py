"""Flaps that a residual in one norm loses sight of: small and floppy ones in patches of any size, slack and taut."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

from lappet.procedure import Event, Hook, Incision, Landmark, Material, Procedure, Undermine
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.reports.box_scenes import CANTILEVER
from lappet.tissue.patch import flat_patch

Kind = Literal["released", "hanging", "freed", "lifted"]
Point = tuple[float, float, float]
THICKNESS = 3.0
FLAP = (40.0, 16.0)
GRAVITY = 9.81
PRESTRETCH = 1.1
SIZES = ((60.0, 40.0), (100.0, 80.0), (200.0, 160.0), (400.0, 160.0))  # mm
MODULI = (5.0, 50.0, 500.0, 5000.0)  # kPa


class ConvergenceScene(Protocol):
    """What is solved at the default settings and to 1e-8."""

    @property
    def name(self) -> str:
        """The scene in words."""

    @property
    def kind(self) -> str:
        """What happens in it."""

    @property
    def spacing(self) -> float:
        """Lattice spacing in mm."""

    def program(self, **settings: Any) -> Program:
        """Compile it.

        Parameters
        ----------
        **settings
            Fields of `SolverSettings` but the spacing.

        Returns
        -------
        Program
            The program.
        """


@dataclass(frozen=True)
class FlapScene:
    """A flap of 40 x 16 x 3 mm that stays attached along one short side of it.

    Parameters
    ----------
    kind
        What happens: `released` (cut, nothing else), `hanging` (cut in the first frame, the skin facing down),
        `freed` (the same, cut in the second frame, after skin that hangs already) or `lifted` (a hook lifts the tip by
        15 mm and lets go).
    size
        Extent of the patch in mm.
    taut
        Whether the skin is stretched by a tenth.
    youngs_modulus
        Young's modulus in kPa.
    spacing
        Lattice spacing in mm.
    flaps
        Middles of the flaps in mm.
    """

    kind: Kind
    size: tuple[float, float]
    taut: bool
    youngs_modulus: float
    spacing: float = 2.0
    flaps: tuple[tuple[float, float], ...] = ((0.0, 0.0),)

    @property
    def name(self) -> str:
        """The scene in words."""
        return (
            f"{self.kind}, {self.size[0]:g} x {self.size[1]:g} mm, {'taut' if self.taut else 'slack'}, "
            f"{self.youngs_modulus:g} kPa" + (f", {len(self.flaps)} flaps" if len(self.flaps) > 1 else "")
        )

    def program(self, **settings: Any) -> Program:
        """Compile it.

        Parameters
        ----------
        **settings
            Fields of `SolverSettings` but the spacing.

        Returns
        -------
        Program
            The program.
        """
        cut = 1.0 if self.kind == "hanging" else 2.0
        events = [event for k, middle in enumerate(self.flaps) for event in _flap(self.kind, k, middle, cut)]
        material = Material(
            youngs_modulus=self.youngs_modulus, prestretch=(PRESTRETCH, PRESTRETCH) if self.taut else (1.0, 1.0)
        )
        procedure = Procedure(
            tissue=flat_patch((*self.size, THICKNESS), resolution=4.0, spacing=self.spacing),
            materials=(material,),
            events=tuple(events),
            start_time=1.0,
            end_time={"released": 2.0, "hanging": 1.0, "freed": 2.0, "lifted": 5.0}[self.kind],
        )
        program = compile_program(procedure, settings=SolverSettings(**settings))
        hangs = self.kind in ("hanging", "freed")
        # The skin of a patch looks up; turned over, its weight draws it off its bed.
        return replace(program, settings=replace(program.settings, gravity=(0.0, 0.0, GRAVITY if hangs else 0.0)))


@dataclass(frozen=True)
class BeamScene:
    """The cantilever of the report of error against run time: bending spoils it first where a solve ends too soon.

    Parameters
    ----------
    spacing
        Lattice spacing in mm.
    youngs_modulus
        Young's modulus in kPa.
    """

    spacing: float
    youngs_modulus: float = 50.0

    @property
    def kind(self) -> str:
        """What happens in it."""
        return "cantilever"

    @property
    def name(self) -> str:
        """The scene in words."""
        return f"cantilever, {self.spacing:g} mm, {self.youngs_modulus:g} kPa"

    def program(self, **settings: Any) -> Program:
        """Compile it.

        Parameters
        ----------
        **settings
            Fields of `SolverSettings` but the spacing.

        Returns
        -------
        Program
            The program.
        """
        material = replace(CANTILEVER.material, youngs_modulus=self.youngs_modulus)
        return replace(CANTILEVER, material=material).program(self.spacing, **settings)


def scenes(quick: bool) -> Iterator[ConvergenceScene]:
    """List the campaign.

    Parameters
    ----------
    quick
        Whether to leave out the large patches, and the moduli between in the small ones too.

    Yields
    ------
    ConvergenceScene
        The scenes.
    """
    kinds: tuple[Kind, ...] = ("released", "hanging", "freed", "lifted")
    for size in SIZES[:2] if quick else SIZES:
        extremes_alone = quick or size in SIZES[2:]
        for taut in (False, True):
            for modulus in MODULI[::3] if extremes_alone else MODULI:
                for kind in kinds:
                    yield FlapScene(kind, size, taut, modulus)
    for spacing in (2.0, 1.5) if quick else (2.0, 1.5, 1.25, 1.0):
        yield BeamScene(spacing)


def twins(quick: bool) -> Iterator[tuple[FlapScene, FlapScene]]:
    """List patches with one flap and with two that are far apart.

    Parameters
    ----------
    quick
        Whether to leave out all but one.

    Yields
    ------
    tuple[FlapScene, FlapScene]
        A patch with one flap, and the same with two.
    """
    kinds: tuple[Kind, ...] = ("freed",) if quick else ("released", "freed", "lifted")
    for kind in kinds:
        one = FlapScene(kind, (160.0, 40.0), True, 500.0, flaps=((-40.0, 0.0),))
        yield one, replace(one, flaps=((-40.0, 0.0), (40.0, 0.0)))


def _flap(kind: Kind, number: int, middle: tuple[float, float], cut: float) -> list[Event]:
    (x, y), (length, width) = middle, FLAP

    def at(along: float, across: float) -> Point:
        return (x + along * length / 2, y + across * width / 2, THICKNESS)

    events: list[Event] = [
        Incision(f"flap_{number}", cut, (at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)), depth=None),
        Landmark(f"tip_{number}", (at(0.95, 0.0),), f"tip {number}"),
        Undermine(f"free_{number}", cut, (at(-1, -1), at(1, -1), at(1, 1), at(-1, 1), at(-1, -1))),
    ]
    if kind == "lifted":
        tip = at(0.9, 0.0)
        up = (tip[0] - 5.0, tip[1], tip[2] + 15.0)
        events.append(Hook(f"hook_{number}", tip, ((2.0, tip), (3.0, up)), 2.0, 4.0))
    return events
