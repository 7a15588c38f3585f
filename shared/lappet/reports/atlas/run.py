"""Solve and draw the designs of the flap library: at their defaults on a flat patch, and on models of the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from lappet.designs.library import DESIGNS, library_design
from lappet.designs.library_operation import SPACING, flap_on_patch
from lappet.models.body_package import COMMAND, body_package, is_fetched
from lappet.models.regional_flaps import REGIONAL_FLAPS, flap_on_model
from lappet.output.report import write_report
from lappet.output.solve_to_cache import SolveResult, solve_procedure
from lappet.plates.draw_plate import PlateOptions, draw_plate
from lappet.procedure import Procedure
from lappet.program.compile import DEFAULT
from lappet.reports.atlas.rows import CONTACT_ROWS, MODEL_ROWS, AtlasRow, ModelRow, atlas_row, model_row
from lappet.reports.report_files import head, make_folder, write_json
from lappet.reports.report_progress import ReportProgress
from lappet.solve.solve_frames import SolveObserver
from lappet.usd.stage import write_procedure

RESULTS = "atlas.json"
DPI = 150  # of the plates, for pages of the site
PATCH, MODELS, BOTH = "patch", "models", "both"
PLACES = (BOTH, PATCH, MODELS)  # where designs are solved


def run_atlas(
    names: Sequence[str],
    folder: Path,
    progress: ReportProgress,
    *,
    spacing: float = SPACING,
    pictures: bool = True,
    places: str = BOTH,
    self_contact: bool = False,
) -> tuple[list[AtlasRow], list[Path]]:
    """Solve and draw designs.

    Parameters
    ----------
    names
        Designs of the library; none for all of them.
    folder
        Where to; made if needed. Known frames are looked up, so that a stopped run goes on.
    progress
        Is told how the solves go, with a line of text for every operation.
    spacing
        Edge of the lattice's cells in mm on the patch; each model has its own.
    pictures
        Whether to draw a painted plate of each.
    places
        "patch" for the flat patch, "models" for the models of the body, "both"; the models are left out of both where
        their package is not there.
    self_contact
        Whether to keep tissue from passing through tissue on the models. Errors are not estimated then, as coarser
        lattices often find no way where tissue touches.

    Returns
    -------
    tuple[list[AtlasRow], list[Path]]
        A row for each operation, and the files that were written.

    Raises
    ------
    RefusedError
        If the library has no design of a name, the models are asked for and their package is not there, or a solve or
        picture is refused.
    """
    chosen = [library_design(name).name for name in names] or list(DESIGNS)
    regional = _regional(chosen, places, progress)
    make_folder(folder)
    on_patch = chosen if places != MODELS else []
    progress.begin(len(on_patch) + len(regional))
    rows: list[AtlasRow] = []
    on_models: list[ModelRow] = []
    files: list[Path] = []
    for name in on_patch:
        observer = progress.solve(name)
        result, written = _solved(name, flap_on_patch(name, spacing=spacing), folder, pictures, observer)
        rows.append(atlas_row(name, result))
        progress.say(_line(name, rows[-1]))
        files += written
    for name in regional:
        observer = progress.solve(name)
        result, written = _solved(name, flap_on_model(name), folder, pictures, observer, self_contact)
        flap = REGIONAL_FLAPS[name]
        on_models.append(model_row(name, flap.design, flap.model, result))
        progress.say(_line(name, on_models[-1].measured))
        files += written
    results = folder / RESULTS
    kept = {CONTACT_ROWS if self_contact else MODEL_ROWS: [row.flat() for row in on_models]}
    write_json(results, head(), rows, spacing_mm=spacing, **kept)
    return [*rows, *(row.measured for row in on_models)], [*files, results]


def _regional(designs: Sequence[str], places: str, progress: ReportProgress) -> list[str]:
    """The operations of designs on models, none where they are not wanted or cannot be made."""
    wanted = [flap.name for flap in REGIONAL_FLAPS.values() if flap.design in designs and places != PATCH]
    if not wanted:
        return []
    if places == MODELS:
        body_package()
    elif not is_fetched():
        progress.say(f"Nothing is solved on a model of the body: their package is not there. `{COMMAND}` downloads it.")
        return []
    return wanted


def _solved(
    name: str,
    procedure: Procedure,
    folder: Path,
    pictures: bool,
    observer: SolveObserver,
    self_contact: bool = False,
) -> tuple[SolveResult, list[Path]]:
    """Solve a procedure and draw it; the files are in the folder under its name."""
    source, cache, report = (folder / f"{name}.{ending}" for ending in ("usda", "usdc", "json"))
    write_procedure(procedure, source)
    settings = replace(DEFAULT, self_contact=self_contact)
    result = solve_procedure(source, cache, settings, observer=observer, error_estimate=not self_contact)
    write_report(result, report)
    files = [source, cache, report]
    if pictures and result.output is not None:
        plate = folder / f"{name}.png"
        draw_plate([cache], [plate], PlateOptions(style="painted", dpi=DPI))
        files.append(plate)
    return result, files


def _line(name: str, row: AtlasRow) -> str:
    return f"{name}: {row.frames} of {row.of_frames} frames converged, {row.seconds:.0f} s."
