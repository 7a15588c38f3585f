"""Solve and draw the designs of the flap library at their defaults, each on a flat patch of the default skin."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from lappet.core.problem_code import ProblemCode
from lappet.designs.library import DESIGNS, library_design
from lappet.designs.library_operation import SPACING, flap_on_patch
from lappet.output.report import write_report
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.plates.draw_plate import PlateOptions, draw_plate
from lappet.reports.report_files import head, make_folder, write_json
from lappet.usd.stage import write_procedure

RESULTS = "atlas.json"
DPI = 150  # of the plates, for pages of the site


@dataclass(frozen=True)
class AtlasRow:
    """What a design gave, in its last frame; forces, lengths and tensions with their estimated errors.

    Parameters
    ----------
    name
        Name of the design.
    frames
        Frames that converged.
    of_frames
        Frames of the operation.
    seconds
        Run time of the solve with its estimate of errors, in seconds.
    total_force
        Sum of the forces of all sutures in mN, and its error.
    greatest_force
        Greatest force of a suture in mN, and its error.
    greatest_suture
        Name of that suture.
    scar_length
        Length of the scar in mm.
    open_area
        Area of the wound that is still open in mm².
    dog_ear
        Greatest height of a dog-ear in mm, None where none is measured.
    tension
        Greatest mean tension of the skin in kPa, and its error, None where none is measured.
    overlap
        Depth in mm by which tissue lies in other tissue at the end, 0 for none.
    """

    name: str
    frames: int
    of_frames: int
    seconds: float
    total_force: tuple[float, float | None] | None
    greatest_force: tuple[float, float | None] | None
    greatest_suture: str
    scar_length: float
    open_area: float
    dog_ear: float | None
    tension: tuple[float, float | None] | None
    overlap: float


def run_atlas(
    names: Sequence[str],
    folder: Path,
    say: Callable[[str], None],
    *,
    spacing: float = SPACING,
    pictures: bool = True,
) -> tuple[list[AtlasRow], list[Path]]:
    """Solve and draw designs.

    Parameters
    ----------
    names
        Designs of the library; none for all of them.
    folder
        Where to; made if needed. Known frames are looked up, so that a stopped run goes on.
    say
        Called with a line of text for every design.
    spacing
        Edge of the lattice's cells in mm.
    pictures
        Whether to draw a painted plate of each.

    Returns
    -------
    tuple[list[AtlasRow], list[Path]]
        A row for each design, and the files that were written.

    Raises
    ------
    RefusedError
        If the library has no design of a name, or a solve or picture is refused.
    """
    chosen = [library_design(name).name for name in names] or list(DESIGNS)
    make_folder(folder)
    rows, files = [], []
    for name in chosen:
        source, cache = folder / f"{name}.usda", folder / f"{name}.usdc"
        write_procedure(flap_on_patch(name, spacing=spacing), source)
        result = solve_procedure(source, cache)
        write_report(result, folder / f"{name}.json")
        rows.append(atlas_row(name, result))
        files += [source, cache, folder / f"{name}.json"]
        say(f"{name}: {rows[-1].frames} of {rows[-1].of_frames} frames converged, {rows[-1].seconds:.0f} s.")
        if pictures and result.output is not None:
            plate = folder / f"{name}.png"
            draw_plate([cache], [plate], PlateOptions(style="painted", dpi=DPI))
            files.append(plate)
    results = folder / RESULTS
    write_json(results, head(), rows, spacing_mm=spacing)
    return rows, [*files, results]


def atlas_row(name: str, result: SolveResult) -> AtlasRow:
    """Take what the atlas shows of a solved design.

    Parameters
    ----------
    name
        Name of the design.
    result
        Its solve.

    Returns
    -------
    AtlasRow
        The row.
    """
    last = result.measures[-1] if result.measures else None
    sums = last.sums if last else None
    tension = last.mean_tension if last else None
    time = result.frames[-1].solved.time if result.frames else 0.0
    seams = [row for row in result.seams if row.time == time]
    ears = [ear for row in seams for ear in (row.start_dog_ear_mm, row.end_dog_ear_mm) if ear is not None]
    deep = [float(note.value) for note in result.notes if note.code is ProblemCode.TISSUE_IN_TISSUE]
    return AtlasRow(
        name,
        sum(frame.solved.converged for frame in result.frames),
        len(list(result.procedure.frames())),
        result.wall_seconds,
        (sums.total_mn, sums.total_error_mn) if sums else None,
        (sums.greatest_mn, sums.greatest_error_mn) if sums else None,
        (sums.greatest_suture or "") if sums else "",
        sum(row.scar_length_mm for row in seams),
        sum(row.open_area_mm2 for row in seams),
        max(ears) if ears else None,
        (tension.tension, tension.error) if tension else None,
        max(deep, default=0.0),
    )
