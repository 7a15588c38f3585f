"""Run the report of error against time: which scenes there are, and at which spacings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to
from lappet.reports.box_scenes import BOXES
from lappet.reports.error_time.files import write_error_time
from lappet.reports.error_time.measurement import Scene, error_time
from lappet.reports.error_time.procedure_scenes import ProcedureScene, scalp_flap, z_plasty_scene
from lappet.reports.error_time.totals import totals
from lappet.reports.report_files import head, make_folder
from lappet.usd.stage import read_procedure

NAMES = (*(scene.name for scene in BOXES), "z-plasty", "scalp-flap")


def run_error_time(
    names: Sequence[str], folder: Path, quick: bool, say: Callable[[str], None] = lambda _: None
) -> tuple[str, list[Path]]:
    """Measure scenes and write the files.

    Parameters
    ----------
    names
        Names of the scenes; all where none is named.
    folder
        Folder of the files.
    quick
        Whether to take a coarser reference, and vary each setting alone.
    say
        Is told of every solve.

    Returns
    -------
    tuple[str, list[Path]]
        The totals as sentences, and the files.

    Raises
    ------
    RefusedError
        If a name is no scene, or a reference cannot be solved.
    """
    scenes = [find_scene(name) for name in names or NAMES]
    make_folder(folder)
    circumstances = head()
    reports = []
    for scene in scenes:
        chosen = scene
        if quick and scene.is_box:
            chosen = replace(scene, reference=tuple(2.0 * h for h in scene.reference), spacings=scene.spacings[:2])  # type: ignore[type-var]
        elif quick:
            chosen.spacings = scene.spacings[:2]  # type: ignore[misc]
        reports.append(error_time(chosen, connect_to(None), product=scene.every_combination and not quick, say=say))
    return totals(reports), write_error_time(folder, circumstances, reports)


def find_scene(name: str) -> Scene:
    """Find a scene.

    Parameters
    ----------
    name
        Name of a scene, or a procedure's file.

    Returns
    -------
    Scene
        The scene.

    Raises
    ------
    RefusedError
        If it is neither.
    """
    for box in BOXES:
        if box.name == name:
            return box
    if name == "z-plasty":
        return z_plasty_scene()
    if name == "scalp-flap":
        return scalp_flap()
    path = Path(name)
    if path.suffix in (".usda", ".usdc", ".usd"):
        procedure = read_procedure(path)
        h = procedure.tissue.spacing
        return ProcedureScene(path.stem, path.name, procedure, (2 * h, 1.5 * h, h), (2 * h, h, h / 2), h)
    known = f"{', '.join(NAMES)}, or a procedure (.usda)"
    raise refused(ProblemCode.REPORT_UNKNOWN, "", name, what="scene", known=known)
