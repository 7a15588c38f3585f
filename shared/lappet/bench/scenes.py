"""Whole examples, solved as a user solves them: every frame by a daemon of its own from an empty store."""

from __future__ import annotations

import hashlib
import tempfile
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.bench.circumstances import cores
from lappet.core.problem import RefusedError, refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.client import SolverClient
from lappet.daemon.frame_diagnostics import Diagnostics
from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.solve_to_cache import solve_procedure
from lappet.program.program import Program
from lappet.program.settings import SolverSettings
from lappet.solve.solve_frames import FrameResult
from lappet.solve.store import FrameStore

STATE_GRAIN = 0.01  # mm


@dataclass(frozen=True)
class SceneMeasure:
    """What a scene cost.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing_mm
        Lattice spacing.
    converged
        Whether every frame of the timeline was solved.
    reason
        Why not, or None.
    frames
        Number of frames.
    epochs
        Number of epochs.
    cells
        Number of cells.
    grid_cells
        Number of cells of the regular grid.
    mesh_cells
        Number of cells of the explicit mesh.
    nodes
        Number of nodes.
    blocks
        Number of blocks.
    fine_voxels
        Number of fine voxels.
    threads
        Number of threads.
    isa
        Instruction set.
    seconds
        Wall time of everything, compiling and writing the cache included.
    solver_seconds
        The daemon's own time.
    linear_seconds
        Of these in the linear solver.
    stability_seconds
        Of these in the search for the softest displacement.
    newton_iterations
        Newton iterations of all frames.
    newton_median
        Median of a frame.
    pcg_iterations
        Iterations of conjugate gradients of all frames.
    newton_iteration_s
        Seconds of the daemon per Newton iteration.
    update_state_ms
        Milliseconds of one evaluation and one linearization, mean over all frames.
    product_ms
        Milliseconds of one product, mean over all frames.
    residual
        Largest relative residual.
    largest_gap_mm
        Largest gap.
    minimum_j
        Smallest ratio of volumes.
    peak_bytes
        Peak memory.
    bytes_per_cell
        Peak memory over cells.
    state
        `state_hash` of the last frame.
    """

    scene: str
    spacing_mm: float
    converged: bool
    reason: str | None
    frames: int
    epochs: int
    cells: int
    grid_cells: int
    mesh_cells: int
    nodes: int
    blocks: int
    fine_voxels: int
    threads: int
    isa: str
    seconds: float
    solver_seconds: float
    linear_seconds: float
    stability_seconds: float
    newton_iterations: int
    newton_median: float
    pcg_iterations: int
    newton_iteration_s: float
    update_state_ms: float
    product_ms: float
    residual: float
    largest_gap_mm: float
    minimum_j: float
    peak_bytes: float
    bytes_per_cell: float
    state: str


def measure(
    scene: str,
    spacing: float,
    threads: int,
    isa: str,
    epochs: int,
    seconds: float,
    frames: Sequence[SolvedFrame],
    state: str = "",
) -> SceneMeasure:
    """Make the row of a scene from its solved frames.

    Parameters
    ----------
    scene
        Name of the scene.
    spacing
        Lattice spacing in mm.
    threads
        Number of threads.
    isa
        Instruction set.
    epochs
        Number of epochs.
    seconds
        Wall time of everything.
    frames
        The frames.
    state
        `state_hash` of the last frame.

    Returns
    -------
    SceneMeasure
        The row; `converged` is whether all these frames are.

    Raises
    ------
    RefusedError
        If there is no frame.
    """
    if not frames:
        raise refused(ProblemCode.BENCH_NO_FRAME, scene)
    largest = max((each.lattice for each in frames if each.lattice is not None), key=lambda lattice: lattice.cells)
    said = [each.diagnostics for each in frames]
    newton = [each.newton for each in said]
    solver_seconds = sum(each.seconds.total for each in said)
    peak = max(each.peak_bytes for each in said)
    reasons = [each.reason or "no reason given" for each in said if not each.converged]
    update, product = pass_times(said)
    return SceneMeasure(
        scene=scene,
        spacing_mm=spacing,
        converged=not reasons,
        reason=reasons[0] if reasons else None,
        frames=len(frames),
        epochs=epochs,
        cells=largest.cells,
        grid_cells=largest.grid_cells,
        mesh_cells=largest.mesh_cells,
        nodes=largest.nodes,
        blocks=largest.blocks,
        fine_voxels=largest.fine_voxels,
        threads=threads,
        isa=isa,
        seconds=seconds,
        solver_seconds=solver_seconds,
        linear_seconds=sum(each.seconds.linear for each in said),
        stability_seconds=sum(each.seconds.stability for each in said),
        newton_iterations=sum(newton),
        newton_median=float(np.median(newton)),
        pcg_iterations=sum(each.pcg for each in said),
        newton_iteration_s=solver_seconds / max(sum(newton), 1),
        update_state_ms=update,
        product_ms=product,
        residual=max(each.residual for each in said),
        largest_gap_mm=max(each.largest_gap for each in said),
        minimum_j=min(each.minimum_j for each in said),
        peak_bytes=peak,
        bytes_per_cell=peak / max(largest.cells, 1),
        state=state,
    )


