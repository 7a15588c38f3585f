"""The body in the package: its base mesh and its shape targets, in Lappet's axes and mm.

The package has y up, z to the front and decimeters; here x runs to the patient's right, y to the front and z up, in mm,
as in `lappet.procedure.position`.
"""

from __future__ import annotations

import gzip
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.models.body_package import ROOT, body_package

_MM = 100.0
_TARGETS = f"{ROOT}/targets/"
_SUFFIX = ".target.gz"
BODY, EYES = ("body",), ("helper-l-eye", "helper-r-eye")
TEETH = ("helper-upper-teeth", "helper-lower-teeth")


@dataclass(frozen=True, eq=False)
class BodyMesh:
    """The base mesh with its groups.

    Parameters
    ----------
    points
        Vertices in mm, those of helpers too, shape (n, 3).
    quads
        Vertex indices of all faces, shape (m, 4).
    group
        Name of the group of each face, shape (m,).
    """

    points: NDArray[np.float64]
    quads: NDArray[np.int64]
    group: NDArray[np.str_]

    def faces_of(self, groups: tuple[str, ...]) -> NDArray[np.int64]:
        """Take the faces of some groups.

        Parameters
        ----------
        groups
            Names of groups.

        Returns
        -------
        NDArray[np.int64]
            Their vertex indices, shape (k, 4).
        """
        return self.quads[np.isin(self.group, groups)]


def body_mesh() -> BodyMesh:
    """Read the base mesh from the package.

    Returns
    -------
    BodyMesh
        The mesh.

    Raises
    ------
    RefusedError
        If the package is not there.
    """
    return _body_mesh(body_package())


def target_names() -> tuple[str, ...]:
    """List the shape targets of the package.

    Returns
    -------
    tuple[str, ...]
        Names such as `nose/nose-hump-incr`, sorted.

    Raises
    ------
    RefusedError
        If the package is not there.
    """
    return _target_names(body_package())


def target(name: str) -> NDArray[np.float64]:
    """Read a shape target.

    Parameters
    ----------
    name
        One of `target_names`.

    Returns
    -------
    NDArray[np.float64]
        Displacements in mm of all vertices at the full target, shape (n, 3).

    Raises
    ------
    RefusedError
        If there is none of that name, or the package is not there.
    """
    wheel = body_package()
    if name not in _target_names(wheel):
        raise refused(ProblemCode.MODEL_TARGET_UNKNOWN, name, name, command="lappet models targets")
    return _target(wheel, name)


def _turned(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.stack([-_MM * vectors[:, 0], _MM * vectors[:, 2], _MM * vectors[:, 1]], axis=1)


@cache
def _body_mesh(wheel: Path) -> BodyMesh:
    points, quads, groups = [], [], []
    group = ""
    with zipfile.ZipFile(wheel) as package:
        text = package.read(f"{ROOT}/3dobjs/base.obj").decode("utf-8")
    for line in text.splitlines():
        if line.startswith("v "):
            points.append([float(word) for word in line.split()[1:4]])
        elif line.startswith("g "):
            group = line.split()[1]
        elif line.startswith("f "):
            quads.append([int(word.partition("/")[0]) - 1 for word in line.split()[1:5]])
            groups.append(group)
    return BodyMesh(_turned(np.array(points)), np.array(quads, np.int64), np.array(groups))


@cache
def _target_names(wheel: Path) -> tuple[str, ...]:
    with zipfile.ZipFile(wheel) as package:
        names = [name for name in package.namelist() if name.startswith(_TARGETS) and name.endswith(_SUFFIX)]
    return tuple(sorted(name[len(_TARGETS) : -len(_SUFFIX)] for name in names))


@cache
def _target(wheel: Path, name: str) -> NDArray[np.float64]:
    moved = np.zeros_like(_body_mesh(wheel).points)
    with zipfile.ZipFile(wheel) as package:
        text = gzip.decompress(package.read(f"{_TARGETS}{name}{_SUFFIX}")).decode("utf-8")
    for line in text.splitlines():
        words = line.split()
        if len(words) == 4 and not line.startswith("#"):
            moved[int(words[0])] = [float(word) for word in words[1:]]
    return _turned(moved)
