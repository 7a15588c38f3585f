"""Run the report of the error estimate."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.daemon.daemon_solver import connect_to
from lappet.reports.error_estimate.files import fitted_totals, totals, value_totals, write_error_estimate
from lappet.reports.error_estimate.fitting_scenes import fitting_scenes
from lappet.reports.error_estimate.hold_out_scenes import hold_out_scenes
from lappet.reports.error_estimate.measurement import measure_scene
from lappet.reports.error_estimate.scene import EstimateScene
from lappet.reports.report_files import head, make_folder
from lappet.solve.store import FrameStore


def run_error_estimate(
    names: Sequence[str], folder: Path, fitting: bool = False, say: Callable[[str], None] = lambda _: None
) -> tuple[str, list[Path]]:
    """Measure scenes and write the files.

    Parameters
    ----------
    names
        Names of the scenes; all where none is named.
    folder
        Folder of the files.
    fitting
        Whether to take the scenes that the constants were fitted on instead of the hold-out set.
    say
        Is told of every spacing.

    Returns
    -------
    tuple[str, list[Path]]
        The totals as sentences, and the files.

    Raises
    ------
    RefusedError
        If a name is no scene.
    """
    scenes = chosen_scenes(names, fitting)
    make_folder(folder)
    circumstances = head()
    with tempfile.TemporaryDirectory() as kept:  # nothing is looked up but what two spacings share
        store = FrameStore(Path(kept))
        found = [measure_scene(scene, store, connect_to(None), say) for scene in scenes]
    rows = [row for each in found for row in each.rows]
    values = [row for each in found for row in each.values]
    said = [*totals(rows), *(fitted_totals(rows) if fitting else []), *value_totals(values)]
    return "\n".join(said), write_error_estimate(folder, circumstances, scenes, rows, values)


def chosen_scenes(names: Sequence[str], fitting: bool = False) -> tuple[EstimateScene, ...]:
    """Find scenes by their names.

    Parameters
    ----------
    names
        Names of the scenes; all where none is named.
    fitting
        Whether to look among those that the constants were fitted on.

    Returns
    -------
    tuple[EstimateScene, ...]
        The scenes.

    Raises
    ------
    RefusedError
        If a name is no scene.
    """
    scenes = {scene.name: scene for scene in (fitting_scenes() if fitting else hold_out_scenes())}
    for name in names:
        if name not in scenes:
            raise refused(ProblemCode.REPORT_UNKNOWN, "", name, what="scene", known=", ".join(scenes))
    return tuple(scenes[name] for name in names or scenes)
