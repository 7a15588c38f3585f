"""Measure what the tissue beyond the rim would change, operation by operation, and write the results."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from lappet.core.durable import write_whole
from lappet.models.regional_flaps import REGIONAL_FLAPS
from lappet.reports.report_files import described, head, make_folder, write_csv, write_json
from lappet.reports.surroundings.measurement import SurroundingsRow, measure_surroundings
from lappet.reports.surroundings.table import surroundings_table

RESULTS = "surroundings.json"


def run_surroundings(
    names: Sequence[str], folder: Path, reach: float | None, say: Callable[[str], None]
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
    say
        Called with a line of text for every solve.

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
    for name in names or list(REGIONAL_FLAPS):
        rows.append(measure_surroundings(name, folder, reach, say))
        write_json(files[0], circumstances, rows)  # after each: a stopped run keeps what it has
    write_csv(files[1], rows)
    text = f"# Surroundings\n\n{described(circumstances)}\n\n{surroundings_table(rows)}"
    write_whole(files[2], text.encode())
    return rows, files
