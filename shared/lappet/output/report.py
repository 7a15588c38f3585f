"""The report of a solve (`lappet solve --report`): JSON with the settings, the scene and what every frame took.

Lengths are mm, forces mN, stresses kPa, times seconds, memory bytes. Numbers that are not finite are written as null.
"""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from lappet.core.durable import write_whole
from lappet.core.machine import machine
from lappet.core.problem import Place, Problem
from lappet.core.version import version
from lappet.cutting.epoch import Epoch
from lappet.daemon.solved_frame import SolvedFrame
from lappet.output.solve_to_cache import SolveResult
from lappet.output.vessel_report import vessel_lengths, vessel_summary
from lappet.procedure.scene_profile import scene_profile
from lappet.program.program import Program
from lappet.solve.bite_forces import bite_forces
from lappet.solve.error_estimate import FrameErrorEstimate
from lappet.solve.fallbacks import volume_ratio
from lappet.solve.force_sums import ForceSums
from lappet.solve.measures import FrameMeasures
from lappet.solve.reactions import reactions
from lappet.solve.sensitive import is_sensitive
from lappet.solve.solve_frames import FrameResult, failure_code

REPORT_VERSION = 2
NO_MEASURES = FrameMeasures()
LATTICE_COUNTS = ("fine_voxels", "cells", "grid_cells", "mesh_cells", "nodes", "blocks")


def report(result: SolveResult) -> dict[str, Any]:
    """Compose the report of a solve.

    `notes` holds warnings and notes by their codes, with their places: what is suspicious in the procedure, what was
    done otherwise than it was told, which frames are not to be trusted and where. `lattice` holds the counts of the
    epoch with the most cells, `epochs` those of every epoch that was solved. `cache_hit` says that a frame came from
    the store, its iterations and seconds by stage then being those of when it was solved.

    Parameters
    ----------
    result
        What the solve gave.

    Returns
    -------
    dict[str, Any]
        Values that JSON can hold.
    """
    program = result.program
    lattices = {
        frame.constraints.epoch: asdict(frame.solved.lattice) if frame.solved.lattice is not None else {}
        for frame in result.frames
    }
    epochs = [
        {
            "index": epoch.index,
            "start_time": epoch.start_time,
            "fragments": epoch.fragments,
            "surface_points": len(epoch.surface.points),
            "triangles": len(epoch.surface.triangles),
            "lattice": lattices[epoch.index],
            "lattice_volume_ratio": _volume_ratio(result, epoch),
            "thinned": [
                {"event": each.name, "area_mm2": each.area, "volume_mm3": each.volume} for each in epoch.thinned
            ],
        }
        for epoch in program.epochs
        if epoch.index in lattices
    ]
    largest = max(lattices.values(), key=lambda counts: (counts.get("cells", 0), counts.get("nodes", 0)), default={})
    profile = {
        **scene_profile(result.procedure),
        "self_contact": bool(program.settings.self_contact),
        "explicit_mesh": any(counts.get("mesh_cells", 0) > 0 for counts in lattices.values()),
        "error_estimate": result.errors is not None,
    }
    peaks = [peak for frame in result.frames if (peak := frame.solved.diagnostics.peak_bytes)]
    values = {
        "version": REPORT_VERSION,
        "lappet": version(),
        "machine": machine(),
        "settings": asdict(program.settings),
        "scene_profile": profile,
        "lattice": {name: largest.get(name) for name in LATTICE_COUNTS},
        "epochs": epochs,
        "complete": result.complete,
        "interrupted": result.interrupted,
        "reason": None if result.reason is None else str(result.reason),
        "code": None if result.reason is None else result.reason.code,
        "notes": [_note(each) for each in result.notes],
        "vessels": vessel_summary(program),
        "error_estimate": _estimate(result),
        "frames": [
            _frame(program, frame, error, measures)
            for frame, error, measures in zip(result.frames, _errors(result), _measures(result), strict=True)
        ],
        **_forces(result),
        "failed": None if result.failed is None else _frame(program, result.failed),
        "frames_solved": result.solved,
        "cache_hits": result.looked_up,
        "wall_seconds": result.wall_seconds,
        "peak_memory_bytes": max(peaks, default=None),
        "own_peak_memory_bytes": _own_peak(),
    }
    cleaned: dict[str, Any] = _clean(values)
    return cleaned


