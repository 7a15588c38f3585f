"""What drawing looks up in the surfaces of a procedure's epochs: found once each, and shared by all that is drawn."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from lappet.drawing.skin_fields import SKIN, WOUND_WALL, SkinNormals, border_chains
from lappet.drawing.skin_source import SkinEpoch
from lappet.drawing.suture_bites import BitesInto, TrianglesNear

Found = TypeVar("Found")


class EpochSearches:
    """Searches by epoch; a thread may make them before somebody asks.

    They depend on an epoch's name, its triangles and its place at rest alone, so procedures of equal epochs may share
    them. Two threads that ask at once may both search: what they find is the same.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[str, str], Any] = {}

    def normals(self, epoch: SkinEpoch, count: int) -> SkinNormals:
        """Find which skin each vertex touches.

        Parameters
        ----------
        epoch
            The epoch.
        count
            Number of its vertices.

        Returns
        -------
        SkinNormals
            The normals of its skin.
        """
        return self._once("normals", epoch, lambda: SkinNormals(epoch.triangles, epoch.origin, SKIN, count))

    def chains(self, epoch: SkinEpoch) -> list[NDArray[np.int32]]:
        """Find the lips of the wound.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        list[NDArray[np.int32]]
            Vertex indices of each chain, shape (k,) (`lappet.drawing.skin_fields.border_chains`).
        """
        return self._once("chains", epoch, lambda: border_chains(epoch.triangles, epoch.origin))

    def knows_chains(self, epoch: SkinEpoch) -> bool:
        """Tell whether the lips of an epoch were found before.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        bool
            Whether they were.
        """
        return ("chains", epoch.name) in self._found

    def skin_and_rim(self, epoch: SkinEpoch, count: int) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
        """Find the vertices of the skin, and those of them where the wound begins.

        Parameters
        ----------
        epoch
            The epoch.
        count
            Number of its vertices.

        Returns
        -------
        tuple[NDArray[np.int64], NDArray[np.int32]]
            Vertex indices, shapes (s,) and (r,), ascending.
        """

        def find() -> tuple[NDArray[np.int64], NDArray[np.int32]]:
            wall = np.zeros(count, bool)
            wall[epoch.triangles[epoch.origin == WOUND_WALL]] = True
            skin = self.normals(epoch, count).used
            return np.flatnonzero(skin), np.flatnonzero(skin & wall).astype(np.int32)

        return self._once("skin", epoch, find)

    def knows_skin(self, epoch: SkinEpoch) -> bool:
        """Tell whether `skin_and_rim` of an epoch was found before.

        Parameters
        ----------
        epoch
            The epoch.

        Returns
        -------
        bool
            Whether it was.
        """
        return ("skin", epoch.name) in self._found

    def near(self, epoch: SkinEpoch, rest: NDArray[np.float32]) -> TrianglesNear:
        """Make the search for triangles about a point at rest.

        Parameters
        ----------
        epoch
            The epoch.
        rest
            Its vertices at rest in mm, shape (n, 3).

        Returns
        -------
        TrianglesNear
            The search.
        """
        return self._once("near", epoch, lambda: TrianglesNear(rest, epoch.triangles))

    def bites(self, epoch: SkinEpoch, rest: NDArray[np.float32]) -> BitesInto:
        """Make the search for the points of the skin nearest to others at rest.

        Parameters
        ----------
        epoch
            The epoch.
        rest
            Its vertices at rest in mm, shape (n, 3).

        Returns
        -------
        BitesInto
            The search.
        """
        return self._once("bites", epoch, lambda: BitesInto(rest, epoch.triangles[epoch.origin == SKIN]))

    def _once(self, what: str, epoch: SkinEpoch, find: Callable[[], Found]) -> Found:
        key = (what, epoch.name)
        if key not in self._found:
            self._found[key] = find()
        found: Found = self._found[key]
        return found
