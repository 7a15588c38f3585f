"""`lappet report economy`: what each feature costs where a scene needs it, and that it costs nothing where none does.

Instructions are those of one frame on one thread, by callgrind (`lappet.reports.economy.instructions`); seconds are the
median of native solves of the same frame on one thread; bytes are what the session holds and what the frame carries.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import SolverClient
from lappet.daemon.process import SolverDaemon
from lappet.program.program import Program
from lappet.reports.economy.instructions import Instructions, NoCounterError, count_instructions
from lappet.reports.economy.scenes import FEATURES, Feature, plain

REPEATS = 3
AGREEMENT = 5e-3  # share of the hot loops' instructions that an absent feature may cost


@dataclass(frozen=True)
class Cost:
    """The bar with or without a feature; instructions are None where they cannot be counted.

    Parameters
    ----------
    feature
        Name of the feature.
    present
        Whether the bar has it.
    seconds
        Run time, or None.
    instructions
        Instructions of the frame.
    bytes
        Memory, or None.
    search_instructions
        Of these in the search for the equilibrium.
    product_per_cell
        Instructions of the product's kernel alone, a pass and a cell.
    evaluation_per_cell
        Instructions of the evaluation's kernel alone, a pass and a cell.
    cells
        Number of cells.
    newton_iterations
        Newton iterations of the frame.
    evaluations
        Evaluations of the frame.
    products
        Products of the frame.
    note
        A remark.
    """

    feature: str
    present: bool
    seconds: float | None
    instructions: int | None
    bytes: int | None
    search_instructions: int | None = None
    product_per_cell: float | None = None
    evaluation_per_cell: float | None = None
    cells: int | None = None
    newton_iterations: int | None = None
    evaluations: int | None = None
    products: int | None = None
    note: str = ""


@dataclass(frozen=True)
class Absence:
    """A scene without some features on the daemon, and on a yardstick that was built without them.

    Parameters
    ----------
    left_out
        What the yardstick lacks.
    scene
        Name of the scene.
    instructions
        Instructions of the hot loops, the search for the equilibrium.
    yardstick_instructions
        Those of the yardstick.
    kernels
        Instructions of the fused passes, here and there.
    """

    left_out: str
    scene: str
    instructions: int
    yardstick_instructions: int
    kernels: Mapping[str, tuple[int, int]]

    @property
    def share(self) -> float:
        """What the absent features cost, as a share of the yardstick's instructions in the hot loops."""
        return self.instructions / self.yardstick_instructions - 1.0


@dataclass(frozen=True)
class EconomyReport:
    """The report of economy.

    Parameters
    ----------
    rows
        What each feature costs.
    absences
        Proofs of absence.
    uncounted
        Why no instruction was counted, or None where they were.
    """

    rows: tuple[Cost, ...]
    absences: tuple[Absence, ...]
    uncounted: str | None


def economy(
    yardsticks: tuple[Path, ...] = (),
    features: tuple[Feature, ...] = FEATURES,
    say: Callable[[str], None] = lambda _: None,
) -> EconomyReport:
    """Measure every feature.

    Parameters
    ----------
    yardsticks
        Daemons built with `LAPPET_LEAVE_OUT`, to hold the plain scene against.
    features
        The features.
    say
        Is told of every solve.

    Returns
    -------
    EconomyReport
        The report.

    Raises
    ------
    RefusedError
        If a scene does not converge.
    """
    reasons: list[str] = []
    rows = []
    base = plain()
    say("the plain bar")
    absent = _cost(features[0], False, (base,), reasons)
    for feature in features:
        own = base if feature.base is None else feature.base()
        without = absent if feature.base is None else _cost(feature, False, (own,), reasons)
        rows.append(replace(without, feature=feature.name, note=feature.what))
        if feature.put_into is None:
            continue
        say(feature.name)
        program = feature.put_into(own)
        programs = (program,) if feature.coarse_program is None else (program, feature.coarse_program(program))
        rows.append(_cost(feature, True, programs, reasons))
    absences = []
    for binary in yardsticks:
        say(f"yardstick {binary}")
        absences.append(absence(base, "the plain bar", binary, str(binary)))
    return EconomyReport(tuple(rows), tuple(absences), reasons[0] if reasons else None)


def absence(program: Program, scene: str, yardstick: Path, left_out: str) -> Absence:
    """Count the hot loops of a program on the installed daemon and on a yardstick.

    Parameters
    ----------
    program
        The program.
    scene
        Name of the scene.
    yardstick
        The yardstick's program.
    left_out
        What it lacks.

    Returns
    -------
    Absence
        Both counts.

    Raises
    ------
    RefusedError
        If the two did not take the same iterations: then the counts do not compare.
    """
    whole, bare = count_instructions(program), count_instructions(program, yardstick)
    passes = ("evaluations", "linearizations", "products")
    if any(whole.work[each] != bare.work[each] for each in passes):
        raise refused(ProblemCode.REPORT_NOT_COMPARABLE, yardstick)
    kernels = {name: (whole.kernels[name], bare.kernels[name]) for name in whole.kernels}
    return Absence(left_out, scene, whole.search, bare.search, kernels)


def _cost(feature: Feature, present: bool, programs: tuple[Program, ...], reasons: list[str]) -> Cost:
    """The cost of solving the programs; counts of work are the first one's."""
    found = [_native(program) for program in programs]
    counts: list[Instructions] = []
    try:
        counts = [count_instructions(program) for program in programs]
    except NoCounterError as error:
        reasons.append(str(error))
    first = found[0]
    work = first.work
    return Cost(
        feature.name,
        present,
        seconds=sum(each.seconds for each in found),
        instructions=sum(count.frame for count in counts) if counts else None,
        bytes=sum(each.bytes for each in found),
        search_instructions=sum(count.search for count in counts) if counts else None,
        product_per_cell=_per_cell(counts, "product", "products", first),
        evaluation_per_cell=_per_cell(counts, "evaluate", "evaluations", first),
        cells=first.cells,
        newton_iterations=first.newton_iterations,
        evaluations=int(work["evaluations"]),
        products=int(work["products"]),
        note=feature.what,
    )


def _per_cell(counts: list[Instructions], kernel: str, passes: str, first: _Native) -> float | None:
    """Instructions of a pass; None where nothing was counted, or where passes were over a region of the cells."""
    if not counts or first.active_cells < first.cells:
        return None
    return counts[0].kernels[kernel] / counts[0].work[passes] / first.cells


@dataclass(frozen=True)
class _Native:
    seconds: float
    bytes: int
    cells: int
    active_cells: int
    newton_iterations: int
    work: dict[str, float]


def _native(program: Program) -> _Native:
    """Solve the first frame as it is solved every day, several times from rest."""
    seconds = []
    with SolverDaemon() as daemon, SolverClient(daemon.address, daemon.token) as client:
        for _ in range(REPEATS):
            client.open(program.settings, program.bones)
            lattice = client.set_epoch(program.epochs[0], program.grips[0], program.landmarks_at[0])
            frame = client.solve(program.frames[0])
            if not frame.diagnostics.converged:
                raise refused(ProblemCode.REPORT_NOT_CONVERGED, "", frame.reason)
            seconds.append(float(frame.diagnostics.seconds.total))
    assert frame.state is not None
    carried = frame.nbytes + frame.state.nbytes
    return _Native(
        median(seconds),
        int(lattice.bytes) + carried,
        int(lattice.cells),
        int(frame.diagnostics.active_cells),
        int(frame.diagnostics.newton),
        asdict(frame.diagnostics.work),
    )
