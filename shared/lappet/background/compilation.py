"""Compile procedures for the worker and remember the last ones: an edit that cuts nothing new makes no Boolean."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from lappet.anatomy.tissue_layers import LayerSearch, layer_search
from lappet.background.make_manifest import epoch_shapes, make_manifest
from lappet.background.manifest import EpochShape, Manifest
from lappet.background.manifest_key import manifest_key
from lappet.background.manifest_store import get_manifest, put_manifest
from lappet.checks.validation import check
from lappet.core.digest import digest
from lappet.core.problem import Problem, RefusedError
from lappet.cutting.epoch import Epoch
from lappet.cutting.epochs import build_epochs
from lappet.procedure import CUTS, Procedure
from lappet.program.compile import compile_program
from lappet.program.keys import frame_keys
from lappet.program.program import Program
from lappet.program.settings import SolverSettings, for_tissue
from lappet.solve.store import FrameStore

_KEPT = 4

Value = TypeVar("Value")


@dataclass(frozen=True, eq=False)
class Compiled:
    """A procedure made ready.

    Parameters
    ----------
    manifest
        Its manifest.
    program
        What the daemon is told.
    """

    manifest: Manifest
    program: Program


class Compilation:
    """The manifests and programs by their key; one thread at a time compiles, others wait for it.

    `epochs_built` counts how often epochs were built.

    Parameters
    ----------
    identity
        What identifies the solver, for the keys.
    store
        Where manifests are kept.
    """

    def __init__(self, identity: str, store: FrameStore) -> None:
        self.identity = identity
        self.epochs_built = 0
        self._store = store
        self._compiled: _Last[Compiled] = _Last(_KEPT)
        self._epochs: _Last[tuple[tuple[Epoch, ...], tuple[EpochShape, ...]]] = _Last(_KEPT)
        self._lock = threading.Lock()

    def manifest(self, procedure: Procedure, settings: SolverSettings, step: Callable[[], None]) -> Manifest:
        """Find the manifest of a procedure: remembered, from the store, or compiled.

        Parameters
        ----------
        procedure
            The procedure.
        settings
            How to solve.
        step
            Called between the steps; may raise to stop.

        Returns
        -------
        Manifest
            The manifest.
        """
        key = manifest_key(procedure, settings, self.identity)
        known = self._compiled.get(key)
        if known is not None:
            return known.manifest
        found = get_manifest(self._store, key)
        return found if found is not None else self.compiled(procedure, settings, step).manifest

    def compiled(self, procedure: Procedure, settings: SolverSettings, step: Callable[[], None]) -> Compiled:
        """Find the manifest and the program of a procedure.

        Parameters
        ----------
        procedure
            The procedure.
        settings
            How to solve.
        step
            Called between the steps; may raise to stop.

        Returns
        -------
        Compiled
            Both.

        Raises
        ------
        RefusedError
            If the procedure cannot be solved; holds every problem.
        """
        key = manifest_key(procedure, settings, self.identity)
        with self._lock:
            known = self._compiled.get(key)
            if known is None:
                known = self._compile(key, procedure, settings, step)
                self._compiled.put(key, known)
            return known

    def placed(
        self, before: Procedure, procedure: Procedure, settings: SolverSettings, step: Callable[[], None]
    ) -> Compiled:
        """Make a procedure ready that differs from another by a hook or retractor that a tool still places.

        It has the very surfaces of the other: a cut of its own, with the faces that are gripped as a group, would
        number the same vertices otherwise, and neither picture nor state would fit. So its frames are of no use to
        anybody else, and nothing of it is kept.

        Parameters
        ----------
        before
            The procedure without what is placed.
        procedure
            The procedure.
        settings
            How to solve.
        step
            Called between the steps; may raise to stop.

        Returns
        -------
        Compiled
            Manifest and program.

        Raises
        ------
        RefusedError
            If the procedure cannot be solved; holds every problem.
        """
        with self._lock:
            problems = _checked(procedure, settings)
            step()
            search = layer_search(before.tissue, before.materials)
            epochs, shapes = self._cut(_spaced(before, settings), search, step)
            fresh = {n: f for n, f in procedure.tissue.subsets.items() if n not in before.tissue.subsets}
            gripped = tuple(_gripping(each, shape, fresh) for each, shape in zip(epochs, shapes, strict=True))
            step()
            program = compile_program(procedure, gripped, settings)
            key = manifest_key(procedure, settings, self.identity)
            keys = frame_keys(program, self.identity)
            return Compiled(make_manifest(key, program, keys, shapes, search.layers, problems), program)

    def _compile(self, key: str, procedure: Procedure, settings: SolverSettings, step: Callable[[], None]) -> Compiled:
        step()
        problems = _checked(procedure, settings)
        step()
        search = layer_search(procedure.tissue, procedure.materials)
        epochs, shapes = self._cut(_spaced(procedure, settings), search, step)
        step()
        program = compile_program(
            procedure,
            epochs,
            settings,
        )
        step()
        manifest = make_manifest(key, program, frame_keys(program, self.identity), shapes, search.layers, problems)
        put_manifest(self._store, manifest)
        return Compiled(manifest, program)

    def _cut(
        self, procedure: Procedure, search: LayerSearch, step: Callable[[], None]
    ) -> tuple[tuple[Epoch, ...], tuple[EpochShape, ...]]:
        """The epochs of a procedure and what is shown of them: known by mesh, regions, cuts and spacing."""
        tissue = procedure.tissue
        mesh = (tissue.points, tissue.face_vertex_counts, tissue.face_vertex_indices, tissue.uv, tissue.subsets)
        cuts = tuple(replace(event, name="") for event in procedure.events if isinstance(event, CUTS))
        key = digest(mesh, tissue.regions, tissue.spacing, procedure.start_time, cuts).hex()
        known = self._epochs.get(key)
        if known is None:
            epochs = tuple(build_epochs(procedure))
            self.epochs_built += 1
            step()
            known = epochs, epoch_shapes(epochs, tissue, search)
            self._epochs.put(key, known)
        return known


def _checked(procedure: Procedure, settings: SolverSettings) -> list[Problem]:
    """What is to be said of a procedure; RefusedError where it cannot be solved."""
    problems = check(procedure, spacing=settings.spacing or None)
    if any(problem.severity == "error" for problem in problems):
        raise RefusedError(sorted(problems, key=lambda problem: problem.severity != "error"))
    return problems


def _spaced(procedure: Procedure, settings: SolverSettings) -> Procedure:
    spacing = for_tissue(settings, procedure.tissue).spacing
    return replace(procedure, tissue=replace(procedure.tissue, spacing=spacing))


def _gripping(epoch: Epoch, shape: EpochShape, groups: Mapping[str, NDArray[np.int32]]) -> Epoch:
    """An epoch whose surface has some more groups of the tissue's faces."""
    masks = {name: np.isin(shape.face, faces) for name, faces in groups.items()}
    return replace(epoch, surface=replace(epoch.surface, grips={**epoch.surface.grips, **masks}))


def up_to(program: Program, last: int | None) -> Program:
    """Leave out the frames after a time code; the keys of the others stay what they are.

    Parameters
    ----------
    program
        The program.
    last
        The time code, or None for all frames.

    Returns
    -------
    Program
        The shorter program.
    """
    if last is None:
        return program
    kept = sum(frame.time <= last for frame in program.frames)
    return replace(program, frames=program.frames[:kept])


class _Last(Generic[Value]):
    """The values last used, by key."""

    def __init__(self, max_kept: int) -> None:
        self._max = max_kept
        self._values: OrderedDict[str, Value] = OrderedDict()
        self._lock = threading.Lock()

    def get(self, key: str) -> Value | None:
        with self._lock:
            if key in self._values:
                self._values.move_to_end(key)
            return self._values.get(key)

    def put(self, key: str, value: Value) -> None:
        with self._lock:
            self._values[key] = value
            self._values.move_to_end(key)
            while len(self._values) > self._max:
                self._values.popitem(last=False)
