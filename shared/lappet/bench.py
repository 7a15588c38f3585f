"""Measures a solve: `python -m lappet.bench [PROCEDURE ...] -o DIR` prints a table and writes DIR/scenes.json.

Every frame is solved by a daemon of its own from an empty store, so nothing is looked up. A row of the JSON has the
scene, its lattice (cells, nodes, …, of the epoch with most cells), the time in seconds as a user waits for it, Newton
and PCG iterations, the daemon's peak memory in bytes, and the largest residual and suture gap (mm) of any frame.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import click

from lappet.refused import RefusedError

MEBIBYTE = 2.0**20


@dataclass(frozen=True)
class SceneMeasure:
    """One row: what a scene cost.

    seconds: wall time of everything, compiling and writing the cache included; solver_seconds: the daemon's own, of
    which linear_seconds in the linear solver. newton_iteration_s: solver_seconds per Newton iteration. bytes_per_cell:
    peak memory over cells. converged: every frame of the timeline was solved.
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
    seconds: float
    solver_seconds: float
    linear_seconds: float
    newton_iterations: int
    pcg_iterations: int
    newton_iteration_s: float
    residual: float
    largest_gap_mm: float
    minimum_j: float
    peak_bytes: float
    bytes_per_cell: float


def measure(
    scene: str, spacing: float, threads: int, epochs: int, seconds: float, headers: Sequence[Mapping[str, Any]]
) -> SceneMeasure:
    """The row of a scene from the headers of its solved frames (fields of the message `frame`, PROTOCOL.md, and
    `lattice`); `converged` is whether all these frames are. Raises RefusedError where there is no frame.
    """
    if not headers:
        raise RefusedError(f"{scene}: no frame was solved, so there is nothing to measure.")
    lattices = [header["lattice"] for header in headers]
    largest = max(lattices, key=lambda lattice: int(lattice["cells"]))
    newton = sum(int(header["newton"]) for header in headers)
    solver_seconds = sum(float(header["seconds"]["total"]) for header in headers)
    peak = max(float(header["peak_bytes"]) for header in headers)
    reasons = [str(header.get("reason") or "no reason given") for header in headers if not header["converged"]]
    return SceneMeasure(
        scene=scene,
        spacing_mm=spacing,
        converged=not reasons,
        reason=reasons[0] if reasons else None,
        frames=len(headers),
        epochs=epochs,
        cells=int(largest["cells"]),
        grid_cells=int(largest["grid_cells"]),
        mesh_cells=int(largest["mesh_cells"]),
        nodes=int(largest["nodes"]),
        blocks=int(largest["blocks"]),
        fine_voxels=int(largest["fine_voxels"]),
        threads=threads,
        seconds=seconds,
        solver_seconds=solver_seconds,
        linear_seconds=sum(float(header["seconds"]["linear"]) for header in headers),
        newton_iterations=newton,
        pcg_iterations=sum(int(header["pcg"]) for header in headers),
        newton_iteration_s=solver_seconds / max(newton, 1),
        residual=max(float(header["residual"]) for header in headers),
        largest_gap_mm=max(float(header["largest_gap"]) for header in headers),
        minimum_j=min(float(header["minimum_j"]) for header in headers),
        peak_bytes=peak,
        bytes_per_cell=peak / max(int(largest["cells"]), 1),
    )


def circumstances() -> dict[str, Any]:
    """What the numbers were taken on: the machine, the release of lappet, the revision of the checkout, the date."""
    from lappet import __version__
    from lappet.machine import machine

    return {
        **machine(),
        "lappet": __version__,
        "revision": revision(),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }


def revision() -> str | None:
    """The git revision of the checkout this file lies in, with `+` where files were changed; None outside one."""
    folder = Path(__file__).resolve().parent
    try:
        head = subprocess.run(
            ["git", "rev-parse", "--short=12", "HEAD"],
            cwd=folder,
            capture_output=True,
            text=True,
            check=True,
            timeout=30,
        ).stdout.strip()
        dirty = subprocess.run(["git", "diff", "--quiet", "HEAD"], cwd=folder, check=False, timeout=30).returncode
    except (OSError, subprocess.SubprocessError):
        return None
    return head + ("+" if dirty else "")


def solve_scene(procedure: Path, spacing: float, folder: Path) -> SceneMeasure:
    """Solves every frame of a procedure file at `spacing` mm into `folder` and measures it.

    Raises RefusedError or ProcedureError where the procedure cannot be solved at all.
    """
    from lappet.solve import solve_procedure
    from lappet.store import FrameStore

    cache = folder / f"{procedure.stem}.usdc"
    with tempfile.TemporaryDirectory(prefix="lappet-bench-") as store:
        result = solve_procedure(procedure, cache, spacing=spacing, store=FrameStore(Path(store)))
    headers = [frame.header for frame in (*result.frames, *([result.failed] if result.failed else []))]
    threads = result.program.settings.threads or len(os.sched_getaffinity(0))
    epochs = len(result.program.epochs)
    row = measure(procedure.stem, spacing, threads, epochs, result.wall_seconds, headers)
    if result.complete or not row.converged:
        return row
    raise RefusedError(f"{procedure.stem}: {result.reason or 'the solve was stopped.'}")


def print_rows(rows: Sequence[SceneMeasure]) -> None:
    """Prints the table for people."""
    from rich.console import Console
    from rich.table import Table

    table = Table(title="Solves from an empty store")
    for name in ("scene", "spacing", "cells", "nodes", "frames", "Newton", "PCG", "time", "per Newton", "peak memory"):
        table.add_column(name, justify="left" if name == "scene" else "right")
    for row in rows:
        table.add_row(
            row.scene,
            f"{row.spacing_mm:g} mm",
            f"{row.cells}",
            f"{row.nodes}",
            f"{row.frames}",
            f"{row.newton_iterations}",
            f"{row.pcg_iterations}",
            f"{row.seconds:.1f} s",
            f"{row.newton_iteration_s * 1e3:.0f} ms",
            f"{row.peak_bytes / MEBIBYTE:.0f} MiB",
        )
    Console().print(table)


@click.command(context_settings={"help_option_names": ["-h", "--help"]})
@click.argument("procedures", nargs=-1, required=True, type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o", "--output", "folder", default=Path("build/bench"), show_default=True, type=click.Path(path_type=Path)
)
@click.option("--spacing", default=1.0, show_default=True, type=click.FloatRange(min=0, min_open=True), help="In mm.")
def main(procedures: tuple[Path, ...], folder: Path, spacing: float) -> None:
    """Measure the solve of each of PROCEDURES; exits with 1 where a frame does not converge."""
    folder.mkdir(parents=True, exist_ok=True)
    try:
        rows = [solve_scene(procedure, spacing, folder) for procedure in procedures]
    except RefusedError as error:
        sys.exit(str(error))
    print_rows(rows)
    target = folder / "scenes.json"
    target.write_text(
        json.dumps({"machine": circumstances(), "rows": [asdict(row) for row in rows]}, indent=2) + "\n",
        encoding="utf-8",
    )
    print(f"written: {target}")
    for row in rows:
        if not row.converged:
            sys.exit(f"{row.scene}: {row.reason}")


if __name__ == "__main__":
    main()
