"""How a session solves: one dataclass from the command line to the daemon.

Everything else derives from its fields: the options of the command line (`option`), what is told to the daemon (every
field), which fields are part of a frame's key (`in_key`), the report.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import Field, dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from lappet.procedure import Tissue


@dataclass(frozen=True)
class Option:
    """A setting as an option of the command line.

    Parameters
    ----------
    help
        What the option says.
    above
        Lower end of its range, open.
    least
        Lower end of its range, closed, where it has no open one.
    below
        Upper end of its range, open.
    choices
        Values that it may have.
    flags
        Its names where they do not follow from the field's.
    value
        What the field becomes where the option is a switch that is given.
    shown
        Whether the help shows the default.
    """

    help: str
    above: int | None = None
    least: int | None = None
    below: int | None = None
    choices: tuple[Any, ...] = ()
    flags: str = ""
    value: Any = None
    shown: bool = True


def setting(default: Any, *, option: Option | None = None, in_key: bool = True) -> Any:
    """Define a setting.

    Parameters
    ----------
    default
        Its default.
    option
        What it is on the command line, if anything.
    in_key
        Whether another value gives another equilibrium.

    Returns
    -------
    Any
        The field.
    """
    return field(default=default, metadata={"option": option, "in_key": in_key})


@dataclass(frozen=True)
class MaterialParameters:
    """A material as the daemon is told it: a map of the list `materials` of `open` (PROTOCOL.md).

    Parameters
    ----------
    model
        Name of the model.
    youngs_modulus
        Young's modulus in kPa.
    poissons_ratio
        Poisson's ratio.
    density
        Density in kg/m³.
    mooney_ratio
        Ratio μ₀₁/μ₁₀.
    fiber_direction
        Unit vector along the fibers at rest.
    fiber_k1
        Stiffness of the fibers in kPa; 0 for none.
    fiber_k2
        How the fibers stiffen, without unit.
    fiber_dispersion
        Dispersion of the fibers, 0 to 1/3.
    fiber_slack
        Stretch from which the fibers bear load.
    fiber_angle
        Angle in degrees at which half of the fibers and of the muscle run to the direction, to either side; 0 for one
        family.
    muscle_stress
        Greatest isometric stress of muscle in kPa; 0 for no muscle.
    prestretch
        In-vivo stretch along and across the direction.
    """

    model: str = "neoHookean"
    youngs_modulus: float = 50.0
    poissons_ratio: float = 0.45
    density: float = 1100.0
    mooney_ratio: float = 0.0
    fiber_direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    fiber_k1: float = 0.0
    fiber_k2: float = 0.0
    fiber_dispersion: float = 0.0
    fiber_slack: float = 1.0
    fiber_angle: float = 0.0
    muscle_stress: float = 0.0
    prestretch: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True)
class SolverSettings:
    """How a session solves: `settings` and `materials` of `open` (PROTOCOL.md).

    From `origin` on what is meant is the procedure's, filled in when it is compiled.

    Parameters
    ----------
    spacing
        Edge of the lattice's cells in mm; 0 for the tissue's own, until a procedure is compiled.
    tolerance
        Residual over force scale at which a frame has converged; the displacement still to come is then 20 of it in
        spacings at most.
    quadrature
        Quadrature points of a cell: 1, 4 or 8.
    precision
        Arithmetic of the solver.
    gap_tolerance
        Largest suture and grip gap, as a fraction of the spacing.
    max_newton
        Newton iterations of a frame at most.
    fine_ratio
        Fine voxels per lattice edge.
    time_budget
        Seconds per frame, and ten times that per epoch; 0 for no limit.
    memory_budget
        Memory in bytes.
    threads
        Number of threads; 0 for all.
    preconditioner
        The preconditioner; "chebyshev" leaves out the coarse space.
    correction
        Whether frames carry the displacement still to come, which is the algebraic error.
    strain
        Whether frames carry strain, stress and tension.
    stability
        Whether unstable equilibria are looked for and left.
    self_contact
        Whether the surface is kept from passing through itself; None for what the tissue says.
    friction
        Coulomb's coefficient of friction where the surface presses on itself, with self-contact; 0 for none.
    region
        Where a frame is solved: "auto" where its changes reach, "whole" everywhere.
    live
        Whether frames follow what somebody drags: what is set up for one serves the next, and none can be resumed bit
        for bit.
    origin
        A point of the grid in mm.
    bed_stiffness
        Stiffness of the bed along its normal in kPa/mm.
    bed_shear
        Stiffness of the bed in its plane in kPa/mm.
    gravity
        Gravity in m/s².
    sutures
        Number of sutures in the whole procedure.
    retractors
        Number of retractors in the whole procedure.
    materials
        The tissue's material first, then those of its regions.
    """

    spacing: float = setting(0.0, option=Option("Lattice edge in mm.", above=0, shown=False))
    tolerance: float = setting(1e-3, option=Option("Largest residual, relative to the force scale.", above=0, below=1))
    quadrature: int = setting(1, option=Option("Points per cell.", choices=(1, 4, 8)))
    precision: Literal["float", "double"] = setting(
        "float", option=Option("Precision of the arithmetic.", choices=("float", "double"))
    )
    gap_tolerance: float = setting(
        1e-3, option=Option("Largest gap of sutures and held faces, as a share of the spacing.", above=0, below=1)
    )
    max_newton: int = setting(100)
    fine_ratio: int = setting(4)
    time_budget: float = setting(0.0, in_key=False)
    memory_budget: int = setting(8 << 30, in_key=False)
    threads: int = setting(0, in_key=False)
    preconditioner: Literal["twoLevel", "chebyshev"] = setting("twoLevel")
    correction: bool = setting(False, in_key=False)
    strain: bool = setting(True, option=Option("Compute strain, stress and tension on the surface."))
    stability: bool = setting(True, option=Option("Look for unstable equilibria, and leave them for stable ones."))
    self_contact: bool | None = setting(
        None, option=Option("Keep tissue from passing through tissue.  [default: what the procedure says]")
    )
    friction: float = setting(
        0.0,
        option=Option(
            "Coefficient of friction where tissue presses on tissue; above 0 it keeps tissue apart.", least=0, below=10
        ),
    )
    region: Literal["auto", "whole"] = setting(
        "auto",
        option=Option(
            "Solve all cells of a frame at once, not those near its changes first.", flags="--whole", value="whole"
        ),
    )
    live: bool = setting(False)
    origin: tuple[float, float, float] = setting((0.0, 0.0, 0.0))
    bed_stiffness: float = setting(19.0)
    bed_shear: float = setting(0.375)
    gravity: tuple[float, float, float] = setting((0.0, 0.0, 0.0))
    sutures: int = setting(0, in_key=False)
    retractors: int = setting(0, in_key=False)
    materials: tuple[MaterialParameters, ...] = setting((MaterialParameters(),))


def for_tissue(settings: SolverSettings, tissue: Tissue) -> SolverSettings:
    """Fill in what settings leave to the tissue.

    Parameters
    ----------
    settings
        How to solve; a spacing of 0 and a self-contact of None are the tissue's.
    tissue
        The tissue.

    Returns
    -------
    SolverSettings
        The same with both told.
    """
    own = settings.self_contact
    return replace(
        settings,
        spacing=settings.spacing or tissue.spacing,
        self_contact=tissue.self_contact if own is None else own,
    )


def options() -> Iterator[tuple[Field[Any], Option]]:
    """List the settings that are options of the command line.

    Yields
    ------
    tuple[Field[Any], Option]
        The field and the option.
    """
    for item in fields(SolverSettings):
        option = item.metadata["option"]
        if option is not None:
            yield item, option


def in_key(name: str) -> bool:
    """Tell whether another value of a setting gives another equilibrium.

    Parameters
    ----------
    name
        Name of the setting.

    Returns
    -------
    bool
        Whether it does.
    """
    return bool(SolverSettings.__dataclass_fields__[name].metadata["in_key"])
