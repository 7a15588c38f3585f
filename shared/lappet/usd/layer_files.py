"""The files of a stage, looked at before USD opens them: regular ones of USD's kinds, in the folder of the first.

`usd` is `lappet.usd.stage.pxr()` throughout; this module imports nothing of USD itself.
"""

from __future__ import annotations

import glob
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lappet.core.problem import refused
from lappet.core.problem_code import ProblemCode
from lappet.foreign.folder import Folder
from lappet.foreign.limits import ReadLimits
from lappet.foreign.regular_file import refuse_irregular, refuse_kind

SUFFIXES = (".usda", ".usdc", ".usd", ".usdz")
MAX_CLIPS = 100_000  # files of one set of value clips
_CLIPS = "clips"


class LayerFiles:
    """The layers of a stage, opened one by one, each after a look at its file.

    Layers that are missing or broken are left to USD, which names them when it composes the stage.

    Parameters
    ----------
    usd
        USD's modules, as `lappet.usd.stage.pxr` gives them.
    file
        The file of the root layer.
    limits
        What reading may take.
    """

    def __init__(self, usd: Any, file: Path, limits: ReadLimits) -> None:
        self._usd, self._file, self._limits = usd, file, limits
        self._folder = Folder(file, limits)
        self._bytes = 0

    def open_all(self, root: Any) -> list[Any]:
        """Open every layer that the root layer leads to.

        Parameters
        ----------
        root
            The root layer, open.

        Returns
        -------
        list[Any]
            The layers; while they are held USD does not read them again.

        Raises
        ------
        RefusedError
            If one of the files may not be read.
        """
        self._look(self._file, self._file.name)
        opened, known, waiting = [root], {root.identifier}, [root]
        while waiting:
            for path in self._paths(waiting.pop()):
                layer = None if path in known else self._open(path)
                known.add(path)
                if layer is not None:
                    opened.append(layer)
                    waiting.append(layer)
        return opened

    def refuse_used(self, stage: Any) -> None:
        """Refuse a stage that uses other files than those that were looked at, however it came to them.

        Parameters
        ----------
        stage
            The stage.

        Raises
        ------
        RefusedError
            If a file lies outside.
        """
        for layer in stage.GetUsedLayers(True):
            path = self._outer(layer.realPath)
            if path:
                self._folder.refuse_outside(Path(path), path)

    def _open(self, path: str) -> Any:
        try:
            return self._usd.Sdf.Layer.FindOrOpen(path)
        except self._usd.Tf.ErrorException:
            return None

    def _paths(self, layer: Any) -> Iterator[str]:
        """The files that a layer composes with, each after a look at it; clips are looked at and not opened."""
        for named in filter(None, layer.GetCompositionAssetDependencies()):  # "": another prim of the same layer
            path = self._path(layer, named)
            if self._look(Path(self._outer(path)), named):
                yield path
        for clips in _clip_sets(layer):
            for named in self._clip_files(clips):
                clip = Path(self._outer(self._path(layer, named)))
                self._look(clip, named)
                for found in _of_template(clip):
                    self._look(found, named)

    def _path(self, layer: Any, named: str) -> str:
        if named.startswith("`"):  # an expression, which may name anything
            if not self._limits.allow_external:
                raise refused(ProblemCode.READ_OUTSIDE, self._file, named, folder=self._file.parent)
            return ""
        path, _ = self._usd.Sdf.Layer.SplitIdentifier(named)
        found = str(self._usd.Sdf.ComputeAssetPathRelativeToLayer(layer, path))
        if "[" in found or Path(found).is_absolute():
            return found
        return str(Path(self._outer(layer.realPath)).parent / found)

    def _outer(self, path: str) -> str:
        """The file of a path into a package."""
        return path.partition("[")[0]

    def _look(self, path: Path, named: str) -> bool:
        """Whether a file is there that may be opened; refuses one that may not."""
        if path in (Path(), Path()):
            return False
        self._folder.refuse_outside(path, named)
        refuse_kind(path, SUFFIXES)
        try:
            refuse_irregular(path, self._limits)
            self._bytes += path.stat().st_size
        except OSError:
            return False
        if self._bytes > self._limits.size:
            found, most = f"{self._bytes / 2**20:.1f}", f"{self._limits.size / 2**20:g}"
            raise refused(ProblemCode.READ_SIZE, self._file, found, limit=most)
        return True

    def _clip_files(self, clips: Any) -> Iterator[str]:
        for key in ("assetPaths", "manifestAssetPath", "templateAssetPath"):
            value = clips.get(key)
            values = [] if value is None else [value] if isinstance(value, (str, self._usd.Sdf.AssetPath)) else value
            yield from (str(getattr(each, "path", each)) for each in values)
        span = float(clips.get("templateEndTime", 0.0)) - float(clips.get("templateStartTime", 0.0))
        stride = float(clips.get("templateStride", 1.0))
        if "templateStride" in clips and not (stride > 0.0 and math.isfinite(span) and span / stride < MAX_CLIPS):
            raise refused(ProblemCode.USD_CLIPS, self._file, f"{stride:g}", span=f"{span:g}", most=MAX_CLIPS)


def _of_template(path: Path) -> Iterator[Path]:
    """The files of a folder that a template of clips names; `path` may be looked up."""
    if "#" in path.name:
        name = "*".join(map(glob.escape, re.split("#+", path.name)))
        yield from path.parent.glob(name)


def _clip_sets(layer: Any) -> Iterator[Any]:
    """The sets of value clips of a layer's prims, those in variants too."""
    waiting = list(layer.rootPrims)
    while waiting:
        prim = waiting.pop()
        if prim.HasInfo(_CLIPS):
            yield from dict(prim.GetInfo(_CLIPS)).values()
        waiting += prim.nameChildren
        for variants in prim.variantSets:
            waiting += [variant.primSpec for variant in variants.variants.values()]
