"""What a skin cache says of its last frame: forces, seams, landmarks, and the tension of the skin."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.limits import DEFAULT_LIMITS, ReadLimits
from lappet.foreign.reading_process import ReadingProcess
from lappet.procedure import Landmark, Procedure
from lappet.usd.procedure_file import CHILD
from lappet.usd.stage import open_stage, read_procedure
from lappet.usd.stage_contents import ValueSizes

_SKIN = "/Procedure/Skin"


@dataclass(frozen=True, eq=False)
class SkinEnd:
    """The skin in the last frame.

    Parameters
    ----------
    triangles
        Its triangles, shape (t, 3).
    rest
        Points at rest in mm, shape (n, 3).
    points
        Points in the frame in mm, shape (n, 3).
    tension
        Mean tension at the points in kPa, shape (n,).
    """

    triangles: NDArray[np.int64]
    rest: NDArray[np.float64]
    points: NDArray[np.float64]
    tension: NDArray[np.float64]

    def areas(self) -> NDArray[np.float64]:
        """Measure the triangles in the frame.

        Returns
        -------
        NDArray[np.float64]
            Their areas in mm², shape (t,).
        """
        a, b, c = (self.points[self.triangles[:, k]] for k in range(3))
        return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


@dataclass(frozen=True, eq=False)
class CacheEnd:
    """The last frame of a skin cache.

    Parameters
    ----------
    procedure
        The procedure that the cache is of.
    time
        Time code of the frame.
    forces
        Force of each suture that is placed and that the lattice resolves, by its name, in mN.
    seams
        By the name of each seam, the line midway between its lips in mm, shape (k, 3).
    measures
        By the name of each seam what is measured there: "tension" (N/mm), "scarLength" (mm), "openArea" (mm²),
        "startDogEar" and "endDogEar" (mm); NaN where it is not known.
    landmarks
        By label, place at rest and place in the frame in mm, each of shape (3,); those that are excised are left out.
    tension
        Mean tension at the points of the skin in kPa, shape (n,); empty where the cache has none.
    area
        Area of the skin around each of these points in mm², shape (n,).
    lines
        By the label of a landmark of several points that no design made, its points at rest and in the frame in mm,
        each of shape (k, 3).
    skin
        The skin; None where the cache has no tension.
    unresolved
        The sutures that are placed and that the lattice does not resolve.
    """

    procedure: Procedure
    time: float
    forces: dict[str, float]
    seams: dict[str, NDArray[np.float64]]
    measures: dict[str, dict[str, float]]
    landmarks: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]
    tension: NDArray[np.float64]
    area: NDArray[np.float64]
    lines: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]] = field(default_factory=dict)
    skin: SkinEnd | None = None
    unresolved: tuple[str, ...] = ()


def read_cache_end(path: str | os.PathLike[str], limits: ReadLimits = DEFAULT_LIMITS) -> CacheEnd:
    """Read the last frame of a skin cache.

    Parameters
    ----------
    path
        The cache, as `lappet solve` wrote it.
    limits
        What reading may take.

    Returns
    -------
    CacheEnd
        The frame.

    Raises
    ------
    RefusedError
        If the file cannot be read or is no skin cache.
    """
    file = Path(path)
    procedure = read_procedure(file, limits=limits)
    with ReadingProcess(CHILD, "values", file, limits) as look:
        look.result(ValueSizes)
    stage = open_stage(file, limits)
    meshes = [prim for prim in _children(stage, _SKIN) if prim.GetName().startswith("epoch_")]
    times = sorted({time for prim in meshes for time in prim.GetAttribute("points").GetTimeSamples()})
    if not times:
        raise refused(ProblemCode.COMPARE_NO_CACHE, file, file.name)
    last = times[-1]
    shown = next(prim for prim in reversed(meshes) if last in prim.GetAttribute("points").GetTimeSamples())
    skin = _skin(shown, last)
    seams = stage.GetPrimAtPath(f"{_SKIN}/Seams")
    names = _labels(seams)
    lines = _array(seams, "points", last).reshape(len(names), -1, 3) if names else np.zeros((0, 0, 3))
    active = _array(seams, "primvars:active", last).astype(bool) if names else np.zeros(0, bool)
    own = {key: _array(seams, f"primvars:{key}", last) for key in MEASURES} if names else {}
    kept = [k for k in range(len(names)) if active[k]]
    marks = stage.GetPrimAtPath(f"{_SKIN}/Landmarks")
    forces, unresolved = _forces(stage.GetPrimAtPath(f"{_SKIN}/Sutures"), last)
    return CacheEnd(
        procedure,
        last,
        forces,
        {names[k]: lines[k] for k in kept},
        {names[k]: {key: float(values[k]) for key, values in own.items()} for k in kept},
        _landmarks(marks, procedure, last),
        *_by_point(skin),
        _lines(marks, procedure, last),
        skin,
        unresolved,
    )


MEASURES = ("tension", "scarLength", "openArea", "startDogEar", "endDogEar")


def _children(stage: Any, path: str) -> list[Any]:
    prim = stage.GetPrimAtPath(path)
    return list(prim.GetChildren()) if prim else []


def _array(prim: Any, name: str, time: float) -> NDArray[np.float64]:
    return np.asarray(prim.GetAttribute(name).Get(time), np.float64)


def _labels(prim: Any) -> list[str]:
    return [str(each) for each in prim.GetAttribute("primvars:label").Get()] if prim else []


def _forces(sutures: Any, time: float) -> tuple[dict[str, float], tuple[str, ...]]:
    """Forces of the sutures that are placed, and which of these the lattice does not resolve, whose force is no one's.

    A cache that was written without measures says nothing of that: all count as resolved.
    """
    names = _labels(sutures)
    if not names:
        return {}, ()
    active, force = (_array(sutures, f"primvars:{each}", time) for each in ("active", "force"))
    known = sutures.HasAttribute("primvars:resolved")
    resolved = _array(sutures, "primvars:resolved", time) if known else np.ones(len(names))
    placed = [
        (name, float(mn), bool(part)) for name, on, mn, part in zip(names, active, force, resolved, strict=True) if on
    ]
    return {name: mn for name, mn, part in placed if part}, tuple(name for name, _, part in placed if not part)


def _landmarks(
    marks: Any, procedure: Procedure, time: float
) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Places of the landmarks of one point; those of several points follow lips and have no name of their own."""
    rest = {
        event.label: event.points[0]
        for event in procedure.events
        if isinstance(event, Landmark) and len(event.points) == 1
    }
    names = _labels(marks)
    if not names:
        return {}
    now, active = _array(marks, "points", time), _array(marks, "primvars:active", time)
    return {
        name: (np.asarray(rest[name], np.float64), now[k]) for k, name in enumerate(names) if name in rest and active[k]
    }


