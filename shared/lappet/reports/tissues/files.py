"""The files of `lappet report tissues`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lappet.core.durable import write_whole
from lappet.reports.report_files import make_folder
from lappet.reports.tissues.figure import plot_tissues
from lappet.reports.tissues.page import tissue_page
from lappet.tissue.presets import PRESETS
from lappet.tissue.uniaxial import curve


def write_tissues(folder: Path) -> list[Path]:
    """Write the tables, the curves as numbers and their figure.

    Parameters
    ----------
    folder
        Where; made if needed.

    Returns
    -------
    list[Path]
        The files: tissues.md, tissue_curves.csv, images/tissue_curves.png.

    Raises
    ------
    RefusedError
        If the folder cannot be made or matplotlib is missing.
    """
    make_folder(folder / "images")
    paths = [folder / "tissues.md", folder / "tissue_curves.csv", folder / "images" / "tissue_curves.png"]
    write_whole(paths[0], tissue_page().encode())
    write_whole(paths[1], _numbers().encode())
    plot_tissues(paths[2])
    return paths


def _numbers() -> str:
    lines = ["preset,stretch,along_kpa,across_kpa"]
    for name, preset in PRESETS.items():
        stretches = np.linspace(1.0, preset.published.last if preset.published else 1.4, 41)
        columns = (stretches, *(curve(preset.unstretched, stretches, axis) for axis in (0, 1)))
        lines += [f"{name},{s:.4f},{along:.6g},{across:.6g}" for s, along, across in zip(*columns, strict=True)]
    return "\n".join([*lines, ""])
