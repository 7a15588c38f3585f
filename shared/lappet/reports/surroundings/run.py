"""Measure what the tissue beyond the rim would change, operation by operation, and write the results."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lappet.core.durable import write_whole
from lappet.models.regional_flaps import REGIONAL_FLAPS
from lappet.reports.report_files import described, head, make_folder, write_csv, write_json
from lappet.reports.report_progress import ReportProgress
from lappet.reports.surroundings.measurement import SurroundingsRow, measure_surroundings, solves_of
from lappet.reports.surroundings.table import surroundings_table

RESULTS = "surroundings.json"


def run_surroundings(
    names: Sequence[str], folder: Path, reach: float | None, progress: ReportProgress
) -> tuple[list[SurroundingsRow], list[Path]]:
    """Measure operations.

    Parameters
    ----------
    names
        Operations on models, or files of procedures; none for all operations on models.
    folder
        Where to; made if needed. Known frames are looked up, so that a stopped run goes on.
    reach
        How many times as far as usual the wider cut-out of each model reaches; None for none.
    progress
        Is told how the solves go, with a line of text for each.

    Returns
    -------
    tuple[list[SurroundingsRow], list[Path]]
        A row for each, and the files that were written.

    Raises
    ------
    RefusedError
        If one cannot be measured: see `measure_surroundings`.
    """
    make_folder(folder)
    circumstances = head()
    files = [folder / RESULTS, folder / "surroundings.csv", folder / "surroundings.md"]
    rows: list[SurroundingsRow] = []
    wanted = names or list(REGIONAL_FLAPS)
    progress.begin(sum(solves_of(name, reach) for name in wanted))
    for name in wanted:
        rows.append(measure_surroundings(name, folder, reach, progress))
        write_json(files[0], circumstances, rows)  # after each: a stopped run keeps what it has
    write_csv(files[1], rows)
    text = f"# Surroundings\n\n{described(circumstances)}\n\n{surroundings_table(rows)}"
    write_whole(files[2], text.encode())
    return rows, files
