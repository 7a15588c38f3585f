"""The keys and the kinds of values of a report (`lappet solve --report`)."""

from __future__ import annotations

from typing import Any

NUMBER = (int, float)
FRAME: dict[str, Any] = {
    "time_code": NUMBER,
    "epoch": int,
    "converged": bool,
    "reason": (str, type(None)),
    "code": (str, type(None)),
    "newton_iterations": int,
    "pcg_iterations": int,
    "load_steps": int,
    "active_cells": int,
    "restart": (str, type(None)),
    "residual": NUMBER,
    "force_scale_mn": NUMBER,
    "displacement_to_come_mm": NUMBER,
    "largest_gap_mm": NUMBER,
    "minimum_j": NUMBER,
    "inverted_cells": int,
    "energy_mn_mm": NUMBER,
    "largest_penetration_mm": NUMBER,
    "contacts": int,
    "self_contacts": int,
    "piercings": int,
    "piercings_before": int,
    "untangled": int,
    "stability": {
        "lowest_stiffness": (*NUMBER, type(None)),
        "softest_point": (list, type(None)),
        "is_sensitive": bool,
        "saddles_left": int,
    },
    "seconds": {
        "update": NUMBER,
        "linear": NUMBER,
        "setup": NUMBER,
        "stability": NUMBER,
        "total": NUMBER,
        "wall": NUMBER,
    },
    "suture_gaps_mm": dict,
    "suture_forces_mn": dict,
    "suture_force_vectors_mn": dict,
    "hook_forces_mn": dict,
    "suture_force_errors_mn": dict,
    "hook_force_errors_mn": dict,
    "reactions_mn": dict,
    "landmarks": dict,
    "vessels": dict,
    "estimated_error_mm": (dict, type(None)),
    "cache_hit": bool,
    "key": str,
}
NOTE = {
    "code": str, "severity": str, "prim": str, "value": str, "message": str, "remedy": str, "faces": list,
    "points_mm": list,
}  # fmt: skip
COUNTS = dict.fromkeys(("fine_voxels", "cells", "grid_cells", "mesh_cells", "nodes", "blocks"), int)
REPORT: dict[str, Any] = {
    "version": int,
    "lappet": str,
    "machine": {
        "system": str, "architecture": str, "processor": (str, type(None)), "cores": int, "memory_bytes": int,
        "python": str,
    },
    "settings": dict,
    "scene_profile": dict,
    "lattice": COUNTS,
    "epochs": [
        {
            "index": int, "start_time": NUMBER, "fragments": int, "surface_points": int, "triangles": int,
            "lattice": {
                **COUNTS, "fragments": int, "fixed_nodes": int, "dropped_voxels": int, "volume": NUMBER,
                "bytes": NUMBER, "seconds": NUMBER,
            },
            "lattice_volume_ratio": NUMBER,
            "thinned": list,
        }
    ],
    "complete": bool,
    "interrupted": bool,
    "reason": (str, type(None)),
    "code": (str, type(None)),
    "notes": [NOTE],
    "vessels": list,
    "error_estimate": (dict, type(None)),
    "frames": [FRAME],
    "sections": list,
    "sutures": [
        {
            "time_code": NUMBER, "total_mn": NUMBER, "greatest_mn": NUMBER, "greatest_suture": (str, type(None)),
            "donor_share": (*NUMBER, type(None)), "unresolved": list, "closures": dict,
            "total_error_mn": (*NUMBER, type(None)), "greatest_error_mn": (*NUMBER, type(None)),
        }
    ],
    "seams": [{"time_code": NUMBER, "scar_length_mm": NUMBER, "open_area_mm2": NUMBER, "seams": dict}],
    "greatest_mean_tension": (dict, type(None)),
    "failed": (dict, type(None)),
    "frames_solved": int,
    "cache_hits": int,
    "wall_seconds": NUMBER,
    "peak_memory_bytes": NUMBER,
    "own_peak_memory_bytes": int,
}  # fmt: skip


def misfits(value: Any, shape: Any, where: str = "report") -> list[str]:
    """Where a JSON value has other keys or kinds than its shape says."""
    if isinstance(shape, dict):
        if not isinstance(value, dict) or value.keys() != shape.keys():
            return [f"{where}: {sorted(value) if isinstance(value, dict) else value}"]
        return [misfit for key in shape for misfit in misfits(value[key], shape[key], f"{where}.{key}")]
    if isinstance(shape, list):
        return [misfit for i, each in enumerate(value) for misfit in misfits(each, shape[0], f"{where}[{i}]")]
    right = isinstance(value, shape) and (shape is bool or shape is not int or not isinstance(value, bool))
    return [] if right else [f"{where}: {value!r}"]
