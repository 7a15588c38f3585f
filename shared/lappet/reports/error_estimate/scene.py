"""Scenes of the report: programs whose surface is the same at every spacing, so that their points compare."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lappet.cutting.epoch import Regions
from lappet.procedure import Event, Material, Procedure, Tissue
from lappet.program.compile import compile_program
from lappet.program.program import Bones, Program
from lappet.program.settings import SolverSettings
from lappet.reports.box_scenes import BoxScene, grid_box

SPACINGS = (2.0, 1.5, 1.0)
REFERENCE = (1.0, 0.5, 0.25)


@dataclass(frozen=True, eq=False)
class EstimateScene:
    """A scene whose printed error is held against its true one.

    Parameters
    ----------
    name
        Name of the scene.
    what
        What it is, for people.
    base
        Makes its program; called once.
    spacings
        Lattice spacings that are judged in mm.
    reference
        Three spacings in mm, each half of the one before, whose last is at most a quarter of every judged one.
    gravity
        Gravity in m/s².
    """

    name: str
    what: str
    base: Callable[[], Program]
    spacings: tuple[float, ...] = SPACINGS
    reference: tuple[float, float, float] = REFERENCE
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    _made: dict[str, Program] = field(default_factory=dict, repr=False)

    @property
    def procedure(self) -> Procedure | None:
        """The procedure of an operation; None for a box."""
        return self.base.procedure if isinstance(self.base, Operation) else None

    def program(self, spacing: float, **settings: Any) -> Program:
        """Make the scene at a spacing.

        Parameters
        ----------
        spacing
            Lattice spacing in mm.
        **settings
            Other fields of `SolverSettings`.

        Returns
        -------
        Program
            The program.
        """
        if "base" not in self._made:
            self._made["base"] = self.base()
        base = self._made["base"]
        return replace(base, settings=replace(base.settings, gravity=self.gravity, spacing=spacing, **settings))


@dataclass(frozen=True)
class Operation:
    """The base of an operation.

    Parameters
    ----------
    procedure
        The procedure.
    """

    procedure: Procedure

    def __call__(self) -> Program:
        """Compile it, the surface divided at 1 mm.

        Returns
        -------
        Program
            The program.
        """
        return compile_program(self.procedure, settings=SolverSettings(spacing=1.0))


def operation(
    tissue: Tissue, *events: Event, end: float, materials: tuple[Material, ...] = (), **more: Any
) -> Callable[[], Program]:
    """Make the base of an operation.

    Parameters
    ----------
    tissue
        The tissue.
    *events
        The events.
    end
        Last time code.
    materials
        The materials; skin where none is given.
    **more
        Other fields of the procedure.

    Returns
    -------
    Operation
        The base.
    """
    procedure = Procedure(
        tissue=tissue, materials=materials or (SKIN,), events=events, start_time=1, end_time=end, **more
    )
    return Operation(procedure)


SKIN = Material("skin", model="neoHookean", youngs_modulus=50.0, poissons_ratio=0.45)


def box(
    scene: BoxScene,
    *,
    activation: float = 0.0,
    layers: Regions | None = None,
    materials: tuple[Any, ...] = (),
    bones: Bones | None = None,
    grip: Callable[[np.ndarray], np.ndarray] | None = None,
) -> Callable[[], Program]:
    """Make the base of a box.

    Parameters
    ----------
    scene
        The box.
    activation
        Activation of its muscle.
    layers
        Its material regions, or None.
    materials
        Its materials where there are regions.
    bones
        Bones, or None.
    grip
        Which triangles of the gripped sides are gripped by their centers, shape (m, 3); all where None.

    Returns
    -------
    Callable[[], Program]
        Makes its program.
    """

    def make() -> Program:
        program = scene.program(1.0)
        (epoch,), (frame,), (grips,) = program.epochs, program.frames, program.grips
        chosen = materials or program.settings.materials
        if activation:
            frame = replace(frame, activation=np.full(len(chosen), activation))
        if layers is not None:
            epoch = replace(epoch, regions=layers)
        if grip is not None:
            center = epoch.surface.points[epoch.surface.triangles].mean(axis=1)
            grips = np.where(grip(center), grips, -1).astype(np.int32)
        return replace(
            program,
            epochs=(epoch,),
            frames=(frame,),
            grips=(grips,),
            bones=bones if bones is not None else Bones(),
            settings=replace(program.settings, materials=chosen),
        )

    return make


def layers_of(
    size: tuple[float, float, float], divisions: tuple[int, int, int], depth: float, until: float = np.inf
) -> Regions:
    """Make the region of a second material below the upper side of a box.

    Parameters
    ----------
    size
        Extent of the box in mm.
    divisions
        Divisions of its surface.
    depth
        Depth at which the region begins in mm.
    until
        Depth at which it ends in mm.

    Returns
    -------
    Regions
        The region.
    """
    surface, side = grid_box(size, divisions)
    return Regions(
        surface.points, surface.triangles, (side == 5)[None], np.ones(1, np.int32), np.array([depth]), np.array([until])
    )
