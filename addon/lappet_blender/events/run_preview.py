"""The stitches of a suture run of a scene, before anything is solved: what the plan and pictures show of it."""

from __future__ import annotations

from typing import Any

import bpy

from lappet.checks.suture_run_problems import RunCheck
from lappet.core.problem import RefusedError
from lappet.procedure import Suture, SutureRun, Tissue
from lappet.procedure.prim_paths import TIMELINE
from lappet.suturing import run_stitches
from lappet.suturing.single_sutures import skin_of

from ..model.event_values import event_value
from .event_check import rest_space, tissue_of

_MOST = 256  # runs that are kept
_known: dict[tuple[int, str], tuple[Tissue, SutureRun, tuple[Suture, ...]]] = {}  # by scene and event


def stitches_of(scene: bpy.types.Scene, event: Any) -> tuple[Suture, ...]:
    """The stitches of a run, or none where it, or the tissue, is wrong; kept until either changes."""
    try:
        run, tissue = event_value(scene, event), tissue_of(scene)
    except RefusedError:
        return ()
    if not isinstance(run, SutureRun):
        return ()
    key = scene.session_uid, str(event.uid)
    kept = _known.get(key)
    if kept is None or kept[0] is not tissue or kept[1] != run:
        if len(_known) >= _MOST:
            _known.clear()
        kept = _known[key] = tissue, run, _made(run, tissue)
    return kept[2]


def _made(run: SutureRun, tissue: Tissue) -> tuple[Suture, ...]:
    rest = rest_space(tissue)
    try:
        skin = skin_of(tissue)
    except IndexError:  # a group of faces that the mesh lacks, which is said of the tissue
        return ()
    if rest is None or not len(skin.normals):
        return ()
    problems = RunCheck(run, f"{TIMELINE}/{run.name}").check(rest, skin, tissue.spacing)
    if any(each.severity == "error" for each in problems):
        return ()
    return run_stitches(run, skin, tissue.spacing).sutures
