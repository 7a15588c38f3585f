"""Procedures as scenes of a report: the surfaces are cut once, so that they compare between spacings."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.demo import z_plasty
from lappet.designs import Row, Schedule, Technique, dufourmentel, flap_operation
from lappet.procedure import Material, Procedure
from lappet.program.compile import compile_program
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.tissue.dome import dome_bone, dome_scalp, draped
from lappet.tissue.skin_sheet import SkinSheet
from lappet.usd.stage import read_procedure


@dataclass(eq=False)
class ProcedureScene:
    """A procedure as a scene of a report.

    Parameters
    ----------
    name
        Name of the scene.
    what
        What it is, for people.
    procedure
        The procedure.
    spacings
        Lattice spacings of the report in mm.
    reference
        Three spacings in mm, see `lappet.reports.error_time.measurement.Scene`.
    surface_spacing
        How finely its surfaces are divided in mm.
    is_box
        Whether the tissue is a box.
    smooth
        Whether nothing lowers its order.
    every_combination
        Whether settings are not only varied alone.
    edge_exponent
        Exponent of the displacement at held edges, or None.
    """

    name: str
    what: str
    procedure: Procedure
    spacings: tuple[float, ...]
    reference: tuple[float, float, float]
    surface_spacing: float = 1.0
    is_box: bool = False
    smooth: bool = False
    every_combination: bool = False
    edge_exponent: float | None = None
    _program: Program | None = field(default=None, repr=False)

    def away(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Find places that are well away from what is held: everywhere, since what is held is cut and sutured besides.

        Parameters
        ----------
        points
            Points in mm, shape (n, 3).

        Returns
        -------
        NDArray[np.bool_]
            All true, shape (n,).
        """
        return np.ones(len(points), np.bool_)

    def program(self, spacing: float, **settings: Any) -> Program:
        """Make the whole procedure at a spacing.

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
        if self._program is None:
            self._program = compile_program(self.procedure, settings=SolverSettings(spacing=self.surface_spacing))
        return replace(self._program, settings=replace(self._program.settings, spacing=spacing, **settings))


def z_plasty_scene() -> ProcedureScene:
    """Make the scene of the Z-plasty that comes with Lappet.

    Returns
    -------
    ProcedureScene
        The scene.
    """
    return ProcedureScene(
        "z-plasty",
        "the Z-plasty of the demo, 40 frames, the error in the last",
        read_procedure(z_plasty()),
        spacings=(2.0, 4.0 / 3.0, 1.0),
        reference=(2.0, 1.0, 0.5),
    )


def scalp_flap() -> ProcedureScene:
    """Make the scene of Dufourmentel and Mouly's flap on a domed scalp over a skull.

    It is that of `examples/dufourmentel_mouly_scalp`.

    Returns
    -------
    ProcedureScene
        The scene.
    """
    radius, thickness = 90.0, 6.0
    tissue = dome_scalp(radius, 48.0, thickness, resolution=2.0, spacing=2.0)
    design = dufourmentel((0.0, 0.0, radius), (1.0, 0.0, 0.0), 12.0, 66.0, project=draped(radius))
    when = Schedule()
    rows = (Row("galea", 4.7), Row("dermal", 1.0, 0.5), Row("skin", 0.0))
    procedure = Procedure(
        tissue=tissue,
        materials=(Material("skin"),),
        events=flap_operation(design, SkinSheet.of(tissue), when, Technique(beyond=10.0, apart=2.6, rows=rows)),
        bones=(dome_bone(83.9, 56.0),),
        start_time=1,
        end_time=when.end,
        fps=12,
    )
    return ProcedureScene(
        "scalp-flap",
        "Dufourmentel and Mouly's flap on a domed scalp over bone, the error in the last frame",
        procedure,
        spacings=(2.0, 1.5, 1.2),
        reference=(3.0, 1.5, 0.75),
        surface_spacing=1.2,
    )