def write_report(result: SolveResult, path: Path | str) -> None:
    """Write the report of a solve atomically.

    Parameters
    ----------
    result
        What the solve gave.
    path
        The JSON file.

    Raises
    ------
    OSError
        If the file system refuses.
    """
    path = Path(path)
    text = json.dumps(report(result), indent=1, allow_nan=False) + "\n"
    write_whole(path, text.encode())


def _frame(
    program: Program,
    frame: FrameResult,
    error: FrameErrorEstimate | None = None,
    measures: FrameMeasures = NO_MEASURES,
) -> dict[str, Any]:
    solved, said = frame.solved, frame.solved.diagnostics
    hooks = [program.hooks[i] for i in solved.hook_index]
    sutures = [program.sutures[i] for i in solved.suture_index]
    landmarks = [program.landmarks[i] for i in solved.landmark_index]
    return {
        "time_code": solved.time,
        "epoch": frame.constraints.epoch,
        "converged": said.converged,
        "reason": said.reason or None,
        "code": None if said.converged else failure_code(solved),
        "newton_iterations": said.newton,
        "pcg_iterations": said.pcg,
        "load_steps": said.load_steps,
        "active_cells": said.active_cells,
        "restart": said.restart or None,
        "residual": said.residual,
        "force_scale_mn": said.force_scale,
        "displacement_to_come_mm": said.displacement_to_come,
        "largest_gap_mm": said.largest_gap,
        "minimum_j": said.minimum_j,
        "inverted_cells": said.inverted_cells,
        "energy_mn_mm": said.energy,
        "largest_penetration_mm": said.largest_penetration,
        "contacts": said.contacts,
        "self_contacts": said.self_contacts,
        "piercings": said.piercings,
        "piercings_before": said.piercings_before,
        "untangled": said.untangled,
        "stability": {
            "lowest_stiffness": said.lowest_stiffness,
            "softest_point": solved.softest_point[0].tolist() if len(solved.softest_point) else None,
            "is_sensitive": is_sensitive(solved),
            "saddles_left": said.saddles_left,
        },
        "seconds": {**asdict(said.seconds), "wall": frame.wall_seconds},
        "suture_gaps_mm": _named(sutures, solved.suture_gaps),
        "suture_forces_mn": _named(sutures, solved.suture_forces),
        "suture_force_vectors_mn": _named(sutures, solved.suture_force_vectors),
        **_bite_forces(sutures, solved),
        "hook_forces_mn": _named(hooks, solved.hook_forces),
        "suture_force_errors_mn": {row.suture: row.force_error_mn for row in measures.sutures},
        "hook_force_errors_mn": {row.hook: row.force_error_mn for row in measures.hooks},
        "reactions_mn": _reactions(program, solved),
        "landmarks": _named(landmarks, solved.landmarks),
        "vessels": vessel_lengths(program, frame.constraints, solved),
        "estimated_error_mm": _error(program, frame, error),
        "cache_hit": frame.looked_up,
        "key": frame.key,
    }


def _reactions(program: Program, solved: SolvedFrame) -> dict[str, dict[str, Any]]:
    """The force on the tissue of whatever holds or loads it, by what it is and by its name."""
    found: dict[str, dict[str, Any]] = {}
    for row in reactions(program, solved):
        found.setdefault(row.holder, {})[row.name] = [row.force_x_mn, row.force_y_mn, row.force_z_mn]
    return found


def _bite_forces(sutures: list[str], solved: SolvedFrame) -> dict[str, Any]:
    """The force on each bite of the threads that have more than two."""
    if not len(solved.suture_inner_bites):
        return {}
    forces = zip(sutures, bite_forces(solved), strict=True)
    return {"bite_forces_mn": {name: each.tolist() for name, each in forces if len(each) > 2}}


