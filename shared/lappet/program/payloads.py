"""What the daemon is told, message by message, as fields and arrays under their names in PROTOCOL.md.

The client sends these values and the keys of frames are digests of them: what is not told is in no key.
"""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.cutting.epoch import Boundary, Epoch, Regions
from lappet.program.program import Bones, FrameConstraints, Landmarks
from lappet.program.settings import MaterialParameters, SolverSettings

# Of a frame.
OPTIONAL = (
    "activation",
    "bone_motion",
    "load_index",
    "load_traction",
    "load_pressure",
    "suture_is_thread",
    "suture_length",
    "suture_tension",
    "suture_inner_bites",
    "inner_bite_anchors",
    "inner_bite_triangles",
)
ALWAYS_TOLD = frozenset({"model", "youngs_modulus", "poissons_ratio", "density"})


@dataclass(frozen=True, eq=False)
class Payload:
    """The fields and arrays of a message.

    Parameters
    ----------
    fields
        Fields by name.
    arrays
        Arrays by name.
    """

    fields: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


def open_payload(settings: SolverSettings, bones: Bones | None = None) -> Payload:
    """Make what `open` tells: the settings, the table of materials, the bones where there are any.

    Parameters
    ----------
    settings
        The settings; what they leave to a tissue is off.
    bones
        The bones.

    Returns
    -------
    Payload
        Fields and arrays.
    """
    told = {
        item.name: _plain(item.type, getattr(settings, item.name))
        for item in fields(settings)
        if item.name != "materials"
    }
    materials = [_material(material) for material in settings.materials]
    arrays: dict[str, NDArray[Any]] = {}
    if bones is not None and len(bones.triangles):
        arrays["bone_points"] = np.asarray(bones.points, np.float64)
        arrays["bone_triangles"] = np.asarray(bones.triangles, np.int32)
        if len(bones.bodies):
            arrays["bone_bodies"] = np.asarray(bones.bodies, np.int32)
    return Payload({"settings": told, "materials": materials}, arrays)


def epoch_payload(epoch: Epoch, grip: NDArray[np.int32], landmarks: Landmarks) -> Payload:
    """Make what `epoch` tells: the surface, what holds it, the landmarks and the regions.

    Parameters
    ----------
    epoch
        The epoch.
    grip
        Index of the retractor that grips each triangle, or -1, shape (m,).
    landmarks
        The landmarks that the epoch's tissue holds.

    Returns
    -------
    Payload
        Fields and arrays.
    """
    surface, regions = epoch.surface, epoch.regions
    arrays: dict[str, NDArray[Any]] = {
        "points": np.asarray(surface.points, np.float64),
        "triangles": np.asarray(surface.triangles, np.int32),
        "fixed": np.asarray(surface.fixed, np.uint8),
        "support": np.asarray(epoch.support, np.uint8),
        "grip": np.asarray(grip, np.int32),
        "landmarks": np.concatenate([landmarks.points, landmarks.vessel_points]).reshape(-1, 3),
        "landmark_triangles": np.concatenate([landmarks.triangles, landmarks.vessel_triangles]).astype(np.int32),
    }
    told: dict[str, Any] = {"index": int(epoch.index)}
    if len(regions.skin_triangles):
        arrays["skin_points"] = np.asarray(regions.skin_points, np.float64)
        arrays["skin_triangles"] = np.asarray(regions.skin_triangles, np.int32)
    for name in ("skin_directions", "skin_stretch"):
        if len(getattr(regions, name)):
            arrays[name] = np.asarray(getattr(regions, name), np.float64)
    if len(epoch.ground.triangles):
        arrays["ground_points"] = np.asarray(epoch.ground.points, np.float64)
        arrays["ground_triangles"] = np.asarray(epoch.ground.triangles, np.int32)
    arrays.update(_boundary(epoch.boundary))
    if len(epoch.strands):
        arrays["strand_start"] = np.asarray(epoch.strands.start, np.int32)
        arrays["strand_material"] = np.asarray(epoch.strands.material, np.int32)
        arrays["strand_points"] = np.asarray(epoch.strands.points, np.float64)
        arrays["strand_radii"] = np.asarray(epoch.strands.radii, np.float64)
    if len(regions):
        told["regions"] = _regions(regions)
        arrays["region_faces"] = np.asarray(regions.faces, np.uint8)
    return Payload(told, arrays)


def _boundary(boundary: Boundary) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {}
    if len(boundary.walls):
        arrays["walls"] = np.asarray(boundary.walls, np.uint8)
    if len(boundary.fixed_parts):
        arrays["fixed_parts"] = np.asarray(boundary.fixed_parts, np.int32)
    if len(boundary.rollers):
        arrays["roller_faces"] = np.asarray(boundary.rollers, np.int32)
        arrays["roller_normals"] = np.asarray(boundary.roller_normals, np.float64)
    if len(boundary.loaded_index):
        arrays["loaded_index"] = np.asarray(boundary.loaded_index, np.int32)
        arrays["loaded_faces"] = np.asarray(boundary.loaded_faces, np.uint8)
    if len(boundary.section_points):
        arrays["section_points"] = np.asarray(boundary.section_points, np.float64)
        arrays["section_normals"] = np.asarray(boundary.section_normals, np.float64)
    return arrays


def solve_payload(frame: FrameConstraints) -> Payload:
    """Make what `solve` tells: the constraints of a frame.

    Parameters
    ----------
    frame
        The constraints.

    Returns
    -------
    Payload
        Fields and arrays.
    """
    arrays = {
        item.name: np.asarray(getattr(frame, item.name), item.default_factory().dtype)
        for item in fields(frame)
        if item.default_factory is not MISSING
    }
    for name in OPTIONAL:
        if not len(arrays[name]):
            del arrays[name]
    return Payload({"time": float(frame.time)}, arrays)


def _plain(kind: Any, value: Any) -> Any:
    """Return a setting as the wire has it; kind: its annotation."""
    if isinstance(value, tuple):
        return [float(each) for each in value]
    if kind == "float":
        return float(value)
    return value if isinstance(value, str) else int(value or 0)


def _material(material: MaterialParameters) -> dict[str, Any]:
    """Return a material as a map; what it does without is left out."""
    told = {item.name: _plain(item.type, getattr(material, item.name)) for item in fields(material)}
    plain = {item.name: _plain(item.type, item.default) for item in fields(material)}
    return {name: value for name, value in told.items() if name in ALWAYS_TOLD or value != plain[name]}


def _regions(regions: Regions) -> list[dict[str, Any]]:
    maps: list[dict[str, Any]] = []
    for material, top, bottom in zip(regions.material, regions.depth_from, regions.depth_to, strict=True):
        maps.append({"material": int(material), "depth_from": float(top)})
        if np.isfinite(bottom):
            maps[-1]["depth_to"] = float(bottom)
    return maps
