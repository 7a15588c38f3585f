"""How a session solves: one dataclass from the command line to the daemon.

Everything else derives from its fields: the options of the command line (`option`), what is told to the daemon (every
field), which fields are part of a frame's key (`in_key`), the report.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import Field, dataclass, field, fields
from typing import Any, Literal


@dataclass(frozen=True)
class Option:
    """A setting as an option of the command line.

    help: what it says. above, below: open ends of its range. choices: the values it may have. flags: its names where
    they do not follow from the field's. value: what the field becomes where the option is a switch that is given.
    shown: whether the help shows the default.
    """

    help: str
    above: int | None = None
    below: int | None = None
    choices: tuple[Any, ...] = ()
    flags: str = ""
    value: Any = None
    shown: bool = True


def setting(default: Any, *, option: Option | None = None, in_key: bool = True) -> Any:
    """Define a setting; in_key: another value gives another equilibrium."""
    return field(default=default, metadata={"option": option, "in_key": in_key})


@dataclass(frozen=True)
class MaterialParameters:
    """A material as the daemon is told it: a map of the list `materials` of `open` (PROTOCOL.md).

    youngs_modulus, fibre_k1, muscle_stress: kPa. density: kg/m³. fibre_direction: of length 1.
    """

    model: str = "neoHookean"
    youngs_modulus: float = 50.0
    poissons_ratio: float = 0.45
    density: float = 1100.0
    mooney_ratio: float = 0.0
    fibre_direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    fibre_k1: float = 0.0
    fibre_k2: float = 0.0
    fibre_dispersion: float = 0.0
    muscle_stress: float = 0.0
    prestretch: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True)
class SolverSettings:
    """How a session solves: `settings` and `materials` of `open` (PROTOCOL.md).

    spacing: lattice edge, mm; 0 = the tissue's own, until a procedure is compiled. tolerance: residual over force
    scale. quadrature: points per cell (1, 4 or 8). precision: "float" or "double". gap_tolerance: largest suture and
    grip gap as a fraction of the spacing. fine_ratio: fine voxels per lattice edge. time_budget: s per frame, 0 = none.
    memory_budget: bytes. threads: 0 = all. preconditioner: "chebyshev" leaves out the coarse space. correction: frames
    carry the Newton step left over, from which the algebraic error is estimated. strain: frames carry strain, stress
    and tension. region: "auto" solves a frame where its changes reach, "whole" everywhere.

    What follows is the procedure's, filled in when it is compiled. origin: a grid point, mm. bed_stiffness: kPa/mm.
    gravity: m/s². sutures, retractors: their numbers in the whole procedure. materials: the tissue's first, then those
    of its regions.
    """

    spacing: float = setting(0.0, option=Option("Lattice edge in mm.", above=0, shown=False))
    tolerance: float = setting(1e-3, option=Option("Residual over the scene's force scale.", above=0, below=1))
    quadrature: int = setting(1, option=Option("Points per cell.", choices=(1, 4, 8)))
    precision: Literal["float", "double"] = setting("float", option=Option("Arithmetic.", choices=("float", "double")))
    gap_tolerance: float = setting(1e-3)
    max_newton: int = setting(100)
    fine_ratio: int = setting(4)
    time_budget: float = setting(0.0, in_key=False)
    memory_budget: int = setting(8 << 30, in_key=False)
    threads: int = setting(0, in_key=False)
    preconditioner: Literal["twoLevel", "chebyshev"] = setting("twoLevel")
    correction: bool = setting(False, in_key=False)
    strain: bool = setting(True, option=Option("Compute strain, stress and tension on the surface."))
    region: Literal["auto", "whole"] = setting(
        "auto",
        option=Option(
            "Solve every frame everywhere, also where its changes do not reach.", flags="--whole", value="whole"
        ),
    )
    origin: tuple[float, float, float] = setting((0.0, 0.0, 0.0))
    bed_stiffness: float = setting(10.0)
    gravity: tuple[float, float, float] = setting((0.0, 0.0, 0.0))
    sutures: int = setting(0, in_key=False)
    retractors: int = setting(0, in_key=False)
    materials: tuple[MaterialParameters, ...] = setting((MaterialParameters(),))


def options() -> Iterator[tuple[Field[Any], Option]]:
    """Yield the settings that are options of the command line."""
    for item in fields(SolverSettings):
        option = item.metadata["option"]
        if option is not None:
            yield item, option


def in_key(name: str) -> bool:
    """Return whether another value of the setting of this name gives another equilibrium."""
    return bool(SolverSettings.__dataclass_fields__[name].metadata["in_key"])