def pass_times(said: Sequence[Diagnostics]) -> tuple[float, float]:
    """Compute the milliseconds of a state update (an evaluation and a linearization) and of a product.

    Parameters
    ----------
    said
        How the frames were solved.

    Returns
    -------
    tuple[float, float]
        Both, means over the frames.
    """

    def mean(seconds: str, count: str) -> float:
        total = sum(getattr(each.work, seconds) for each in said)
        return 1e3 * total / max(sum(getattr(each.work, count) for each in said), 1)

    update = mean("evaluation_seconds", "evaluations") + mean("linearization_seconds", "linearizations")
    return update, mean("product_seconds", "products")


def _displacements(program: Program, frame: FrameResult) -> NDArray[np.float64]:
    """Of the surface's points, (n, 3) mm."""
    rest = next(epoch.surface.points for epoch in program.epochs if epoch.index == frame.constraints.epoch)
    return np.asarray(frame.solved.points, np.float64) - rest


def state_hash(displacements: NDArray[Any]) -> str:
    """Name a result: a digest of displacements rounded to `STATE_GRAIN`.

    The same program, scene and instruction set give the same one on any number of threads; another one says that the
    result changed, be it by rounding. The largest displacement follows it, to say by how much.

    Parameters
    ----------
    displacements
        Displacements in mm, shape (n, 3).

    Returns
    -------
    str
        The name.
    """
    rounded = np.rint(np.asarray(displacements, np.float64) / STATE_GRAIN).astype("<i8")
    digest = hashlib.blake2b(rounded.tobytes(), digest_size=6).hexdigest()
    largest = float(np.sqrt((np.asarray(displacements, np.float64) ** 2).sum(axis=1).max(initial=0.0)))
    return f"{digest} {largest:.3f} mm"


def daemon_isa() -> str:
    """Find the instruction set that the daemon chooses here.

    Returns
    -------
    str
        Its name.
    """
    with SolverClient() as client:
        return str(client.welcome["isa"])


def solve_scene(procedure: Path, spacing: float, folder: Path) -> SceneMeasure:
    """Solve every frame of a procedure's file, and measure it.

    Parameters
    ----------
    procedure
        The file.
    spacing
        Lattice spacing in mm.
    folder
        Folder of the store and the cache.

    Returns
    -------
    SceneMeasure
        The row.

    Raises
    ------
    RefusedError
        If the procedure cannot be solved at all.
    """
    cache = folder / f"{procedure.stem}.usdc"
    with tempfile.TemporaryDirectory(prefix="lappet-bench-") as store:
        result = solve_procedure(procedure, cache, SolverSettings(spacing=spacing), store=FrameStore(Path(store)))
    frames = [*result.frames, *([result.failed] if result.failed else [])]
    threads = result.program.settings.threads or cores()
    row = measure(
        procedure.stem,
        spacing,
        threads,
        daemon_isa(),
        len(result.program.epochs),
        result.wall_seconds,
        [frame.solved for frame in frames],
        state_hash(_displacements(result.program, frames[-1])) if frames else "",
    )
    if result.reason is None or not row.converged:
        return row
    raise RefusedError([replace(result.reason, prim=procedure.stem)])


@dataclass(frozen=True)
class Scene:
    """An example and the spacings that it is measured at.

    Parameters
    ----------
    procedure
        The procedure's file.
    moderate
        Spacing of the moderate size in mm.
    fine
        Spacing of the fine size in mm, or None.
    """

    procedure: Path
    moderate: float
    fine: float | None


def suite(examples: Path) -> list[Scene]:
    """List the scenes of `examples/sizes.toml`.

    The file has by folder name the tables `moderate` and, where there is one, `fine`, each with a `spacing` in mm.

    Parameters
    ----------
    examples
        Folder of the examples.

    Returns
    -------
    list[Scene]
        The scenes.

    Raises
    ------
    RefusedError
        If the file lists what is not there.
    """
    listed = examples / "sizes.toml"
    sizes = tomllib.loads(listed.read_text("utf-8")) if listed.is_file() else {"z_plasty": {"moderate": {"spacing": 1}}}
    scenes = []
    for name, size in sizes.items():
        procedure = examples / name / f"{name}.usda"
        if not procedure.is_file() or "spacing" not in size.get("moderate", {}):
            raise refused(ProblemCode.BENCH_SIZES, listed, name, file=procedure)
        fine = size.get("fine", {}).get("spacing")
        scenes.append(Scene(procedure, float(size["moderate"]["spacing"]), None if fine is None else float(fine)))
    return scenes
