"""Run the campaign of convergence and write its files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lappet.reports.convergence.files import totals_table, write_convergence
from lappet.reports.convergence.measurement import compare_twins, run_scenes
from lappet.reports.convergence.scenes import scenes, twins
from lappet.reports.report_files import head, make_folder


def run_convergence(
    folder: Path, quick: bool, say: Callable[[str], None] = lambda _: None
) -> tuple[str, bool, list[Path]]:
    """Compare frames at the default settings with exact ones and write the files.

    Parameters
    ----------
    folder
        Folder of the files.
    quick
        Whether to leave out the large patches and the moduli between.
    say
        Is told of every scene.

    Returns
    -------
    tuple[str, bool, list[Path]]
        The table of totals, whether every frame is right, and the files.

    Raises
    ------
    RefusedError
        If there is no daemon or no folder.
    """
    make_folder(folder)
    circumstances = head()
    rows = list(run_scenes(scenes(quick), say))
    for one, two in twins(quick):
        rows += compare_twins(one, two)
    return totals_table(rows), all(row.ok for row in rows), write_convergence(folder, circumstances, rows)
