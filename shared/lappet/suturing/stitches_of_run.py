"""The single stitches of a run: two points of the edges each, or the bites of a thread."""

from __future__ import annotations

from dataclasses import dataclass

from lappet.core.problem import Problem, problem
from lappet.core.problem_code import ProblemCode
from lappet.procedure import Suture, SutureLayer, SutureRun, stitches
from lappet.procedure.prim_paths import TIMELINE
from lappet.procedure.stitches import Stitch
from lappet.suturing.stitch_places import Site, beside, sites, taken_spacing
from lappet.tissue.skin_sheet import SkinSheet

OVERLAP = 0.5  # of a run's duration that each of its stitches takes where they are not made all at once; chosen


@dataclass(frozen=True)
class RunStitches:
    """What a run becomes.

    Parameters
    ----------
    sutures
        Its stitches, layer by layer and along each; their names begin with the run's.
    merged
        What is to be said where the lattice carries fewer stitches than the run asks for, or None.
    """

    sutures: tuple[Suture, ...]
    merged: Problem | None = None


def run_stitches(run: SutureRun, skin: SkinSheet, spacing: float) -> RunStitches:
    """Make the stitches of a run.

    Parameters
    ----------
    run
        A run that `lappet.checks` finds no error in.
    skin
        The skin that its edges lie on.
    spacing
        Edge of the lattice's cells in mm: stitches nearer than it can carry are merged; 0 to leave them as they are.

    Returns
    -------
    RunStitches
        The stitches.
    """
    found: list[Suture] = []
    for layer in run.layers:
        prefix = run.name if len(run.layers) == 1 else f"{run.name}/{layer.name}"
        found += _layer_sutures(run, layer, sites(run, layer, skin, spacing), prefix)
    return RunStitches(tuple(found), _merged(run, spacing))


def _merged(run: SutureRun, spacing: float) -> Problem | None:
    taken = taken_spacing(run, spacing)
    if taken <= run.spacing:
        return None
    code, path = ProblemCode.SUTURE_RUN_MERGED, f"{TIMELINE}/{run.name}"
    return problem(code, path, f"{run.spacing:.4g}", name=run.name, taken=taken, cell=spacing)


def _layer_sutures(run: SutureRun, layer: SutureLayer, places: list[Site], prefix: str) -> list[Suture]:
    pattern = _pattern(run, layer)
    if pattern == "running":
        depth = layer.depth or run.pass_depth
        thread = stitches.running([place.pair for place in places], _bite(run, stitches.BITE), depth)
        return [_thread(run, f"{prefix}/1", thread, run.start, run.duration)]
    count = 1 + max(place.level for place in places)
    share = 1.0 if count == 1 else OVERLAP
    found = []
    for k, place in enumerate(places, start=1):
        later = 0.0 if count == 1 else (1.0 - share) * place.level / (count - 1)
        start, duration = run.start + later * run.duration, share * run.duration
        if pattern == "interrupted":
            found.append(_interrupted(run, layer, place, f"{prefix}/{k}", (start, duration)))
        else:
            stitch = _stitch(run, layer, pattern, place)
            found.append(_thread(run, f"{prefix}/{k}", stitch, start, duration))
    return found


def _pattern(run: SutureRun, layer: SutureLayer) -> str:
    """What the stitches of a layer do: patterns are sewn on the skin, the deep dermal one below it."""
    deep = any(each.depth > 0.0 for each in run.layers)
    if run.pattern == "deepDermal":
        return "interrupted" if deep and layer.depth == 0.0 else "deepDermal"
    return run.pattern if layer.depth == 0.0 else "interrupted"


def _interrupted(run: SutureRun, layer: SutureLayer, place: Site, name: str, when: tuple[float, float]) -> Suture:
    away = beside(run, layer)
    ends = place.pair.point(0, away, layer.depth), place.pair.point(1, away, layer.depth)
    if run.mode == "exact":
        return Suture(name, ends, when[0], when[1], run.stiffness, pull_through=run.pull_through, thread=run.thread)
    return _thread(run, name, Stitch(ends, 2.0 * away), *when)


def _thread(run: SutureRun, name: str, stitch: Stitch, start: float, duration: float) -> Suture:
    return stitch.suture(
        name,
        start,
        run.drawn,
        duration=duration,
        stiffness=run.stiffness,
        thread=run.thread,
        tension=run.tension,
        pull_through=run.pull_through,
    )


def _bite(run: SutureRun, usual: float) -> float:
    return usual if run.bite is None else run.bite


def _stitch(run: SutureRun, layer: SutureLayer, pattern: str, place: Site) -> Stitch:
    at, depth = place.pair, layer.depth or run.pass_depth
    match pattern:
        case "verticalMattress":
            return stitches.vertical_mattress(at, depth, _bite(run, stitches.FAR))
        case "horizontalMattress":
            return stitches.horizontal_mattress(at, depth, _bite(run, stitches.MATTRESS))
        case "halfBuriedMattress":
            return stitches.half_buried_mattress(at, depth, _bite(run, stitches.MATTRESS))
        case "deepDermal":
            return stitches.deep_dermal(at, depth, bite=_bite(run, stitches.BITE))
        case "figureOfEight":
            return stitches.figure_of_eight(at, depth, _bite(run, stitches.BITE))
    return stitches.simple(at, _bite(run, stitches.BITE), depth)