def _forces(result: SolveResult) -> dict[str, Any]:
    """The forces of each frame that has a suture, summed up, and the tension of the skin."""
    measured = zip(result.frames, _measures(result), strict=True)
    sums = [{"time_code": frame.solved.time, **_sums(each.sums)} for frame, each in measured if each.sums is not None]
    return {
        "sutures": sums,
        "seams": _seams(result),
        "sections": [asdict(row) for row in result.sections],
        "greatest_mean_tension": _mean_tension(result),
    }


def _sums(sums: ForceSums) -> dict[str, Any]:
    """The forces of a frame summed up, its closures by their names."""
    values = asdict(sums)
    del values["coarse_share"]  # of use where the sums of two solves are divided
    values["closures"] = {each.pop("closure"): each for each in values["closures"]}
    return values


def _seams(result: SolveResult) -> list[dict[str, Any]]:
    """What is measured at the seams of each frame that has one, by their names."""
    frames: dict[float, dict[str, Any]] = {}
    for row in result.seams:
        values = asdict(row)
        frames.setdefault(values.pop("time"), {})[values.pop("seam")] = values
    return [
        {
            "time_code": time,
            "scar_length_mm": sum(each["scar_length_mm"] for each in own.values()),
            "open_area_mm2": sum(each["open_area_mm2"] for each in own.values()),
            "seams": own,
        }
        for time, own in frames.items()
    ]


def _mean_tension(result: SolveResult) -> dict[str, Any] | None:
    """The greatest mean tension in the last frame."""
    if not result.measures or (found := result.measures[-1].mean_tension) is None:
        return None
    return {
        "time_code": result.frames[-1].solved.time,
        "kpa": found.tension,
        "error_kpa": found.error,
        "area_mm2": found.area,
        "place_mm": found.place,
    }


def _errors(result: SolveResult) -> tuple[FrameErrorEstimate | None, ...]:
    return (None,) * len(result.frames) if result.errors is None else result.errors.frames


def _estimate(result: SolveResult) -> dict[str, Any] | None:
    errors = result.errors
    if errors is None:
        return None
    return {
        "companion_spacing_mm": errors.spacing,
        "order": errors.order,
        "seconds": errors.seconds,
        "reason": None if errors.reason is None else str(errors.reason),
        "code": None if errors.reason is None else errors.reason.code,
    }


def _measures(result: SolveResult) -> tuple[FrameMeasures, ...]:
    return result.measures or (NO_MEASURES,) * len(result.frames)


def _error(program: Program, frame: FrameResult, error: FrameErrorEstimate | None) -> dict[str, Any] | None:
    if error is None:
        return None
    landmarks = [program.landmarks[i] for i in frame.solved.landmark_index]
    return {
        "max": error.greatest,
        "rms": error.rms,
        "algebraic": {"max": error.algebraic_greatest, "rms": error.algebraic_rms},
        "discretization": {"max": error.discretization_greatest, "rms": error.discretization_rms},
        "gaps": {"max": error.gaps_greatest, "rms": error.gaps_rms},
        "place": error.place,
        "largest_displacement": error.largest_displacement,
        "is_trusted": error.is_trusted,
        "other_branch": None
        if error.other_branch is None
        else {"distance": error.other_branch.distance, "place": error.other_branch.place},
        "landmarks": _named(landmarks, error.landmarks),
    }


def _volume_ratio(result: SolveResult, epoch: Epoch) -> float | None:
    own = (frame.solved.lattice for frame in result.frames if frame.constraints.epoch == epoch.index)
    counts = next(own, None)
    return None if counts is None else volume_ratio(epoch, counts)


def _note(note: Problem) -> dict[str, Any]:
    where = note.place or Place()
    return {
        "code": note.code,
        "severity": note.severity,
        "prim": note.prim,
        "value": note.value,
        "message": note.message,
        "remedy": note.remedy,
        "faces": where.faces,
        "points_mm": where.points,
    }


def _named(names: list[str], values: Any) -> dict[str, Any]:
    return {name: np.asarray(value).tolist() for name, value in zip(names, values, strict=True)}


def _clean(value: Any) -> Any:
    """The value with NumPy's numbers as Python's and None for what is not finite."""
    if isinstance(value, dict):
        return {str(name): _clean(each) for name, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_clean(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def _own_peak() -> int | None:
    try:
        import resource
    except ImportError:
        return None
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