def _lines(marks: Any, procedure: Procedure, time: float) -> dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """The landmarks of several points that no design made: the margin of a lid, a line along a lip."""
    names = _labels(marks)
    if not names:
        return {}
    made = {name for flap in procedure.flaps for name in flap.events}
    now, active = _array(marks, "points", time), _array(marks, "primvars:active", time)
    index = {name: k for k, name in enumerate(names) if active[k]}
    found = {}
    for event in procedure.events:
        if not isinstance(event, Landmark) or len(event.points) < 2 or event.name in made:
            continue
        own = [index[name] for k in range(len(event.points)) if (name := f"{event.label} {k + 1}") in index]
        if len(own) == len(event.points):
            found[event.label] = (np.array(event.points, np.float64), now[own])
    return found


def _skin(mesh: Any, time: float) -> SkinEnd | None:
    """The skin of an epoch; None where the cache has no tension."""
    attribute = mesh.GetAttribute("primvars:tension")
    if not attribute or not attribute.HasValue():
        return None
    skin = np.asarray(mesh.GetPrim().GetChild("skin").GetAttribute("indices").Get(), np.int64)
    triangles = np.asarray(mesh.GetAttribute("faceVertexIndices").Get(), np.int64).reshape(-1, 3)[skin]
    rest = np.asarray(mesh.GetAttribute("points").Get(), np.float64)
    return SkinEnd(triangles, rest, _array(mesh, "points", time), _array(mesh, "primvars:tension", time))


def _by_point(skin: SkinEnd | None) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Tension and area of the skin's points."""
    if skin is None:
        return np.zeros(0), np.zeros(0)
    area = np.zeros(len(skin.points))
    np.add.at(area, skin.triangles.ravel(), np.repeat(skin.areas() / 3.0, 3))
    on = area > 0.0
    return skin.tension[on], area[on]
